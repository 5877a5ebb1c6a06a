// One device as a host sees it: its device info, and the open requests to it.
//
// Flow:    device.ask(request, asker);                               // tasks do that: parameters.hpp, commands.hpp, ...
//          device.take(frame, now);                                  // every frame that comes from its side
//          while (const auto frame = device.next_frame(now)) ...     // after each of these, and at due(): to be sent now
#pragma once
#include <ano/address.hpp>
#include <ano/flush.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <host/exchange.hpp>
#include <host/telemetry_pace.hpp>
#include <host/window.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ano::host {

/// The device's report about itself (0xE3).
struct DeviceInfo {
    std::uint8_t dev_id = 0;
    std::uint16_t hw_ver = 0, sw_ver = 0, bl_ver = 0, pt_ver = 0;
    std::string name;    // as received, in the encoding of the device
    friend bool operator==(const DeviceInfo&, const DeviceInfo&) = default;
};

/// How a request ended.
enum class Outcome : std::uint8_t {
    answered,        // with data, or with the acknowledgement
    timeout,         // no fitting answer; Evidence::unfit has one that does not fit
    not_there,       // not sent: its parameter is beyond the count that the device has reported meanwhile
    uncertain,       // a parameter write that is not repeated: the device may be another one since it was sent
    another,         // not sent, or not repeated: another device has this address now
    unidentified,    // not sent: the device may be another one, and does not answer the device info request that `evidence` is of
};

struct Ended {
    Outcome outcome;
    std::uint32_t tag;                  // of the request
    std::optional<FrameView> answer;    // if `answered`; refers to the frame passed to take()
    Evidence evidence;
    bool device_answers;    // it answered any request since this one was first sent
};

class Asker {
public:
    /// A request ended. New ones may be asked in this call; the device may not be destroyed in it.
    virtual void ended(const Ended& ended, TimePoint now) = 0;
    /// The same for Outcome::another or unidentified.
    virtual void not_meant(const Ended& ended, TimePoint now) { this->ended(ended, now); }
    /// A frame was received that has the form of the answer to a request, but does not fit. The request may stay open.
    virtual void on_unfit_answer(FrameView /*frame*/) {}

    /// The requests of this asker are not started while requests of askers that do not yield are open.
    bool yields() const noexcept { return yields_; }
    void yield_to_others(bool yields) noexcept { yields_ = yields; }

protected:
    ~Asker() = default;

private:
    bool yields_ = false;
};

/// Whether a frame asks a device for its device info (0xE0 0).
bool is_question_for_info(FrameView frame) noexcept;

/// How a frame relates to the requests of this device.
enum class Taken : std::uint8_t {
    nothing,    // not an answer of this device to this host
    ended,      // it ended a request
    doubled,    // it would have ended a request that is answered already
    late,       // it answers a request that was given up or cancelled
    unasked,    // an answer that matches no request of this host
    foreign,    // an answer to another host
};

/// There is one Device for each device, shared by all askers together with its window. At most Window::max_size requests are in
/// flight, and at most one that writes or upgrades. Two requests that the same answer would end are sent one after the other. A
/// command or an urgent request waits neither for a place in the window nor for the end of another request or of a write. The
/// first acknowledgement ends the oldest of equal commands, with Evidence::may_be_of_equal. Requests of an asker that yields go
/// after all others; but one that was sent before is repeated in any case, since another request may wait for its end.
///
/// A request that acts, or is Request::of_same, is only sent to the device that was there when it was asked, or that it states
/// (Request::identity). After a sign that another device may have the address (doubts(), a pause, a frame that acts and was not
/// acknowledged), the device is asked for its device info before such a request is sent or repeated. If the info differs from the
/// previous one, all such requests end as Outcome::another. Without an answer they are not sent, except:
/// - a command that was not sent yet, or if only its acknowledgement is missing: it may be LAND;
/// - frames of an upgrade: a loader need not answer.
/// A missing acknowledgement does not cause the question before the first frame of a command. The first frame of a command for the
/// device that is present (Request::present_device) is sent before all questions, whatever happened before. A device whose info was never
/// received is asked once before the first acting request of a task (Request::needs_info); its commands are not delayed, and not
/// repeated after a sign. The latter also applies to a device with varying info (has_varying_info()), whose varying fields are not
/// compared.
///
/// No parameter id is sent before the number of parameters is known, nor one at or beyond that number: some firmware crashes on
/// it. An exception is a device that is asked by number, see ask_by_number().
class Device {
public:
    /// After this time without a frame it may be another device: its device info is discarded.
    static constexpr Duration away_after = std::chrono::seconds{30};
    /// An answer may arrive this long after its time-out. An equal request that may be sent only once waits until then.
    static constexpr Duration late_for = RoundTrip::ceiling;
    static constexpr Duration info_may_come_for = RoundTrip::ceiling + late_for;

