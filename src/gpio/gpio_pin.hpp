// A GPIO line that is requested again while it is absent, in use by another program, or lost with its chip.
#pragma once
#include <gpio/gpio_line.hpp>
#include <link/reconnect.hpp>
#include <sys/descriptor.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

class GpioPin {
public:
    enum class Direction { in, out };

    /// `changed` is called when the line becomes held, is no longer held or the reason for that changes, and when an input
    /// changes: from the loop or from start(), never after stop().
    GpioPin(GpioSettings settings, Direction direction, asio::io_context& io, AlarmClock& alarms, std::function<void()> changed);

    void start();
    /// Releases the line, without changing an output.
    void stop();
    /// To be called when a chip was added, removed or changed its permissions: retries at once.
    void look();

    /// Sets an output, now and each time the line is acquired again.
    void set(bool active);
    /// The wanted value of an output; the last known value of an input.
    bool active() const noexcept { return active_; }

    bool is_held() const noexcept { return line_ != nullptr; }
    /// The reason why the line is not held.
    const std::string& error() const noexcept { return error_; }
    /// nullptr while the line is not held.
    const GpioLine* line() const noexcept { return line_.get(); }
    const GpioSettings& settings() const noexcept { return settings_; }

    /// Number of value changes: those made by us for an output, those counted by the kernel for an input.
    std::uint64_t edges() const noexcept { return edges_; }
    /// The time of the last edge; zero: none yet.
    TimePoint edge_at() const noexcept { return edge_at_; }

private:
    Opened<void> open();
    void not_held(std::string why);
    bool read_value();
    void read_edges();
    void lose();
    void count(std::uint64_t edges);

    GpioSettings settings_;
    Direction direction_;
    Descriptor events_;
    Reconnect reconnect_;
    std::function<void()> changed_;
    std::unique_ptr<GpioLine> line_;
    std::string error_ = "not tried yet";
    bool active_ = false;
    std::uint64_t edges_ = 0;
    TimePoint edge_at_{};
};

}    // namespace anogate
