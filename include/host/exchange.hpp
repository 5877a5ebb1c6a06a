// One request to a device, and what ends it.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <host/expectation.hpp>
#include <host/round_trip.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ano::host {

/// How often a request is sent, and how long each send waits for an answer.
struct Patience {
    unsigned sends = 5;
    std::optional<Duration> wait{};    // std::nullopt: by the device's round trips, doubled after each loss
    Duration at_least{};               // minimum of a wait that is computed from round trips
};

/// DATA of one message, for a device.
struct Request {
    std::uint8_t id = 0;
    std::vector<std::uint8_t> data{};
    Patience patience{};
    std::uint32_t tag = 0;    // chosen by the asker, and returned to it when the request ends
};

/// The request to send `draft` (typed.hpp).
template <class Draft>
Request request(const Draft& draft, std::uint32_t tag = 0, Patience patience = {}) {
    std::vector<std::uint8_t> frame(overhead + draft.data_size());
    draft.encode(frame, 0, 0);
    return {Draft::message().id, {frame.begin() + header_size, frame.end() - 2}, patience, tag};
}

/// What is known about a request that ended.
struct Evidence {
    unsigned sent = 0;                       // times
    std::optional<Duration> round_trip{};    // of this device, smoothed; std::nullopt: not measured yet
    bool is_heard = false;                   // some frame of the device came since the first send
};

/// The sender of requests, which is called when they end.
class Asker;

/// One request on its way. Flow: send(), then time_out() at due(); while that returns true, send() again.
class Exchange {
public:
    /// `own` is the address of the host. is_askable() says whether anything can end it.
    Exchange(const Request& request, std::uint8_t own, std::uint8_t device, Asker* asker);

    bool is_askable() const noexcept { return expects_.has_value(); }
    const Expectation& expects() const noexcept { return *expects_; }
    /// Valid until the exchange is moved or destroyed.
    FrameView frame() const noexcept { return FrameView{frame_}; }
    Asker* asker() const noexcept { return asker_; }
    std::uint32_t tag() const noexcept { return tag_; }

    /// To be called when the frame is sent, for the first time or again.
    void send(TimePoint now, const RoundTrip& round_trip) noexcept;
    bool was_sent() const noexcept { return sent_ > 0; }
    /// The frame was sent, and its wait is not over.
    bool is_on_its_way() const noexcept { return on_its_way_; }
    /// To be called when the wait is over: the frame is to be sent again. False when it was sent as often as it may be.
    bool time_out() noexcept {
        on_its_way_ = false;
        return sent_ < patience_.sends;
    }
    TimePoint due() const noexcept { return due_; }
    /// May be sent only once. An equal request is not sent as long as an answer to this one may come: it would be taken for its answer.
    bool is_once() const noexcept { return patience_.sends == 1; }
    TimePoint first_sent() const noexcept { return first_sent_; }
    unsigned sent() const noexcept { return sent_; }
    /// Round trips are measured only by requests without a fixed wait.
    bool is_measured() const noexcept { return !patience_.wait; }

private:
    std::vector<std::uint8_t> frame_;
    std::optional<Expectation> expects_;
    Patience patience_;
    Asker* asker_;
    std::uint32_t tag_;
    unsigned sent_ = 0;
    bool on_its_way_ = false;
    TimePoint first_sent_{};
    TimePoint due_{};
};

}    // namespace ano::host