    /// `address` is that of a device, or a port id; `own` is that of the host.
    explicit Device(std::uint8_t address, std::uint8_t own = address::host) : address_{address}, own_{own} {}
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    /// Queues a request. Returns false, and never calls `asker`, if no answer ends such a request, or its parameter does not
    /// exist. `asker` must live until its ended() or forget() was called.
    [[nodiscard]] bool ask(const Request& request, Asker& asker);
    /// The device has no list of its parameters, but numbers, as those with protocol V7: while it reports 0 parameters, any id may
    /// be sent.
    void ask_by_number(bool yes) noexcept { has_numbers_ = yes; }
    bool is_asked_by_number() const noexcept { return has_numbers_ && parameter_count_ == std::uint16_t{0}; }
    /// `asker` is not called any more; its waiting requests are not sent.
    void forget(const Asker& asker) noexcept;

    /// To be called with every frame of the device. For a port id: also with frames of other sources, but only if they were
    /// received on the links of that port and ended no request of another Device; otherwise answers of several port ids could be
    /// mixed up. A check frame from a port id also ends a request to the device, if it repeats the check bytes of that request.
    Taken take(FrameView frame, TimePoint now);
    /// The next frame to be sent at `now`; std::nullopt: none. It is valid until the next call of any function. Requests that
    /// have timed out end in this call.
    std::optional<FrameView> next_frame(TimePoint now);
    /// To be called instead of next_frame() while the last frame it returned waits to be sent, behind other frames or for a slow
    /// line: no answer can arrive in that time. After max_queued a frame counts as sent.
    void wait_to_leave(TimePoint now) noexcept;
    static constexpr Duration max_queued = std::chrono::seconds{10};
    /// The last ended request with these check bytes in its frame was not sent: no answer to it will arrive.
    void was_not_sent(Checks checks) noexcept;
    /// When next_frame() last returned a frame.
    TimePoint last_sent() const noexcept { return last_sent_; }
    /// `flush` is called before a frame is sent that the device may not receive, because its parser waits inside a damaged frame:
    /// before a request is repeated, unless the device has answered a later one, or a flush was sent since; before the first try of a request with a long
    /// time-out; and before the question for its device info, if the last request was lost. If it may flush only later, a first
    /// try and a command are sent at once; a second try waits for the flush, unless the wait for its answer is shorter. A request
    /// that did not wait and may be repeated is sent once more when the flush is allowed, except the next request of an asker
    /// whose last one was just answered.
    void on_maybe_deaf(std::function<Flush(FrameView next)> flush) { flush_ = std::move(flush); }
    /// When next_frame() must be called again; TimePoint::min(): now; std::nullopt: no request is open.
    std::optional<TimePoint> due() const noexcept;

