// The state of a CAN bus, from the error frames of the controller.
#pragma once
#include <link/link.hpp>

#include <linux/can.h>

#include <array>
#include <optional>
#include <string>

namespace anogate {

/// What to do about an interface that is bus-off.
std::string bus_off_text(const std::string& interface);

class CanBus {
public:
    static constexpr std::size_t error_kinds = 6;
    enum class State : std::uint8_t { active, warning, passive, off };

    /// `frame` must be an error frame.
    void note(const can_frame& frame, TimePoint now) noexcept;
    State state() const noexcept { return state_; }
    /// The controller was restarted: the earlier state no longer applies.
    void came_up() noexcept { state_ = State::active; }

    void add_facts(LinkFacts& facts, TimePoint now) const;
    /// What the user should know about the state; empty while the bus works.
    LinkError trouble(const std::string& interface) const;

private:
    enum Event : std::uint8_t { warning, passive, off, restarted, overflow, events };
    struct Seen {
        std::int64_t count = 0;
        TimePoint last{};
    };
    void seen(Event event, TimePoint now) noexcept {
        ++seen_[event].count;
        seen_[event].last = now;
    }

    State state_ = State::active;
    std::array<Seen, events> seen_{};
    std::int64_t error_frames_ = 0;
    std::array<std::int64_t, error_kinds> kinds_{};
};

}    // namespace anogate
