// One request to a device, and the answer that ends it.
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
    /// A request that may be repeated, and whose wait follows the round trips, is repeated until this time has passed, even
    /// beyond `sends`.
    static constexpr Duration repeated_for = std::chrono::seconds{1};

    /// The same for a question while no round trip of the device has been measured.
    static constexpr Duration unknown_for = std::chrono::seconds{6};

    unsigned sends = 5;
    std::optional<Duration> wait{};    // std::nullopt: from the device's round trips
    Duration at_least{};               // minimum of a wait computed from round trips
    /// How late the acknowledgement may be while the device answers nothing, not even which device it is.
    Duration late{};
    /// If frames of the device arrive, a request whose wait follows the round trips is repeated for this time at least: the answer
    /// may be late although others are not. Beyond `repeated_for` it is repeated every `late_interval`.
    Duration if_late{};
    static constexpr Duration late_interval = std::chrono::milliseconds{500};
    /// A shorter wait than `wait`, used if other frames of the device arrive in the second half of it.
    std::optional<Duration> if_heard{};
};

/// Which device a request is meant for (Device::identity()).
struct Identity {
    std::uint32_t device = 0;    // increases with each device info (0xE3) that differs from the previous one
    std::uint32_t hardware =
        0;    // increases only with another type or hardware version: a loader may report other versions than the firmware
    friend bool operator==(const Identity&, const Identity&) = default;
};

/// DATA of one message, for a device.
struct Request {
    std::uint8_t id = 0;
    std::vector<std::uint8_t> data{};
    Patience patience{};
    std::uint32_t tag = 0;                 // chosen by the asker, and passed to it when the request ends
    bool urgent = false;                   // a command waits for its answer: it goes before all requests except commands
    bool of_same = false;                  // only the intended device may answer: treated like a request that acts
    std::optional<Identity> identity{};    // of the intended device; std::nullopt: the one that is there when it is asked
    bool needs_info = false;               // if it acts: the device info is requested first if it was never received
    bool compares_info = false;            // the device info is requested again first if no two of them were compared
    bool present_device = false;           // the intended device is the one that is present when the request is first sent
};

/// The request to send `draft` (typed.hpp).
template <class Draft>
Request request(const Draft& draft, std::uint32_t tag = 0, Patience patience = {}) {
    std::vector<std::uint8_t> frame(overhead + draft.data_size());
    draft.encode(frame, 0, 0);
    return {Draft::message().id, {frame.begin() + header_size, frame.end() - 2}, patience, tag};
}

/// The data collected about a request that ended.
struct Evidence {
    unsigned sent = 0;                        // times
    std::optional<Duration> round_trip{};     // of this device, smoothed; std::nullopt: not measured yet
    bool is_heard = false;                    // any frame of the device was received since the first send
    std::vector<std::uint8_t> unfit{};        // DATA of the last frame that had the form of the answer and did not fit
    std::optional<std::uint8_t> by_port{};    // the port id that acknowledged instead of the device
    bool may_be_of_equal = false;             // an equal command was waiting too: the acknowledgement may belong to it
};

/// The sender of requests, which is called when they end.
class Asker;

/// One open request. Flow: send(), then time_out() at due(); while that returns true, send() again.
class Exchange {
public:
    /// `own` is the address of the host. is_askable() shows whether any frame can end the request.
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
    /// It may only be sent to the intended device.
    bool is_of_same() const noexcept { return acts_ || of_same_; }
    Identity identity() const noexcept { return identity_; }
    bool needs_info() const noexcept { return needs_info_; }
    bool compares_info() const noexcept { return compares_info_; }
    /// No device is intended yet.
    bool means_present_device() const noexcept { return present_device_ && !was_sent(); }
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
    Duration late() const noexcept { return patience_.late; }    // Patience::late
    /// The longest time of its repetitions, if each send has a fixed wait.
    Duration longest() const noexcept { return patience_.sends * patience_.wait.value_or(Duration{}); }