    std::uint8_t address() const noexcept { return address_; }
    std::uint8_t own() const noexcept { return own_; }
    /// As last reported (0xE3); std::nullopt before that, and after it was away.
    const std::optional<DeviceInfo>& info() const noexcept { return info_; }
    /// As last reported (0xE0 1); std::nullopt as for info().
    std::optional<std::uint16_t> parameter_count() const noexcept { return parameter_count_; }
    /// As last reported (0xC1 0); std::nullopt as for info().
    std::optional<std::uint16_t> command_count() const noexcept { return command_count_; }
    /// Whether a frame of it was received within `away_after`.
    bool is_present(TimePoint now) const noexcept { return heard_at_ && now - *heard_at_ < away_after; }
    /// Increases each time the device was away: data known from before may be wrong.
    std::uint32_t presence() const noexcept { return presence_; }
    /// Increases with each sign that it may have restarted, or be another device: with presence(), after a pause in its telemetry
    /// (TelemetryPace), when the link to it was down, and when a write was not acknowledged. Its earlier descriptions may be
    /// wrong.
    std::uint32_t doubts() const noexcept { return doubts_; }
    /// The same without the writes that were not acknowledged, which is normal on a bad line: a command does not wait for those.
    std::uint32_t signs() const noexcept { return doubts_ - missed_; }
    /// Whether there was no sign since `signs`, and its telemetry does not pause now.
    bool has_no_sign_since(std::uint32_t signs, TimePoint now) const noexcept {
        return is_present(now) && signs == this->signs() && !pace_.pauses(now);
    }
    /// The device's identity, as far as its device info shows.
    Identity identity() const noexcept { return identity_; }
    /// Whether it was identified since the last of its doubts().
    bool is_identified() const noexcept { return doubts_ == identified_doubts_; }
    /// A field of its device info varies: it differs from answer to answer without any sign between, once if the second answer was
    /// asked for because the first one differed, otherwise twice in a row. Such a field does not show which device it is, and is
    /// not compared; a difference in any other field does. info() stays the same meanwhile.
    bool has_varying_info() const noexcept { return std::any_of(unlike_.begin(), unlike_.end(), varies); }
    /// So many differences in a row, and one less for each info in which the field equals the one before.
    static constexpr int varies_from = 2, most_unlike = 4;
    /// When it last sent its device info.
    TimePoint identified_at() const noexcept { return identified_at_; }
    /// Sets its device info, as received before this object was made.
    void know_as(DeviceInfo info) {
        if (const DeviceInfo hardware = hardware_of(info); hardware != DeviceInfo{}) hardware_ = hardware;
        known_as_ = std::move(info);
    }
    /// Sets the pace of its telemetry, as observed before this object was made.
    void know_pace(const TelemetryPace& pace) noexcept { pace_ = pace; }
    /// There is a sign that another device may have the address.
    void doubt() noexcept { ++doubts_; }
    /// Asks for its device info before all other requests, if a command would have to wait for that. To be called whenever the
    /// device is asked something.
    void identify_for_command(TimePoint now);
    /// A command waits for the answers to this many sends, each for two round trips, within these limits: a second in all.
    static constexpr unsigned sends_before_command = 3;
    static constexpr Duration least_wait_before_command = std::chrono::milliseconds{166},
                              longest_wait_before_command = std::chrono::milliseconds{333};
    Patience patience_before_command() const noexcept;
    /// The link to it was down.
    void link_was_down() noexcept {
        ++doubts_;
        ++losses_;
        is_lost_ = true;
    }
    /// Increases each time the link to it was down.
    std::uint32_t losses() const noexcept { return losses_; }
    /// The link to it was down, and no frame of it was received since.
    bool is_lost() const noexcept { return is_lost_; }
    /// To be called when any host asks it for device info: one device info that it sends within `info_may_come_for` is the answer, a second one
    /// is not.
    void expect_info(TimePoint now);
    /// The same device info again within this time is a duplicate made by the line: no device restarts that fast.
    static constexpr Duration info_doubled_within = std::chrono::milliseconds{100};
    /// Increases each time it sends device info (0xE3) that was not asked for to this host or to all, as devices do when they
    /// start.
    std::uint32_t announcements() const noexcept { return announcements_; }
    std::optional<TimePoint> heard_at() const noexcept { return heard_at_; }
    const RoundTrip& round_trip() const noexcept { return round_trip_; }
    /// The number of requests that yield that may be in flight: lower than for others, since a command has to wait for them.
    std::size_t window() const noexcept { return std::min(window_.size(), round_trip_.bearable()); }
    std::size_t on_their_way() const noexcept;
    /// A write or a command is in flight.
    bool awaits_acknowledgement() const noexcept;
    std::size_t waiting() const noexcept { return waiting_.size(); }
    /// A command, or an urgent request, waits for next_frame().
    bool has_command() const noexcept { return first_of_all() != nullptr; }
    /// The longest time that a command waits for answers to requests in flight.
    static constexpr Duration max_wait_of_commands = std::chrono::milliseconds{100};

private:
    TimePoint may_go_first_at(const Exchange& exchange) const noexcept;
    const Exchange* first_of_all() const noexcept;
    using Exchanges = std::list<Exchange>;    // in the order in which they were first sent, or queued
    struct Past {
        Expectation expects;
        Checks checks;    // of its frame
        bool answered;
        TimePoint late_until;       // for a request that may be sent only once
        TimePoint doubled_until;    // a second answer may arrive until then
    };

