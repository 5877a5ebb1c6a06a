// Writes one parameter, and reads back what the device stored.
//
// Flow:    ParameterWrite write{device, info, 4.5};    // info: as the device describes it
//          write.start(now);                           // then drive the device until write.end()
#pragma once
#include <host/parameter_info.hpp>
#include <host/task.hpp>
#include <host/value.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ano::host {

struct WriteLimits {
    bool longer = false;                       // a text may be longer than the one that it replaces
    std::optional<std::size_t> max_bytes{};    // for any text: vendor_max_text if the device uses the vendor's parser
    bool beyond_range = false;                 // a number may lie outside the range that the device states for it
    double rounding = 0;                       // a real number that the device stored within this counts as written
};

/// Why a text of `size` bytes may not replace one of `had` bytes, as a clause that follows the text; empty: it may.
Misfit text_misfit(std::size_t size, std::size_t had, const WriteLimits& limits);

/// Why `value` may not be written to a parameter whose device states a range, as a clause that follows the value; empty: it may.
Misfit range_misfit(const AnyValue& value, const ParameterInfo& info, const WriteLimits& limits);

/// The old value is read first: by default a text may not be longer than the old one, and the old value shows whether the device
/// clamped the new one or stored nothing. Then the new value is written, acknowledged and read back; a different value is read
/// once more, since it may be a late answer. If the device was away meanwhile, the parameter count and this description are read
/// again first.
///
/// The read-back question is sent directly after the write, without waiting for the acknowledgement: one round trip. It can show
/// that the value is stored. It shows that the value is not stored only if the write was not repeated; otherwise the value is
/// read back afterwards, also if the write was not acknowledged.
///
/// Done: as written, or clamped. Refused: the device kept its old value, or does not answer the read-back. Failed: it became
/// another device. Invalid, and nothing was written: the value does not fit the type or the stated range, the device uses another
/// length for it, or the parameter does not exist.
class ParameterWrite final : public Task {
public:
    ParameterWrite(Device& device, ParameterInfo info, AnyValue value, WriteLimits limits = {});

    /// To be called before start(): sets the old value, which was read just now, so that it is not read again. `doubts`:
    /// Device::doubts() when it and the description were read; if there are later doubts, both are read again.
    void set_before(Bytes value, std::uint32_t doubts);
    /// The same without a value: `info` was valid for the device at that time.
    void set_known(std::uint32_t doubts) noexcept { doubts_ = doubts; }
    /// Device::doubts() when the description was last read or compared; std::nullopt: before start().
    std::optional<std::uint32_t> known() const noexcept { return doubts_; }
    void start(TimePoint now);
    Progress progress() const noexcept override { return {step_, 4}; }
    void cancel(TimePoint now) override;
    void ended(const Ended& ended, TimePoint now) override;

    const ParameterInfo& info() const noexcept { return info_; }
    const AnyValue& written() const noexcept { return value_; }
    /// std::nullopt while not known.
    std::optional<AnyValue> before() const { return before_ ? decoded(*before_) : std::nullopt; }
    std::optional<AnyValue> stored() const { return stored_ ? decoded(*stored_) : std::nullopt; }
    /// The device stored another value than the one written: this counts as success.
    bool is_clamped() const { return end() && end()->ending == Ending::done && !is_as_written(); }
    /// Whether the write was sent: the device may have stored it.
    bool was_sent() const noexcept { return was_sent_; }
    /// If was_sent() and this is false, only reading back shows whether the device stored the value.
    bool was_acknowledged() const noexcept { return was_sent_ && !silence_; }

private:
    enum Step : std::uint32_t { read_before, write_value, read_back, read_again, ask_count, recount, describe, read_early };
    using Wire = std::vector<std::uint8_t>;

    void not_meant(const Ended& ended, TimePoint now) override;
    void was_silent(const Evidence& evidence);
    Fault order() const override { return {"write_of", info_.name}; }
    void go_on(TimePoint now);
    void ask_description(TimePoint now);
    void described(const Ended& ended, TimePoint now);
    void ask_value(Step step, TimePoint now) {
        step_ = step;
        go_on(now);
    }
    void write(TimePoint now);
    void written(const Ended& ended, TimePoint now);
    void took(const Ended& ended, TimePoint now);
    void read_along(const Ended& ended, TimePoint now);
    void both_ended(TimePoint now);
    void finish_not_returned(const Ended& ended, TimePoint now);
    void compare(TimePoint now);
    bool same(const Wire& a, const Wire& b) const;
    bool is_as_written() const;
    std::optional<AnyValue> decoded(const Wire& bytes) const;
    void refuse(const Misfit& why, TimePoint now);

    ParameterInfo info_;
    AnyValue value_;
    WriteLimits limits_;
    Step step_ = read_before;
    bool was_sent_ = false;
    bool write_ended_ = false, early_ended_ = false;
    bool was_repeated_ = false;             // the write
    Evidence acknowledgement_;              // of the write
    std::optional<Evidence> silence_;       // set when the write was not acknowledged
    bool is_compared_ = false;              // a value that is neither the old nor the new one was read again
    std::optional<std::uint16_t> count_;    // of parameters, at the start
    static constexpr unsigned max_uncertain = 5;
    unsigned sends_ = 0;                     // of the write, not acknowledged
    unsigned uncertain_ = 0;                 // the number of Outcome::uncertain; after more, the write counts as not acknowledged
    std::optional<std::uint32_t> doubts_;    // Device::doubts() when `info` was read
    Wire wire_;
    std::optional<Wire> before_, stored_;
};

/// Actions of a device on all its parameters (0xE0 0x10).
enum class Action : std::uint16_t {
    restore_defaults = 0xAA,
    save = 0xAB,
    clear_accelerometer_calibration = 0x20,
    accelerometer_calibration_sent = 0x21,
    clear_compass_calibration = 0x30,
    store_compass_calibration = 0x31,
};
/// Waits 5 s for each send, since the device writes flash.
Request action(Action action, std::uint32_t tag = 0);

/// Ends as done when acknowledged, else as timeout.
class ParameterAction final : public Task {
public:
    ParameterAction(Device& device, Action action) : Task{device}, action_{action} {}
    void start(TimePoint now) { ask(host::action(action_), now); }
    void ended(const Ended& ended, TimePoint now) override;
    void cancel(TimePoint now) override;

private:
    Fault order() const override;

    Action action_;
};

}    // namespace ano::host
