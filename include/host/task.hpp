// An operation on a device: progress, cancel, and a result.
#pragma once
#include <ano/fault.hpp>
#include <host/device.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace ano::host {

/// How a task ended.
enum class Ending : std::uint8_t {
    done,
    timeout,        // the device does not answer
    incomplete,     // it answers, but not everything was received
    unknown,        // no answer to a frame that may not be repeated: it may have been carried out
    refused,        // the device rejects it
    failed,         // the device tried, without success
    invalid,        // not sent, because the request would be wrong
    unsupported,    // the device does not provide a needed function
    cancelled,
};
inline constexpr std::array<std::string_view, 9> ending_names{"done",   "timeout", "incomplete",  "unknown",  "refused",
                                                              "failed", "invalid", "unsupported", "cancelled"};
constexpr std::string_view name_of(Ending ending) noexcept { return ending_names[static_cast<std::size_t>(ending)]; }

struct End {
    Ending ending = Ending::done;
    Fault fault;    // the reason; if done: a remark, or empty
    Evidence evidence{};
};

/// In the unit of the task: descriptions and values, waypoints, bytes. `total` is 0 while it is not known.
struct Progress {
    std::size_t done = 0;
    std::size_t total = 0;
};

/// "0xDC", the form of addresses for people.
std::string hex_of(std::uint8_t address);

/// The device must outlive its tasks. A task runs once, from its start(); its results can be read after its end.
class Task : public Asker {
public:
    explicit Task(Device& device) : device_{device}, identity_{device.identity()} {}
    virtual ~Task() { device_.forget(*this); }
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;

    /// std::nullopt until it has ended.
    const std::optional<End>& end() const noexcept { return end_; }
    virtual Progress progress() const noexcept { return {}; }
    /// Counted from the first request. It limits devices that always answer just before the time-out; the wait for the last
    /// request may exceed it.
    virtual Duration max_duration() const noexcept { return std::chrono::minutes{2}; }
    /// The intended device: the one that was there when the task was made, or when renew_identity() was called.
    Identity identity() const noexcept { return identity_; }
    /// Sets the intended device: for a task that is a part of another one.
    void mean(Identity identity) noexcept {
        identity_ = identity;
        is_meant_ = true;
    }
    /// The intended device is the one that is present when the first request is sent: for an order that needs no earlier data.
    void mean_present_device() noexcept { means_present_device_ = true; }
    /// Fields of the device info that vary must be known before its first request: what it starts can't be undone if they look like
    /// another device (Device::has_varying_info()).
    void compare_info() noexcept { compares_info_ = true; }
    /// It failed because another device has the address: no frame that acts was sent to that device.
    bool is_of_another() const noexcept { return is_of_another_; }
    void not_meant(const Ended& ended, TimePoint now) override;
    /// Ends the task; the end states what is half done. A task that must restore something first ends after that.
    virtual void cancel(TimePoint now);
    /// Called last when it ends. The task may not be destroyed in the call.
    void on_end(std::function<void(TimePoint)> callback) { on_end_ = std::move(callback); }

protected:
    Device& device() noexcept { return device_; }
    const Device& device() const noexcept { return device_; }
    /// Sends `request`, or ends as invalid.
    void ask(const Request& request, TimePoint now);
    /// The data known of the device was read just now: the intended device is the one that is there, unless mean() was called.
    void renew_identity() noexcept {
        if (!is_meant_) identity_ = device_.identity();
    }
    /// Whether another device than the intended one has the address.
    bool finds_another() const noexcept { return identity_ != device_.identity(); }
    /// To be called before finish(), where a part of the task found another device.
    void be_of_another() noexcept { is_of_another_ = true; }
    Fault another_device() const { return {"another_device", hex_of(device_.address())}; }
    /// Ends because another device has the address. `may_be_done`: the order that the previous device may have carried out, as a
    /// noun, and `left`: its state, as a clause; empty: nothing to report.
    void finish_another(Fault may_be_done, TimePoint now, Fault left = {});
    /// The acting request that the task sends, as a noun.
    virtual Fault order() const { return {}; }
    /// A clause that follows the reason for giving up: the state in which the device is left.
    virtual Fault half_done() const { return {}; }
    /// To be called before a request. True if it has taken longer than max_duration(): the task has ended.
    bool is_overdue(TimePoint now);
    /// Ends the task, unless it has ended; its requests are discarded.
    void finish(End end, TimePoint now);
    /// Ends without an answer to the question for `step`. `likely` is the probable reason if other frames of the device are
    /// received, as a clause.
    void finish_silent(const Fault& step, const Evidence& evidence, TimePoint now, const Fault& likely = {});
    /// The same for the device info, which every device should answer.
    void finish_without_info(const Fault& step, const Evidence& evidence, TimePoint now);
    /// The same for an order, which was not acknowledged.
    void finish_unacknowledged(const Fault& order, const Evidence& evidence, TimePoint now, const Fault& likely);
    /// If a port id acknowledged an order instead of the device: a clause about it; empty: the device acknowledged it.
    static Fault port_answer(const Evidence& evidence);
    /// Ends in the same way as `other`.
    void finish_as(const Task& other, TimePoint now);

private:
    using UnansweredId = FaultId<std::string, Fault, unsigned>;
    void finish_unanswered(UnansweredId if_heard, const Fault& step, const Evidence& evidence, TimePoint now,
                           const Fault& likely);

    Device& device_;
    Identity identity_;
    bool is_meant_ = false, is_of_another_ = false, means_present_device_ = false, compares_info_ = false;
    std::optional<TimePoint> begun_at_;
    std::optional<End> end_;
    std::function<void(TimePoint)> on_end_;
};

}    // namespace ano::host
