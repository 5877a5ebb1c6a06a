// The commands that a device defines (0xC0 to 0xC2; protocol text, section 4): reads their descriptions, and calls one.
#pragma once
#include <ano/frame.hpp>
#include <ano/schema.hpp>
#include <ano/values.hpp>
#include <host/description_cache.hpp>
#include <host/gather.hpp>
#include <host/value.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ano::host {

struct CommandInfo {
    std::uint16_t id = 0;    // its place in the list
    std::array<std::uint8_t, 3> cid{};
    std::vector<Type> types{};        // of its values
    bool has_unknown_type = false;    // then it can't be called
    std::string name{};               // as received, in whatever encoding the device uses; so is info
    std::string info{};
    std::vector<std::uint8_t> numbers{};    // the value types as the device sends them
    bool has_open_type =
        false;    // has a value type 7, and its meaning is not known: `types` has f32 for it, and it can't be called
    std::uint32_t doubts = 0, presence = 0;    // Device::doubts() and presence() when it was described
    friend bool operator==(const CommandInfo&, const CommandInfo&) = default;
};

/// The description in `frame`; std::nullopt when it is not a 0xC2, or too short for one. Value type 7 is left open.
std::optional<CommandInfo> command_info_in(FrameView frame);
/// The same where value type 7 means `seven`.
CommandInfo with_type_7(CommandInfo info, ValueType7 seven);

/// What value type 7 means, as the types of this command were understood; std::nullopt: it takes none, or that is open.
std::optional<ValueType7> shown_type_7(const CommandInfo& info) noexcept;

/// Null: no command has this name, or several have it.
const CommandInfo* find_command(std::span<const CommandInfo> all, std::string_view name) noexcept;

/// Whether both descriptions are of the same command: what the values mean is understood elsewhere.
bool is_same_command(const CommandInfo& one, const CommandInfo& other) noexcept;

using CommandCache = DescriptionCacheOf<CommandInfo>;
/// The commands of `device` as read before; null: they are not known, or it was away since. Valid as CommandCache::find() says.
const std::vector<CommandInfo>* known_commands(CommandCache& cache, const Device& device, TimePoint now);

/// Reads the number of commands and every description, and beside them the device info if it is not known: without it the cache
/// would not know the device again.
///
/// Value type 7 of 0xC2 is f32 in older generations of devices, u64 in the newest. A command with a type 8, 9 or 10 shows the newest
/// one; parameter descriptions with min and max (0xE2), of which one is read then, show an older one. Otherwise it is left open.
class Commands final : public Gather {
public:
    /// `seven`: what the device means by value type 7, whatever it shows; std::nullopt: what it shows. `cache`, which may be null and
    /// outlives this, gets what was read, without `seven`.
    explicit Commands(Device& device, std::optional<ValueType7> seven = std::nullopt, CommandCache* cache = nullptr)
        : Gather{device}, seven_{seven}, cache_{cache} {}

    void read(TimePoint now);

    /// Descriptions that did not come have no name.
    const std::vector<CommandInfo>& descriptions() const noexcept { return descriptions_; }
    const CommandInfo* find(std::string_view name) const noexcept { return find_command(descriptions_, name); }

private:
    enum Step : std::uint32_t { ask_count = first_step, ask_count_again, ask_info, ask_parameter_count, ask_parameter };

    static Request how_many(std::uint32_t tag);
    void counted(const Ended& ended, TimePoint now);
    void look_at_a_parameter(TimePoint now);
    void complete(std::optional<ValueType7> shown, TimePoint now);
    Request question(std::uint32_t i) override;
    bool took(std::uint32_t i, FrameView answer) override;
    void gathered(TimePoint now) override { ask(how_many(ask_count_again), now); }
    Request probe() override { return how_many(0); }
    void step_ended(const Ended& ended, TimePoint now) override;
    std::string_view subject() const noexcept override { return "commands"; }

    std::optional<ValueType7> seven_;
    CommandCache* cache_;
    std::uint32_t presence_ = 0;
    static constexpr int more_rounds = 3;    // for descriptions that did not come
    std::uint32_t asked_for(std::uint32_t question) const { return wanted_.empty() ? question : wanted_[question]; }

    std::vector<CommandInfo> descriptions_;
    std::vector<std::uint32_t> wanted_;    // by question, when only some are asked for again; empty: all
    int again_ = 0;
};

/// The commands of `device` as read last, whether or not it was away since; each has to be confirmed unless Device::is_certain_since() its
/// doubts. Null: they are not known, or the device has reported otherwise since. Valid as CommandCache::find() says.
const std::vector<CommandInfo>* commands_read_last(CommandCache& cache, const Device& device);

/// Asks the device whether a command that it described earlier is still the same, before everything else that is asked of it; and who it is
/// at the same time.
class CommandCheck final : public Task {
public:
    /// What is known at its end.
    enum class Found : std::uint8_t {
        same,
        another,        // the command in its place is another one, or the device reported other versions meanwhile
        unconfirmed,    // no answer from a device that was not away, or that is silent but may hear: the command may be LAND
        unknown,        // no answer, but it is heard, and was away since: it may be another device
        interrupted,    // no answer, but the link was down meanwhile, or before and it was not heard since
    };

    /// `cache` must outlive this; it learns that the command is confirmed.
    CommandCheck(Device& device, CommandInfo known, CommandCache& cache)
        : Task{device}, known_{std::move(known)}, cache_{cache} {}

    void start(TimePoint now);
    void ended(const Ended& ended, TimePoint now) override;
    Found found() const noexcept { return found_; }

private:
    Found found_without_answer(TimePoint now) const;

    CommandInfo known_;
    CommandCache& cache_;
    std::uint32_t losses_ = 0;    // Device::losses() when it asked
    Found found_ = Found::unconfirmed;
};

/// Calls one command. There is no negative answer, and a repeated frame runs it again, so it is sent once, and silence for 2 s is
/// `unknown`: it may have been carried out, or the device does not know it. With `repeat` it is sent five times, and silence is
/// `timeout`. Values that do not fit in number, type or range, or are of an open type, are `invalid`, and nothing is sent.
class CommandCall final : public Task {
public:
    CommandCall(Device& device, CommandInfo command, std::vector<AnyValue> values, bool repeat = false);

    void start(TimePoint now);
    void cancel(TimePoint now) override;
    void ended(const Ended& ended, TimePoint now) override;

private:
    std::string order() const override { return "command " + command_.name; }
    /// Appends the values to `out`. Returns why they do not fit, as a clause; std::nullopt: they fit.
    std::optional<std::string> pack(std::vector<std::uint8_t>& out) const;

    CommandInfo command_;
    std::vector<AnyValue> values_;
    bool repeat_;
};

}    // namespace ano::host