    struct BeforeDifference {
        Identity identity;
        DeviceInfo info;
    };
    static constexpr Duration between_flushes = std::chrono::seconds{1};    // at least
    static constexpr std::size_t info_fields = 6;
    static constexpr bool varies(int unlike) noexcept { return unlike >= varies_from; }
    static DeviceInfo hardware_of(const DeviceInfo& info) {
        DeviceInfo hardware;
        hardware.dev_id = info.dev_id;
        hardware.hw_ver = info.hw_ver;
        return hardware;
    }

    /// Asks for the device info while other requests wait for it. hear() evaluates the answer, even if another host asked for it.
    struct Identification final : Asker {
        explicit Identification(Device& of) : device{of} {}
        void ended(const Ended& ended, TimePoint now) override { device.not_identified(ended, now); }
        Device& device;
    };

    void enqueue(Exchange exchange);
    void identify(bool for_command);
    void hear_info(DeviceInfo info, bool is_announced, TimePoint now);
    void forget_data() noexcept;
    void count_differences(const DeviceInfo& info, bool has_sign, bool is_second) noexcept;
    bool differ(const DeviceInfo& one, const DeviceInfo& other) const noexcept;
    void recognise(const DeviceInfo& info, TimePoint now);
    void release_held();
    void not_identified(const Ended& ended, TimePoint now);
    void not_acknowledged(const Exchange& exchange) noexcept;
    bool is_another(const Exchange& exchange) const noexcept;
    bool is_in_doubt(const Exchange& exchange, TimePoint now) const noexcept;
    bool waits_for_identity(Exchange& exchange, TimePoint now);
    Exchange* held() noexcept;
    bool may_reach_another(const Exchange& exchange) const noexcept;
    void go_unidentified(Exchange& exchange, const Ended& unanswered, TimePoint now);
    void end_as(Exchange& exchange, Outcome outcome, std::optional<Evidence> evidence, TimePoint now);
    void receive(FrameView frame, TimePoint now);
    void note_telemetry(FrameView frame, TimePoint now) noexcept;
    bool answers_for_info(const DeviceInfo& info, TimePoint now);
    Taken past(FrameView frame) noexcept;
    bool missed(FrameView frame, TimePoint now);
    bool is_of_the_past(FrameView frame) const noexcept;
    void remember(const Exchange& exchange, bool answered) noexcept;
    bool may_be_swallowed(const Exchange& exchange, TimePoint now) const noexcept;
    bool may_be_second_answer(const Exchange& exchange, TimePoint now) noexcept;
    bool has_unanswered_equal(const Exchange& command) const noexcept;
    void expire(TimePoint now);
    void end(Exchanges& from, Exchanges::iterator which, Outcome outcome, std::optional<FrameView> answer, TimePoint now,
             std::optional<Evidence> instead = std::nullopt);
    bool may_be_asked(FrameView request) const noexcept;
    bool may_be_repeated(const Exchange& exchange, TimePoint now) const noexcept;
    std::optional<TimePoint> may_start_at(const Exchange& exchange) const noexcept;
    const Exchange* lost() const noexcept;
    bool keeps_back_those_that_yield() const noexcept;
    const Exchange* next_to_send(TimePoint now) const noexcept;
    bool may_be_deaf_to(const Exchange& exchange) const noexcept;
    TimePoint waits_until(const Exchange& exchange) const noexcept;
    TimePoint line_is_free_at() const noexcept;
    bool waits_for_flush(Exchange& next, TimePoint now);
    void on_flush() noexcept;
    void adjust_waits(const Exchange& answered, TimePoint now) noexcept;
    Exchange::Send this_send(const Exchange& next) const noexcept;
    FrameView send(Exchanges& from, Exchanges::iterator which, TimePoint now);
    bool is_heard_since(const Exchange& exchange) const noexcept {
        return exchange.was_sent() && heard_at_ && *heard_at_ > exchange.first_sent();
    }
    Evidence evidence_of(const Exchange& exchange) const {
        return {exchange.sent(), round_trip_.smoothed(), is_heard_since(exchange) || !exchange.unfit().empty(), exchange.unfit()};
    }

