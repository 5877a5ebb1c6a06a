// One device as a host sees it: its device info, and the requests on their way to it.
//
// Flow:    device.ask(request, asker);                               // tasks do that: parameters.hpp, commands.hpp, ...
//          device.take(frame, now);                                  // every frame that comes from its side
//          while (const auto frame = device.next_frame(now)) ...     // after each of these, and at due(): to be sent now
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <host/exchange.hpp>
#include <host/window.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <string>

namespace ano::host {

/// What a device says of itself (0xE3).
struct DeviceInfo {
    std::uint8_t dev_id = 0;
    std::uint16_t hw_ver = 0, sw_ver = 0, bl_ver = 0, pt_ver = 0;
    std::string name;    // as received, in whatever encoding the device uses
    friend bool operator==(const DeviceInfo&, const DeviceInfo&) = default;
};

/// How a request ended.
enum class Outcome : std::uint8_t {
    answered,     // with data, or with the acknowledgement
    timeout,      // no answer came
    not_there,    // not sent: its parameter is beyond the count that the device has reported meanwhile
};

struct Ended {
    Outcome outcome;
    std::uint32_t tag;                  // of the request
    std::optional<FrameView> answer;    // of `answered`; refers to the frame given to take()
    Evidence evidence;
    bool device_answers;    // it answered some request since this one was first sent
};

class Asker {
public:
    /// A request ended. New ones may be asked here; the device may not be destroyed.
    virtual void ended(const Ended& ended, TimePoint now) = 0;

protected:
    ~Asker() = default;
};

/// What a frame meant for this device's requests.
enum class Taken : std::uint8_t {
    nothing,    // not an answer of this device to us
    ended,      // it ended a request
    doubled,    // it would have ended one that is answered already
    late,       // it answers one that was given up or cancelled
    unasked,    // an answer to no request of ours
    foreign,    // an answer to another host
};

/// There is one of these for each device, shared by all askers together with its window. At most Window::max_size requests are on
/// their way, and at most one that writes, commands or upgrades. Two that the same answer would end are sent one after the other.
///
/// No parameter id is sent before the number of parameters is known, nor one at or beyond that number: some firmware crashes on it.
class Device {
public:
    /// After so long a silence it may be another device: its device info is forgotten.
    static constexpr Duration away_after = std::chrono::seconds{30};
    /// An answer may come this long after its time-out. An equal request that may be sent only once waits until then.
    static constexpr Duration late_for = RoundTrip::ceiling;

    /// `address` is a device's, or a port id; `own` is the host's.
    explicit Device(std::uint8_t address, std::uint8_t own = address::host) : address_{address}, own_{own} {}
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    /// Queues a request. False, and `asker` will not be called, when no answer ends such a request, or its parameter does not exist.
    /// `asker` must live until its ended() or forget() was called.
    [[nodiscard]] bool ask(const Request& request, Asker& asker);
    /// `asker` is not called any more; its requests that wait are not sent.
    void forget(const Asker& asker) noexcept;

    /// To be called with every frame of the device. For a port id: also with frames of other sources, but only if they came by the links
    /// of that port and ended no request of another Device; otherwise the answers of several port ids could be mixed up.
    Taken take(FrameView frame, TimePoint now);
    /// The next frame to be sent at `now`; std::nullopt: none. It is valid until the next call of any function. Requests that ran out
    /// of time end here.
    std::optional<FrameView> next_frame(TimePoint now);
    /// When next_frame() has to be called again; TimePoint::min(): now; std::nullopt: no request is open.
    std::optional<TimePoint> due() const noexcept;

    std::uint8_t address() const noexcept { return address_; }
    std::uint8_t own() const noexcept { return own_; }
    /// As last reported (0xE3); std::nullopt before that, and when it was away since.
    const std::optional<DeviceInfo>& info() const noexcept { return info_; }
    /// As last reported (0xE0 1); std::nullopt as for info().
    std::optional<std::uint16_t> parameter_count() const noexcept { return parameter_count_; }
    /// Grows each time the device was away: what was known of it before may be wrong.
    std::uint32_t presence() const noexcept { return presence_; }
    std::optional<TimePoint> heard_at() const noexcept { return heard_at_; }
    const RoundTrip& round_trip() const noexcept { return round_trip_; }
    std::size_t window() const noexcept { return window_.size(); }
    std::size_t on_their_way() const noexcept;
    std::size_t waiting() const noexcept { return waiting_.size(); }

private:
    using Exchanges = std::list<Exchange>;    // in the order in which they were first sent, or queued
    struct Past {
        Expectation expects;
        bool answered;
        TimePoint late_until;    // of a request that may be sent only once
    };

    void hear(FrameView frame, TimePoint now);
    Taken past(FrameView frame) noexcept;
    void remember(const Exchange& exchange, bool answered) noexcept;
    void expire(TimePoint now);
    void end(Exchanges& from, Exchanges::iterator which, Outcome outcome, std::optional<FrameView> answer, TimePoint now);
    bool may_be_asked(FrameView request) const noexcept;
    std::optional<TimePoint> may_start_at(const Exchange& exchange) const noexcept;
    const Exchange* lost() const noexcept;
    const Exchange* next_to_send(TimePoint now) const noexcept;
    FrameView send(Exchanges& from, Exchanges::iterator which, TimePoint now) noexcept;
    Evidence evidence_of(const Exchange& exchange) const noexcept {
        return {exchange.sent(), round_trip_.smoothed(), exchange.was_sent() && heard_at_ && *heard_at_ > exchange.first_sent()};
    }

    std::uint8_t address_;
    std::uint8_t own_;
    std::optional<DeviceInfo> info_;
    std::optional<std::uint16_t> parameter_count_;
    std::optional<TimePoint> heard_at_;
    std::optional<TimePoint> answered_at_;
    std::uint32_t presence_ = 0;
    RoundTrip round_trip_;
    Window window_;
    Exchanges sent_;
    Exchanges waiting_;
    std::array<std::optional<Past>, 32> past_{};    // of the last exchanges
    std::size_t next_past_ = 0;
};

}    // namespace ano::host
