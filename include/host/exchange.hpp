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

/// How often is asked, and how long is waited for an answer each time.
struct Patience {
    unsigned sends = 5;
    std::optional<Duration> wait{};    // nothing: by the device's round trips, doubled after each loss
    Duration at_least{};               // where it is by the round trips
};

/// DATA of one message, for a device.
struct Request {
    std::uint8_t id = 0;
    std::vector<std::uint8_t> data{};
    Patience patience{};
    std::uint32_t tag = 0;    // the asker's own, told to it when the request ends
};

/// The request that `draft` (typed.hpp) is.
template <class Draft>
Request request(const Draft& draft, std::uint32_t tag = 0, Patience patience = {}) {
    std::vector<std::uint8_t> frame(overhead + draft.data_size());
    draft.encode(frame, 0, 0);
    return {Draft::message().id, {frame.begin() + header_size, frame.end() - 2}, patience, tag};
}

/// What is known of how a request went.
struct Evidence {
    unsigned sent = 0;                       // times
    std::optional<Duration> round_trip{};    // of this device, smoothed; nothing: it never answered at once
    bool is_heard = false;                   // the device said something, whatever, since it was asked first
};

/// Who asks, and is told what came of it.
class Asker;

/// One request on its way: sent, repeated, ended. Flow: send(), then on_time_out() when due(), until either says that it is over.
class Exchange {
public:
    /// `own` is the address of the host. is_askable() says whether anything can end it.
    Exchange(const Request& request, std::uint8_t own, std::uint8_t device, Asker* asker);

    bool is_askable() const noexcept { return expects_.has_value(); }
    const Expectation& expects() const noexcept { return *expects_; }
    /// Valid as long as the exchange is where it is.
    FrameView frame() const noexcept { return FrameView{frame_}; }
    Asker* asker() const noexcept { return asker_; }
    std::uint32_t tag() const noexcept { return tag_; }

    /// It leaves now, for the first time or again.
    void send(TimePoint now, const RoundTrip& round_trip) noexcept;
    bool was_sent() const noexcept { return sent_ > 0; }
    /// It was sent, and its time is not over.
    bool is_on_its_way() const noexcept { return on_its_way_; }
    /// Its time is over: it waits to be sent again. False when it was sent as often as it may be.
    bool time_out() noexcept {
        on_its_way_ = false;
        return sent_ < patience_.sends;
    }
    TimePoint due() const noexcept { return due_; }
    /// What may be sent only once is not asked again as long as an answer to the first may come: it would be taken for one to the second.
    bool is_once() const noexcept { return patience_.sends == 1; }
    TimePoint first_sent() const noexcept { return first_sent_; }
    unsigned sent() const noexcept { return sent_; }
    /// One that has a time of its own says nothing about the round trip.
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
