// One request to a device, and what ends it.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <host/expectation.hpp>
#include <host/round_trip.hpp>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ano::host {

/// How often a request is sent, and how long each send waits for an answer.
struct Patience {
    /// A request that may be repeated, and whose wait follows the round trips, is sent more often as long as not so much time has passed.
    static constexpr Duration repeated_for = std::chrono::seconds{1};

    /// The same for a question while no round trip of the device was measured.
    static constexpr Duration unknown_for = std::chrono::seconds{6};

    unsigned sends = 5;
    std::optional<Duration> wait{};    // std::nullopt: by the device's round trips
    Duration at_least{};               // minimum of a wait that is computed from round trips
    /// Shorter than `wait`: so long, where other frames of the device come in the second half of it.
    std::optional<Duration> if_heard{};
};

/// Which device a request is meant for (Device::identity()).
struct Identity {
    std::uint32_t device = 0;    // grows with each device info (0xE3) that differs from the one before
    std::uint32_t hardware =
        0;    // only with another type or hardware version: a loader may report other versions than the firmware
    friend bool operator==(const Identity&, const Identity&) = default;
};

/// DATA of one message, for a device.
struct Request {
    std::uint8_t id = 0;
    std::vector<std::uint8_t> data{};
    Patience patience{};
    std::uint32_t tag = 0;                 // chosen by the asker, and returned to it when the request ends
    bool urgent = false;                   // a command waits for its answer: it passes all but commands
    bool of_same = false;                  // only the device that is meant may answer: it is sent as one that acts
    std::optional<Identity> identity{};    // of the device that is meant; std::nullopt: the one that is there when it is asked
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
    unsigned sent = 0;                        // times
    std::optional<Duration> round_trip{};     // of this device, smoothed; std::nullopt: not measured yet
    bool is_heard = false;                    // some frame of the device came since the first send
    std::vector<std::uint8_t> unfit{};        // DATA of the last frame that should have been the answer and did not fit
    std::optional<std::uint8_t> by_port{};    // the port id that acknowledged instead of the device
    bool may_be_of_equal = false;             // an equal command waited as well: the acknowledgement may be its own
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
    bool is_urgent() const noexcept { return urgent_; }
    /// It commands or changes the device.
    bool acts() const noexcept { return acts_; }
    /// It must reach no other device than the one that is meant.
    bool is_of_same() const noexcept { return acts_ || of_same_; }
    Identity identity() const noexcept { return identity_; }
    void mean(Identity identity) noexcept { identity_ = identity; }
    /// It waits until the device is identified.
    bool is_held() const noexcept { return held_; }
    void hold() noexcept { held_ = true; }
    /// `passes`: its next send needs no identification.
    void release(bool passes) noexcept {
        held_ = false;
        passes_ = passes;
    }
    bool passes() const noexcept { return passes_; }
    /// How long it may be repeated, where each send has a fixed wait.
    Duration longest() const noexcept { return patience_.sends * patience_.wait.value_or(Duration{}); }