    std::uint8_t address_;
    std::uint8_t own_;
    std::optional<DeviceInfo> info_;
    std::optional<std::uint16_t> parameter_count_;
    bool has_numbers_ = false;
    std::optional<std::uint16_t> command_count_;
    std::optional<TimePoint> heard_at_;
    std::optional<TimePoint> answered_at_;
    std::uint32_t presence_ = 0;
    std::uint32_t doubts_ = 0;
    std::uint32_t losses_ = 0;
    bool is_lost_ = false;
    Identification identification_{*this};
    bool identifies_ = false, identifies_for_command_ = false;
    std::optional<DeviceInfo> known_as_;    // the last device info, also while it is away
    std::optional<DeviceInfo> hardware_;    // its hardware_of() as last reported: a loader may report zeros
    Identity identity_;
    std::optional<BeforeDifference> before_difference_;    // its info differed after a sign; until the second answer
    bool is_compared_ = false;                             // two of its infos were compared since it was away
    TimePoint identified_at_{};
    std::uint32_t missed_ = 0;    // those of doubts_ that are acknowledgements of writes
    std::uint32_t identified_signs_ = 0;
    std::uint32_t identified_doubts_ = 0;               // doubts_ at that time
    bool is_unacknowledged_ = false;                    // a frame that acts was not acknowledged since then
    std::optional<std::uint32_t> unanswered_doubts_;    // doubts_ when it did not answer the question for its device info
    TimePoint unanswered_at_{};
    TelemetryPace pace_;
    std::optional<TimePoint> info_asked_at_, info_answered_at_;
    static constexpr std::size_t max_info_questions = 64;
    std::vector<TimePoint> info_questions_;    // not answered yet, the oldest first
    Duration info_takes_{};                    // from the question to the device info, at least
    Duration write_takes_{};                   // from a write to its acknowledgement
    std::array<int, info_fields> unlike_{};    // differences in each field, for has_varying_info()
    std::uint32_t announcements_ = 0;
    RoundTrip round_trip_;
    Window window_;
    Window window_when_heard_;              // at the last answer
    std::uint64_t sends_ = 0;               // of all requests
    std::uint64_t heard_send_ = 0;          // the latest of them that the device has answered
    std::uint64_t lost_send_ = 0;           // the latest of them that has timed out
    std::uint64_t flushed_send_ = 0;        // the latest of them before the last flush
    const Asker* heard_asker_ = nullptr;    // the asker of the request that it answered last
    TimePoint last_sent_{};
    TimePoint line_is_busy_until_ = TimePoint::min();    // with the bytes of flush_
    Duration long_answer_takes_{};                       // on this line, if its rate is known from a flush
    TimePoint no_flush_before_ = TimePoint::min();
    std::function<Flush(FrameView)> flush_;
    Exchanges sent_;
    Exchanges waiting_;
    std::array<std::optional<Past>, 32> past_{};    // of the last exchanges
    std::size_t next_past_ = 0;
};

}    // namespace ano::host