    /// One send of a request.
    struct Send {
        std::uint64_t number = 0;    // number among the sends to the device, from 1
        bool alone = false;          // as in Window
        bool answers = false;        // the device has answered any request since the previous send
        std::size_t others = 0;      // requests in flight
        std::uint32_t doubts = 0;    // Device::doubts()
        bool is_known = false;       // the device info of the device had been received
    };
    /// To be called when the frame is sent, for the first time or again.
    void send(TimePoint now, const RoundTrip& round_trip, const Send& send) noexcept;
    /// The acknowledgement may take this long, as those before did.
    void wait_at_least(Duration time) noexcept { patience_.at_least = std::max(patience_.at_least, time); }
    /// How long the send would wait for its answer.
    Duration wait_for_answer(TimePoint now, const RoundTrip& round_trip, const Send& send) const noexcept;
    /// Delays the next send by `time`; no answer can arrive in that time. False: it was delayed before.
    bool keep(TimePoint now, Duration time) noexcept;
    TimePoint kept_until() const noexcept { return kept_until_; }
    /// The parser of the device may not accept the next send, but a flush is allowed only at `at`: the wait for an answer ends
    /// then, and one more send follows.
    void flush_at(TimePoint at) noexcept {
        if (flush_at_ == TimePoint::min()) flush_at_ = at;
    }
    /// The answer to the first send may take `time` from now. What this adds to its wait does not shorten the repetitions.
    void wait_from(TimePoint now, Duration time) noexcept {
        if (sent_ != 1 || !on_its_way_ || !is_measured() || last_sent_ < flush_at_) return;
        kept_for_ += std::max(now + time - due_, Duration::zero());
        due_ = std::max(due_, now + time);
    }
    /// No answer to the last send will arrive.
    void stop_waiting(TimePoint now) noexcept { due_ = std::min(due_, now); }
    /// The last frame has not left yet: its wait starts again.
    void wait_to_leave(TimePoint now) noexcept;
    /// To be called when the wait of Patience::if_heard is over. True: the wait continues, since no frame of the device was
    /// received.
    bool waits_on(std::optional<TimePoint> heard_at) noexcept;
    std::uint64_t first_number() const noexcept { return first_number_; }
    const Send& last() const noexcept { return last_; }
    TimePoint last_sent() const noexcept { return last_sent_; }
    bool was_sent() const noexcept { return sent_ > 0; }
    /// The frame was sent, and its wait is not over.
    bool is_on_its_way() const noexcept { return on_its_way_; }
    /// To be called when the wait is over: the frame must be sent again. False if all sends are used. `is_heard`: a frame of the
    /// device was received since the first send.
    bool time_out(TimePoint now, bool is_heard) noexcept {
        on_its_way_ = false;
        if (last_sent_ < flush_at_) return true;
        if (is_once() || !is_measured()) return sent_ < patience_.sends;
        Duration repeated_for = asks_often(known_) ? Patience::unknown_for : Patience::repeated_for;
        if (is_heard) repeated_for = std::max(repeated_for, patience_.if_late);
        return sent_ < patience_.sends || now - first_sent_ - kept_for_ < repeated_for;
    }
    /// A frame was received that has the form of the answer, but does not fit (Expectation::is_missed_by()). True: it was an
    /// acknowledgement, so no other answer will follow.
    bool miss(FrameView frame) {
        const auto size = std::min<std::size_t>(frame.data().size(), max_unfit);
        unfit_.assign(frame.data().begin(), frame.data().begin() + static_cast<std::ptrdiff_t>(size));
        return expects_->is_acknowledgement();
    }
    const std::vector<std::uint8_t>& unfit() const noexcept { return unfit_; }
    /// If the first send is lost, the whole task fails, or seconds are lost.
    bool waits_long() const noexcept { return is_once() || (!is_measured() && expects_->is_alone()); }
    TimePoint due() const noexcept { return due_; }
    /// An order that may be sent only once. An equal one is not sent while an answer to this one may still arrive: that answer
    /// would be assigned to the other one.
    bool is_once() const noexcept { return patience_.sends == 1 && expects_->is_alone(); }
    TimePoint first_sent() const noexcept { return first_sent_; }
    unsigned sent() const noexcept { return sent_; }
    /// The last send was waited for as long as the measured round trips require, and the parser of the device was ready for it.
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
    bool of_same_, needs_info_, compares_info_, present_device_;
    bool acts_ = false;
    bool held_ = false, passes_ = false;
    Identity identity_;
    unsigned sent_ = 0;
    // Until a round trip is measured, a loss does not show how much time an answer needs, and a repeated question does no harm.
    bool asks_often(bool known) const noexcept { return !known && is_measured() && !expects_->is_acknowledgement(); }

    bool on_its_way_ = false;
    bool known_ = false;    // a round trip of the device was measured before the last send
    TimePoint first_sent_{};
    TimePoint last_sent_{};
    std::uint64_t first_number_ = 0;
    Send last_{};
    TimePoint due_{};
    bool was_kept_ = false;    // the next send
    bool waits_on_ = false;    // longer than Patience::if_heard
    TimePoint kept_until_ = TimePoint::min();
    Duration kept_for_{};    // for all sends
    TimePoint flush_at_ = TimePoint::min();
};

}    // namespace ano::host
