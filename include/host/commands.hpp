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
    bool has_unknown_type = false;    // the command can't be called
    std::string name{};               // as received, in the encoding of the device, like info
    std::string info{};
    std::vector<std::uint8_t> numbers{};    // the value types as the device sends them
    bool has_open_type = false;    // has a value type 7 of unknown meaning: `types` has f32 for it, and it can't be called
    std::uint32_t signs = 0, presence = 0;    // Device::signs() and presence() when the description was read
    friend bool operator==(const CommandInfo&, const CommandInfo&) = default;
};

/// The description in `frame`; std::nullopt when it is not a 0xC2, or too short for one. Value type 7 is left open.
std::optional<CommandInfo> command_info_in(FrameView frame);
/// The same, if value type 7 means `seven`.
CommandInfo with_type_7(CommandInfo info, ValueType7 seven);

/// The meaning of value type 7 in the types of this command; std::nullopt: it has no such value, or the meaning is unknown.
std::optional<ValueType7> reported_type_7(const CommandInfo& info) noexcept;

/// nullptr: no command has this name, or several have it.
const CommandInfo* find_command(std::span<const CommandInfo> all, std::string_view name) noexcept;

/// Whether both descriptions are of the same command. The meaning of value type 7 is not compared.
bool is_same_command(const CommandInfo& one, const CommandInfo& other) noexcept;

using CommandCache = DescriptionCacheOf<CommandInfo>;
/// The commands of `device` as read before; nullptr: they are not known, or the device was away since. Valid as stated at
/// CommandCache::find().
const std::vector<CommandInfo>* known_commands(CommandCache& cache, const Device& device, TimePoint now);

/// Reads the number of commands and every description, and the device info if it is not known: the cache needs it to recognize
/// the device.
///
/// Value type 7 of 0xC2 is f32 in older generations of devices, u64 in the newest. A command with a type 8, 9 or 10 shows the
/// newest generation. Otherwise one parameter description is read: min and max in it (0xE2) show an older generation. Without
/// either the meaning is left open.
class Commands final : public Gather {
public:
    /// `seven`: the meaning of value type 7, which overrides what the descriptions show; std::nullopt: as they show. `cache` may
    /// be nullptr and must outlive this object; it stores what was read, without `seven`.
    explicit Commands(Device& device, std::optional<ValueType7> seven = std::nullopt, CommandCache* cache = nullptr)
        : Gather{device}, seven_{seven}, cache_{cache} {}

    void read(TimePoint now);

    /// Descriptions that were not received have no name.
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
    Fault subject() const override { return {"commands"}; }

    std::optional<ValueType7> seven_;
    CommandCache* cache_;
    std::uint32_t presence_ = 0;
    static constexpr int more_rounds = 3;    // for descriptions that were not received
    std::uint32_t asked_for(std::uint32_t question) const { return wanted_.empty() ? question : wanted_[question]; }

    std::vector<CommandInfo> descriptions_;
    std::vector<std::uint32_t> wanted_;    // by question, if only some are asked for again; empty: all
    int again_ = 0;
};

/// The commands of `device` as last read, even if it was away since; each must be confirmed unless Device::has_no_sign_since() its
/// signs. nullptr: they are not known, or the device has since reported different data. Valid as stated at CommandCache::find().
const std::vector<CommandInfo>* commands_read_last(CommandCache& cache, const Device& device);

/// Asks the device whether a command that it described earlier is still the same, and at the same time for its device info. Both
/// requests go before all others to this device.
class CommandCheck final : public Task {
public:
    /// The result.
    enum class Found : std::uint8_t {
        same,
        another,        // the command with this id is another one, or the device reported other versions meanwhile
        unconfirmed,    // no answer, but the device was not away, or is silent and may still receive: the command may be LAND
        unknown,        // no answer, but frames of it are received, and it was away since: it may be another device
        interrupted,    // no answer, but the link was down meanwhile, or was down before and the device was not heard since
    };

    /// `cache` must outlive this object; a confirmed command is marked in it.
    CommandCheck(Device& device, CommandInfo known, CommandCache& cache)
        : Task{device}, known_{std::move(known)}, cache_{cache} {}

    void start(TimePoint now);
    void ended(const Ended& ended, TimePoint now) override;
    Found found() const noexcept { return found_; }

private:
    Found found_without_answer(TimePoint now) const;

    CommandInfo known_;
    CommandCache& cache_;
    std::uint32_t losses_ = 0;    // Device::losses() when the question was sent
    Found found_ = Found::unconfirmed;
};

/// Calls one command. The protocol has no negative answer, and a device runs a repeated frame again. So the command is sent once,
/// and without an answer for 2 s the end is `unknown`: the command may have been carried out, or the device does not know it.
/// With `repeat` it is sent five times, and without an answer the end is `timeout`. If an equal command was sent before, and its
/// acknowledgement may still arrive, an acknowledgement ends it as `unknown` too. If the values do not fit in number, type or
/// range, or a type is open, the end is `invalid`, and nothing is sent.
class CommandCall final : public Task {
public:
    CommandCall(Device& device, CommandInfo command, std::vector<AnyValue> values, bool repeat = false);

    void start(TimePoint now);
    void cancel(TimePoint now) override;
    void ended(const Ended& ended, TimePoint now) override;

private:
    Fault order() const override;
    /// Its name; without one, order().
    Fault called() const { return command_.name.empty() ? order() : Fault{"other", command_.name}; }
    /// Appends the values to `out`. Returns the reason why they do not fit, as a clause; std::nullopt: they fit.
    Fault pack(std::vector<std::uint8_t>& out) const;

    CommandInfo command_;
    std::vector<AnyValue> values_;
    bool repeat_;
};

}    // namespace ano::host
