// The commands that a device defines (0xC0 to 0xC2; protocol text, section 4): reads their descriptions, and calls one.
#pragma once
#include <ano/frame.hpp>
#include <ano/schema.hpp>
#include <ano/values.hpp>
#include <host/gather.hpp>
#include <host/value.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ano::host {

struct CommandInfo {
    std::uint16_t id = 0;    // its place in the list
    std::array<std::uint8_t, 3> cid{};
    std::vector<Type> types{};        // of its values
    bool has_unknown_type = false;    // then it can't be called
    std::string name{};               // as received, in whatever encoding the device uses; so is info
    std::string info{};
    friend bool operator==(const CommandInfo&, const CommandInfo&) = default;
};

/// The description in `frame`; std::nullopt when it is not a 0xC2, or too short for one.
std::optional<CommandInfo> command_info_in(FrameView frame, ValueType7 seven);

/// Reads the number of commands and every description.
class Commands final : public Gather {
public:
    /// `seven`: what the device means by value type 7.
    explicit Commands(Device& device, ValueType7 seven = ValueType7::f32) : Gather{device}, seven_{seven} {}

    void read(TimePoint now) { ask(how_many(ask_count), now); }

    /// Descriptions that did not come have no name.
    const std::vector<CommandInfo>& descriptions() const noexcept { return descriptions_; }
    /// Null: no command has this name, or several have it.
    const CommandInfo* find(std::string_view name) const noexcept;

private:
    enum Step : std::uint32_t { ask_count = first_step, ask_count_again };

    static Request how_many(std::uint32_t tag);
    Request question(std::uint32_t i) override;
    bool took(std::uint32_t i, FrameView answer) override;
    void gathered(TimePoint now) override { ask(how_many(ask_count_again), now); }
    Request probe() override { return how_many(0); }
    void step_ended(const Ended& ended, TimePoint now) override;
    std::string_view subject() const noexcept override { return "commands"; }

    ValueType7 seven_;
    std::vector<CommandInfo> descriptions_;
};

/// Calls one command. There is no negative answer, and a repeated frame runs it again, so it is sent once, and silence for 2 s is
/// `unknown`: it may have been carried out, or the device does not know it. With `repeat` it is sent five times, and silence is
/// `timeout`. Values that do not fit in number, type or range are `invalid`, and nothing is sent.
class CommandCall final : public Task {
public:
    CommandCall(Device& device, CommandInfo command, std::vector<AnyValue> values, bool repeat = false);

    void start(TimePoint now);
    void cancel(TimePoint now) override;
    void ended(const Ended& ended, TimePoint now) override;

private:
    /// Appends the values to `out`. Returns why they do not fit, as a clause; std::nullopt: they fit.
    std::optional<std::string> pack(std::vector<std::uint8_t>& out) const;

    CommandInfo command_;
    std::vector<AnyValue> values_;
    bool repeat_;
};

}    // namespace ano::host
