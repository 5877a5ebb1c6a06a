// One device as a host sees it: what it said of itself, and the requests on their way to it.
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
    std::string name;    // as it came: in whatever encoding the device uses
    friend bool operator==(const DeviceInfo&, const DeviceInfo&) = default;
};

/// How a request ended.
enum class Outcome : std::uint8_t {
    answered,     // by data, or by the acknowledgement
    timeout,      // by silence
    not_there,    // by ourselves: its parameter is beyond the count that the device told meanwhile
};

struct Ended {
    Outcome outcome;
    std::uint32_t tag;                  // of the request
    std::optional<FrameView> answer;    // of `answered`; refers to the frame given to take()
    Evidence evidence;
    bool device_answers;    // it answered something since this was sent first
};

class Asker {
public:
    /// A request ended. New ones may be asked here; the device may not be destroyed.
    virtual void ended(const Ended& ended, TimePoint now) = 0;

protected:
    ~Asker() = default;
};

/// What a frame was to this device's requests.
enum class Taken : std::uint8_t {
    nothing,    // no answer of this device to us
    ended,      // it ended a request
    doubled,    // it would have ended one that is answered already
    late,       // it answers one that was given up or cancelled
    unasked,    // an answer to no request of ours
    foreign,    // an answer to another host
};

/// Each device has one of these, whoever asks: its window is shared. At most Window::max_size requests are on their way, of those that
/// write, command or upgrade one. Two that the same answer would end go one after the other.
///
/// An id at or beyond the number of parameters is never sent, and none before that number is known: some firmware crashes on it.
class Device {
public:
    /// Silent for so long, it may have become another one: what it said of itself is forgotten.
    static constexpr Duration away_after = std::chrono::seconds{30};
    /// An answer may come so long behind the time in which it was awaited. An equal request that may be sent only once waits for that.
    static constexpr Duration late_for = RoundTrip::ceiling;

    /// `address` is a device's, or a port id; `own` is the host's.
    explicit Device(std::uint8_t address, std::uint8_t own = address::host) : address_{address}, own_{own} {}
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    /// Queues a request. False, and nothing will be told, when nothing ends such a request, or its parameter is not there.
    /// `asker` must be there until it was told, or forget() was called.
    [[nodiscard]] bool ask(const Request& request, Asker& asker);
    /// Nothing is told to `asker` any more; its requests that wait are not sent.
    void forget(const Asker& asker) noexcept;

    /// Of one at a port id: its own frames, and those of others only where they came by the links that the port id stands for, and
    /// ended no request of another Device. Who asks several port ids at once would mix their answers otherwise.
    Taken take(FrameView frame, TimePoint now);
    /// What is to be sent at `now`, one by one; valid until the next call of any function. Requests that ran out of time end here.
    std::optional<FrameView> next_frame(TimePoint now);
    /// When next_frame() has to be asked again; TimePoint::min(): now. Nothing while nothing is asked.
    std::optional<TimePoint> due() const noexcept;

    std::uint8_t address() const noexcept { return address_; }
    std::uint8_t own() const noexcept { return own_; }
    /// As last told (0xE3); nothing before, or when it was away since.
    const std::optional<DeviceInfo>& info() const noexcept { return info_; }
    /// As last told (0xE0 1).
    std::optional<std::uint16_t> parameter_count() const noexcept { return parameter_count_; }
    /// Grows each time the device was away: what was known of it before is not to be relied on.
    std::uint32_t presence() const noexcept { return presence_; }
    std::optional<TimePoint> heard_at() const noexcept { return heard_at_; }
    const RoundTrip& round_trip() const noexcept { return round_trip_; }
    std::size_t window() const noexcept { return window_.size(); }
    std::size_t on_their_way() const noexcept;
    std::size_t waiting() const noexcept { return waiting_.size(); }

private:
    using Exchanges = std::list<Exchange>;    // those that were sent, the oldest first
    struct Past {
        Expectation expects;
        bool answered;
        TimePoint late_until;    // of one that may be sent only once
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