    /// A send of a request.
    struct Send {
        std::uint64_t number = 0;    // of the sends to the device, from 1
        bool alone = false;          // as in Window
        bool answers = false;        // the device has answered something since the send before
        std::size_t others = 0;      // requests on their way
        std::uint32_t doubts = 0;    // Device::doubts()
    };
    /// To be called when the frame is sent, for the first time or again.
    void send(TimePoint now, const RoundTrip& round_trip, const Send& send) noexcept;
    /// How long the send would wait for its answer.
    Duration wait_for_answer(const RoundTrip& round_trip, const Send& send) const noexcept;
    /// The next send is kept back for `time`, which is no time in which an answer could come. False: it was already.
    bool keep(TimePoint now, Duration time) noexcept;
    TimePoint kept_until() const noexcept { return kept_until_; }
    /// The device may be deaf to the next send, but may be flushed at `at` only: the wait for an answer ends there, and one more send follows.
    void flush_at(TimePoint at) noexcept {
        if (flush_at_ == TimePoint::min()) flush_at_ = at;
    }
    /// The frame that was sent last has not left yet: its wait begins anew.
    void wait_to_leave(TimePoint now) noexcept;
    /// To be called when the wait of Patience::if_heard is over. True: it waits on, since the device was not heard.
    bool waits_on(std::optional<TimePoint> heard_at) noexcept;
    std::uint64_t first_number() const noexcept { return first_number_; }
    const Send& last() const noexcept { return last_; }
    TimePoint last_sent() const noexcept { return last_sent_; }
    bool was_sent() const noexcept { return sent_ > 0; }
    /// The frame was sent, and its wait is not over.
    bool is_on_its_way() const noexcept { return on_its_way_; }
    /// To be called when the wait is over: the frame is to be sent again. False when it was sent as often as it may be.
    bool time_out(TimePoint now) noexcept {
        on_its_way_ = false;
        if (last_sent_ < flush_at_) return true;
        if (is_once() || !is_measured()) return sent_ < patience_.sends;
        return sent_ < patience_.sends ||
               now - first_sent_ - kept_for_ < (asks_often(known_) ? Patience::unknown_for : Patience::repeated_for);
    }
    /// A frame came that should have been the answer, and does not fit (Expectation::is_missed_by()). True: it was an
    /// acknowledgement, so there is nothing more to be waited for.
    bool miss(FrameView frame) {
        const auto size = std::min<std::size_t>(frame.data().size(), max_unfit);
        unfit_.assign(frame.data().begin(), frame.data().begin() + static_cast<std::ptrdiff_t>(size));
        return expects_->is_acknowledgement();
    }
    const std::vector<std::uint8_t>& unfit() const noexcept { return unfit_; }
    /// A loss of the first send costs the whole task, or seconds.
    bool waits_long() const noexcept { return is_once() || (!is_measured() && expects_->is_alone()); }
    TimePoint due() const noexcept { return due_; }
    /// An order that may be sent only once. An equal one is not sent as long as an answer to this one may come: it would be taken for its
    /// answer.
    bool is_once() const noexcept { return patience_.sends == 1 && expects_->is_alone(); }
    TimePoint first_sent() const noexcept { return first_sent_; }
    unsigned sent() const noexcept { return sent_; }
    /// The last send was waited for as long as the measured round trips told, and the device was not deaf for it.
    bool is_lost_by_measure() const noexcept { return is_measured() && known_ && last_sent_ >= flush_at_; }
    /// Round trips are measured only by requests without a fixed wait.
    bool is_measured() const noexcept { return !patience_.wait; }

private:
    static constexpr std::size_t max_unfit = 16;    // bytes

    std::vector<std::uint8_t> frame_;
    std::vector<std::uint8_t> unfit_;
    std::optional<Expectation> expects_;
    Patience patience_;
    Asker* asker_;
    std::uint32_t tag_;
    bool urgent_;
    bool of_same_;
    bool acts_ = false;
    bool held_ = false, passes_ = false;
    Identity identity_;
    unsigned sent_ = 0;
    // Until a round trip is measured, a loss says nothing about the time that an answer needs, and a question harms nobody.
    bool asks_often(bool known) const noexcept { return !known && is_measured() && !expects_->is_acknowledgement(); }

    bool on_its_way_ = false;
    bool known_ = false;    // a round trip of the device was measured before the last send
    TimePoint first_sent_{};
    TimePoint last_sent_{};
    std::uint64_t first_number_ = 0;
    Send last_{};
    TimePoint due_{};
    bool was_kept_ = false;    // its next send
    bool waits_on_ = false;    // longer than Patience::if_heard
    TimePoint kept_until_ = TimePoint::min();
    Duration kept_for_{};    // all sends
    TimePoint flush_at_ = TimePoint::min();
};

}    // namespace ano::host
