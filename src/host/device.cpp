#include <ano/conversation.hpp>
#include <ano/typed.hpp>
#include <host/device.hpp>
#include <host/parameter_info.hpp>

#include <algorithm>
#include <iterator>
#include <utility>

namespace ano::host {
namespace {

// The id of the parameter that a frame to a device reads or writes.
std::optional<std::uint16_t> parameter_in(FrameView request) noexcept {
    if (const auto value = as<"parameter_value">(request)) return value->get<"par_id">();
    const auto query = as<"parameter_command">(request);
    if (query && (query->get<"cmd">() == 2 || query->get<"cmd">() == 3)) return query->get<"val">();
    return std::nullopt;
}

bool is_command(const Exchange& exchange) noexcept { return exchange.frame().id() == id_of<"command">; }
// A device that stores each value in its flash memory needs long for it.
bool is_measured_write(const Exchange& exchange) noexcept {
    return exchange.is_measured() && exchange.acts() && exchange.expects().is_acknowledgement();
}
// Rises at once, and falls slowly.
Duration followed(Duration before, Duration takes) noexcept { return std::max(takes, (before + takes) / 2); }
bool has_priority(const Exchange& exchange) noexcept { return exchange.is_urgent() || is_command(exchange); }

// Whether each field differs.
std::array<bool, 6> differences_of(const DeviceInfo& a, const DeviceInfo& b) noexcept {
    return {a.dev_id != b.dev_id, a.hw_ver != b.hw_ver, a.sw_ver != b.sw_ver,
            a.bl_ver != b.bl_ver, a.pt_ver != b.pt_ver, a.name != b.name};
}

}    // namespace

bool is_question_for_info(FrameView frame) noexcept { return answer_to(frame) == Answer{id_of<"device_info">, {}}; }

bool Device::ask(const Request& request, Asker& asker) {
    Exchange exchange{request, own_, address_, &asker};
    if (!exchange.is_askable() || !may_be_asked(exchange.frame())) return false;
    if (!request.identity) exchange.mean(identity_);
    enqueue(std::move(exchange));
    return true;
}

// A command does not wait for a long list to be read, nor for a question: it is the next frame.
void Device::enqueue(Exchange exchange) {
    const bool is_command = host::is_command(exchange);
    const auto goes_behind = [&](const Exchange& e) { return is_command ? host::is_command(e) : has_priority(e); };
    const auto place = has_priority(exchange) ? std::find_if_not(waiting_.begin(), waiting_.end(), goes_behind) : waiting_.end();
    waiting_.insert(place, std::move(exchange));
}

bool Device::may_be_asked(FrameView request) const noexcept {
    const auto parameter = parameter_in(request);
    return !parameter || is_asked_by_number() || (parameter_count_ && *parameter < *parameter_count_);
}

void Device::forget(const Asker& asker) noexcept {
    for (const Exchange& exchange : sent_)
        if (exchange.asker() == &asker) remember(exchange, false);
    if (heard_asker_ == &asker) heard_asker_ = nullptr;
    const auto is_of_it = [&](const Exchange& exchange) { return exchange.asker() == &asker; };
    sent_.remove_if(is_of_it);
    waiting_.remove_if(is_of_it);
}

Taken Device::take(FrameView frame, TimePoint now) {
    const bool is_its_own = may_be_of(frame.source(), address_);
    if (!is_its_own && !(frame.id() == id_of<"check"> && address::is_port_id(frame.source()))) return Taken::nothing;
    if (is_its_own) receive(frame, now);
    if (!may_answer(frame.id())) return Taken::nothing;
    const auto met = std::find_if(sent_.begin(), sent_.end(), [&](const Exchange& e) { return e.expects().is_met_by(frame); });
    if (met == sent_.end()) {
        const Taken taken = past(frame);
        if (taken == Taken::doubled) {
            round_trip_.doubled();
            window_.on_late_answer();
        }
        return taken == Taken::unasked && missed(frame, now) ? Taken::ended : taken;
    }
    if (is_measured_write(*met)) write_takes_ = followed(write_takes_, now - met->last_sent());
    const bool is_slow_write = is_measured_write(*met) && write_takes_ > round_trip_.time_out();
    if (met->is_measured() && !is_slow_write)
        round_trip_.answered(std::max(now - met->first_sent(), Duration{}), met->sent() > 1);
    if (met->is_measured() && met->sent() == 1) round_trip_.answered_behind(met->last().others, now - met->first_sent());
    window_.answered(met->last().alone);
    window_when_heard_ = window_;
    if (!may_be_second_answer(*met, now)) {
        adjust_waits(*met, now);
        heard_send_ = std::max(heard_send_, met->first_number());
    }
    heard_asker_ = met->asker();
    answered_at_ = now;
    end(sent_, met, Outcome::answered, frame, now);
    return Taken::ended;
}

// Device info and the counts are read from every frame, even if another host asked for it.
void Device::receive(FrameView frame, TimePoint now) {
    if (heard_at_ && !is_present(now)) {
        forget_data();
        unlike_ = {};
        is_compared_ = false;
    }
    note_telemetry(frame, now);
    if (std::exchange(is_lost_, false)) unanswered_doubts_.reset();
    heard_at_ = now;
    if (const auto view = as<"device_info">(frame)) {
        DeviceInfo info{view->get<"dev_id">(), view->get<"hw_ver">(), view->get<"sw_ver">(),
                        view->get<"bl_ver">(), view->get<"pt_ver">(), std::string{view->get<"name">()}};
        const bool is_for_us = frame.destination() == own_ || frame.destination() == address::broadcast;
        const bool is_announced = is_for_us && !answers_for_info(info, now);
        hear_info(std::move(info), is_announced, now);
    }
    const auto count = as<"parameter_command">(frame);
    if (count && count->get<"cmd">() == 1) parameter_count_ = count->get<"val">();
    const auto commands = as<"command_query">(frame);
    if (commands && commands->get<"cmd">() == 0) command_count_ = commands->get<"val">();
}

void Device::forget_data() noexcept {
    info_.reset();
    parameter_count_.reset();
    command_count_.reset();
    ++presence_;
    ++doubts_;
}

// If it is announced or has changed, the device restarted, and may have other parameters and commands. If the answer to a question
// after a sign has changed, the answer to a second question shows what varies: what waits for it waits for that answer too.
void Device::hear_info(DeviceInfo info, bool is_announced, TimePoint now) {
    const bool is_asked_first = identifies_ && !before_difference_;    // because of a sign, or of a pause that lasts
    const bool has_sign = is_announced || !is_identified() || is_unacknowledged_ || is_asked_first;
    auto before = std::exchange(before_difference_, std::nullopt);
    const bool is_second = before && !has_sign;
    if (known_as_) count_differences(info, has_sign, is_second);
    const bool is_other = known_as_ && differ(*known_as_, info);
    const bool asks_again = is_other && identifies_ && has_sign && !is_announced;
    if (is_second && !differ(before->info, info)) identity_ = before->identity;
    if (asks_again) before_difference_ = before ? std::move(before) : BeforeDifference{identity_, *known_as_};
    if (is_announced) ++announcements_;
    if (is_announced || (info_ && is_other)) forget_data();
    const bool for_command = identifies_for_command_;
    recognise(info, now);
    if (is_other || !info_ || !has_varying_info()) info_ = std::move(info);
    if (asks_again) return identify(for_command);
    release_held();
}

void Device::count_differences(const DeviceInfo& info, bool has_sign, bool is_second) noexcept {
    const auto differences = differences_of(*known_as_, info);
    for (std::size_t i = 0; i < unlike_.size(); ++i) {
        int& unlike = unlike_[i];
        if (!differences[i]) unlike = std::max(unlike - 1, 0);
        else if (is_second) unlike = std::max(unlike, varies_from);
        else unlike = varies(unlike) || !has_sign ? std::min(unlike + 1, most_unlike) : 0;
    }
    is_compared_ = true;
}

// Whether they are infos of different devices.
bool Device::differ(const DeviceInfo& one, const DeviceInfo& other) const noexcept {
    const auto differences = differences_of(one, other);
    for (std::size_t i = 0; i < unlike_.size(); ++i)
        if (differences[i] && !varies(unlike_[i])) return true;
    return false;
}

void Device::recognise(const DeviceInfo& info, TimePoint now) {
    if (known_as_ && differ(*known_as_, info)) ++identity_.device;
    known_as_ = info;
    if (DeviceInfo hardware = hardware_of(info); hardware != DeviceInfo{}) {
        if (hardware_ && differ(*hardware_, hardware)) ++identity_.hardware;
        hardware_ = std::move(hardware);
    }
    identified_at_ = now;
    identified_doubts_ = doubts_;
    identified_signs_ = signs();
    is_unacknowledged_ = identifies_ = false;
}

void Device::release_held() {
    while (Exchange* const one = held()) one->release(false);
}

Exchange* Device::held() noexcept {
    for (Exchanges* const list : {&sent_, &waiting_})
        for (Exchange& exchange : *list)
            if (exchange.is_held()) return &exchange;
    return nullptr;
}

bool Device::is_another(const Exchange& exchange) const noexcept {
    if (!exchange.is_of_same()) return false;
    return exchange.frame().id() == id_of<"firmware"> ? exchange.identity().hardware != identity_.hardware
                                                      : exchange.identity() != identity_;
}

// In its loader a device sends no telemetry and need not answer, and frames are lost while it writes flash.
bool Device::is_in_doubt(const Exchange& exchange, TimePoint now) const noexcept {
    const bool is_of_loader = exchange.frame().id() == id_of<"firmware">;
    if (!known_as_) return exchange.needs_info() && !is_of_loader && !is_command(exchange) && !unanswered_doubts_;
    if (exchange.compares_info() && !is_compared_) return true;
    if (is_command(exchange) && exchange.means_present_device()) return false;
    const bool is_first_command = is_command(exchange) && !exchange.was_sent();
    const bool was_asked = unanswered_doubts_ == doubts_ && (is_of_loader || now - unanswered_at_ <= longest_wait_before_command);
    if ((is_of_loader || is_first_command) && was_asked) return false;
    if (is_first_command ? signs() != identified_signs_ : !is_identified()) return true;
    if (is_of_loader) return false;
    if (!is_present(now)) return true;
    if (pace_.pauses(now) && now - identified_at_ > pace_.longest_pause()) return true;
    return is_unacknowledged_ && !is_first_command;
}

// A command that is repeated although nothing shows which device answered the first time.
bool Device::may_reach_another(const Exchange& exchange) const noexcept {
    const bool is_unknown = !exchange.last().is_known || has_varying_info();
    return is_unknown && is_command(exchange) && exchange.was_sent() && (exchange.last().doubts != doubts_ || is_lost_);
}

bool Device::waits_for_identity(Exchange& exchange, TimePoint now) {
    if (!exchange.is_of_same() || exchange.passes() || !is_in_doubt(exchange, now)) return false;
    exchange.hold();
    identify(!known_as_ || is_command(exchange) || exchange.frame().id() == id_of<"firmware">);
    return true;
}

Patience Device::patience_before_command() const noexcept {
    const Duration two_round_trips = 2 * round_trip_.smoothed().value_or(Duration{});
    return {.sends = sends_before_command,
            .wait = std::clamp(two_round_trips, least_wait_before_command, longest_wait_before_command)};
}

void Device::identify(bool for_command) {
    if (identifies_ && (identifies_for_command_ || !for_command)) return;
    forget(identification_);
    Request question = question::device_info(0);
    question.urgent = true;
    question.patience = {.at_least = info_takes_};
    if (for_command) question.patience = patience_before_command();
    enqueue({question, own_, address_, &identification_});
    identifies_ = true;
    identifies_for_command_ = for_command;
}

void Device::identify_for_command(TimePoint now) {
    if (known_as_ && !has_no_sign_since(identified_signs_, now)) identify(true);
}

void Device::not_identified(const Ended& ended, TimePoint now) {
    if (!std::exchange(identifies_, false)) return;    // a frame of it was received
    if (std::exchange(before_difference_, std::nullopt))
        return release_held();    // it did answer the first time: it is another one
    unanswered_doubts_ = doubts_;
    unanswered_at_ = now;
    while (Exchange* const one = held()) go_unidentified(*one, ended, now);
}

void Device::go_unidentified(Exchange& exchange, const Ended& unanswered, TimePoint now) {
    exchange.release(false);
    if (!known_as_) return exchange.release(true);
    if (is_command(exchange)) {
        const bool has_sign = exchange.was_sent() && (exchange.last().doubts != doubts_ || is_lost_);
        if (!has_sign) return exchange.release(true);
        if (now - exchange.first_sent() < exchange.longest()) return;    // asked again
    }
    if (exchange.frame().id() == id_of<"firmware">) return exchange.release(true);
    if (exchange.was_sent() && now - exchange.first_sent() < exchange.late()) return;    // it is asked again
    if (exchange.was_sent()) return end_as(exchange, Outcome::timeout, std::nullopt, now);
    end_as(exchange, Outcome::unidentified, unanswered.evidence, now);
}

void Device::end_as(Exchange& exchange, Outcome outcome, std::optional<Evidence> evidence, TimePoint now) {
    Exchanges& from = exchange.was_sent() ? sent_ : waiting_;
    const auto which = std::find_if(from.begin(), from.end(), [&](const Exchange& e) { return &e == &exchange; });
    end(from, which, outcome, {}, now, std::move(evidence));
}

void Device::expect_info(TimePoint now) {
    info_asked_at_ = now;
    if (info_questions_.size() == max_info_questions) info_questions_.erase(info_questions_.begin());
    info_questions_.push_back(now);
}

// Each question has at most one answer. The time since the last question is not too long, whichever of them is answered.
bool Device::answers_for_info(const DeviceInfo& info, TimePoint now) {
    std::erase_if(info_questions_, [&](TimePoint asked_at) { return now - asked_at > info_may_come_for; });
    const bool is_doubled = info_answered_at_ && now - *info_answered_at_ <= info_doubled_within && info_ == info;
    if (info_questions_.empty()) return is_doubled;
    info_questions_.erase(info_questions_.begin());
    const Duration takes = std::min(now - info_asked_at_.value_or(now), RoundTrip::ceiling);
    info_takes_ = followed(info_takes_, takes);
    info_answered_at_ = now;
    return true;
}

// Answers arrive only after questions, and log lines at irregular times: a pause between those shows nothing, except before a
// second device info.
void Device::note_telemetry(FrameView frame, TimePoint now) noexcept {
    // An answer to our question would have arrived before the frames that precede the pause.
    const bool was_heard_since = info_asked_at_ && heard_at_ && *heard_at_ > *info_asked_at_;
    if (frame.id() == id_of<"device_info"> && was_heard_since && now - *heard_at_ > pace_.longest_pause()) ++doubts_;
    const bool is_log = frame.id() == id_of<"log"> || frame.id() == id_of<"log_value">;
    if (is_log || may_answer(frame.id())) return;
    if (pace_.came(now, heard_at_)) ++doubts_;
}

Taken Device::past(FrameView frame) noexcept {
    for (std::size_t i = 1; i <= past_.size(); ++i) {
        auto& one = past_[(next_past_ + past_.size() - i) % past_.size()];
        if (!one || !one->expects.is_met_by(frame)) continue;
        return std::exchange(one->answered, true) ? Taken::doubled : Taken::late;
    }
    return frame.destination() == own_ ? Taken::unasked : Taken::foreign;
}

// A wrong acknowledgement belongs to the only write or command in flight. The device has received that frame, so the request
// ends, and its effect is read back. Acknowledgements of an earlier frame, such as a question that needs none, are ignored.
bool Device::missed(FrameView frame, TimePoint now) {
    const auto is_missed = [&](const Exchange& e) { return e.is_on_its_way() && e.expects().is_missed_by(frame); };
    const auto it = std::find_if(sent_.begin(), sent_.end(), is_missed);
    if (it == sent_.end() || std::any_of(std::next(it), sent_.end(), is_missed)) return false;
    if (is_of_the_past(frame)) return false;
    it->asker()->on_unfit_answer(frame);
    if (!it->miss(frame)) return false;
    end(sent_, it, Outcome::timeout, {}, now);
    return true;
}

bool Device::is_of_the_past(FrameView frame) const noexcept {
    const auto check = as<"check">(frame);
    if (!check) return false;
    const Checks checks{check->get<"sc_get">(), check->get<"ac_get">()};
    return std::any_of(past_.begin(), past_.end(), [&](const auto& one) { return one && one->checks == checks; });
}

void Device::remember(const Exchange& exchange, bool answered) noexcept {
    const TimePoint never = TimePoint::min();
    past_[next_past_] = Past{exchange.expects(), exchange.frame().checks(), answered,
                             exchange.is_once() ? exchange.due() + late_for : never,
                             exchange.sent() > 1 ? exchange.last_sent() + RoundTrip::ceiling : never};
    next_past_ = (next_past_ + 1) % past_.size();
}

// The answer to `exchange` may be the second one to an equal request that was sent twice: it does not show that this one arrived.
bool Device::may_be_second_answer(const Exchange& exchange, TimePoint now) noexcept {
    for (auto& past : past_)
        if (past && past->expects == exchange.expects() && std::exchange(past->doubled_until, TimePoint::min()) > now)
            return true;
    return false;
}

// `command` is no longer in the list. If a device acknowledges one of two equal commands, the acknowledgement does not show
// which.
bool Device::has_unanswered_equal(const Exchange& command) const noexcept {
    const auto is_equal = [&](const Exchange& e) { return e.expects() == command.expects(); };
    const auto may_be_late = [&](const auto& past) {
        return past && !past->answered && past->expects == command.expects() && past->late_until > command.first_sent();
    };
    return std::any_of(sent_.begin(), sent_.end(), is_equal) || std::any_of(past_.begin(), past_.end(), may_be_late);
}

// The exchange is removed from the list before the asker is called, since the asker may send another request at once.
void Device::end(Exchanges& from, Exchanges::iterator which, Outcome outcome, std::optional<FrameView> answer, TimePoint now,
                 std::optional<Evidence> instead) {
    Exchanges over;
    over.splice(over.end(), from, which);
    const Exchange& exchange = over.front();
    if (exchange.was_sent()) remember(exchange, outcome == Outcome::answered);
    const bool answers = answered_at_ && exchange.was_sent() && *answered_at_ >= exchange.first_sent();
    Evidence evidence = instead ? *std::move(instead) : evidence_of(exchange);
    if (answer && !may_be_of(answer->source(), address_)) evidence.by_port = answer->source();
    evidence.may_be_of_equal = answer && is_command(exchange) && has_unanswered_equal(exchange);
    const Ended ended{outcome, exchange.tag(), answer, std::move(evidence), answers};
    if (outcome == Outcome::another || outcome == Outcome::unidentified) return exchange.asker()->not_meant(ended, now);
    exchange.asker()->ended(ended, now);
}

std::optional<FrameView> Device::next_frame(TimePoint now) {
    expire(now);
    while (const Exchange* next = next_to_send(now)) {
        Exchanges& from = next->was_sent() ? sent_ : waiting_;
        const auto which = std::find_if(from.begin(), from.end(), [&](const Exchange& e) { return &e == next; });
        if (which->means_present_device()) which->mean(identity_);
        if (!may_be_asked(next->frame())) end(from, which, Outcome::not_there, {}, now);
        else if (is_another(*which)) end(from, which, Outcome::another, {}, now);
        else if (may_reach_another(*which)) end(from, which, Outcome::timeout, {}, now);
        else if (waits_for_identity(*which, now)) continue;
        else if (!may_be_repeated(*which, now)) end(from, which, Outcome::uncertain, {}, now);
        else if (!waits_for_flush(*which, now)) return send(from, which, now);
    }
    return std::nullopt;
}

void Device::expire(TimePoint now) {
    const auto is_over = [&](Exchange& e) { return e.is_on_its_way() && e.due() <= now && !e.waits_on(heard_at_); };
    for (auto over = std::find_if(sent_.begin(), sent_.end(), is_over); over != sent_.end();
         over = std::find_if(sent_.begin(), sent_.end(), is_over)) {
        if (over->is_lost_by_measure()) window_.lost(over->last().alone, round_trip_.grows());
        lost_send_ = std::max(lost_send_, over->last().number);
        if (over->acts() && !may_be_swallowed(*over, now)) not_acknowledged(*over);
        if (!over->time_out(now, is_heard_since(*over))) end(sent_, over, Outcome::timeout, {}, now);
    }
}

// It was sent while no flush was allowed, so the parser may have swallowed it; and the device was heard too recently to be another
// one.
bool Device::may_be_swallowed(const Exchange& exchange, TimePoint now) const noexcept {
    return exchange.last_sent() < no_flush_before_ && heard_at_ && now - *heard_at_ < between_flushes;
}

// It may have been sent to a device that is away. A missing acknowledgement is normal for a command and for a busy loader.
void Device::not_acknowledged(const Exchange& exchange) noexcept {
    if (exchange.frame().id() == id_of<"firmware">) return;
    is_unacknowledged_ = true;
    if (is_command(exchange)) return;
    ++doubts_;
    ++missed_;
}

std::size_t Device::on_their_way() const noexcept {
    return static_cast<std::size_t>(
        std::count_if(sent_.begin(), sent_.end(), [](const Exchange& e) { return e.is_on_its_way(); }));
}

bool Device::awaits_acknowledgement() const noexcept {
    return std::any_of(sent_.begin(), sent_.end(),
                       [](const Exchange& e) { return e.is_on_its_way() && e.expects().is_acknowledgement(); });
}

const Exchange* Device::lost() const noexcept {
    const auto is_lost = [](const Exchange& e) { return !e.is_on_its_way() && !e.is_held(); };
    const auto first = std::find_if(sent_.begin(), sent_.end(),
                                    [&](const Exchange& e) { return is_lost(e) && !e.asker()->yields(); });
    const auto found = first != sent_.end() ? first : std::find_if(sent_.begin(), sent_.end(), is_lost);
    return found == sent_.end() ? nullptr : &*found;
}

bool Device::keeps_back_those_that_yield() const noexcept {
    const auto has_priority = [](const Exchange& e) { return !e.asker()->yields(); };
    return on_their_way() >= window() || std::any_of(waiting_.begin(), waiting_.end(), has_priority) ||
           std::any_of(sent_.begin(), sent_.end(), has_priority);
}

// A device that accepts one frame at a time loses a command that arrives while it answers: questions in flight end first, and no
// other question starts.
TimePoint Device::may_go_first_at(const Exchange& exchange) const noexcept {
    const TimePoint line_is_free_at = this->line_is_free_at();
    TimePoint at = waits_until(exchange);
    for (const Exchange& e : sent_)    // sends before the zero bytes on the line don't count
        if (e.is_on_its_way() && !has_priority(e) && e.last_sent() > line_is_free_at)
            at = std::max(at, std::min(e.due(), e.last_sent() + max_wait_of_commands));
    return at;
}

// Commands are sent first, then lost requests. Requests that yield are sent last.
const Exchange* Device::next_to_send(TimePoint now) const noexcept {
    if (const Exchange* const first = first_of_all()) return may_go_first_at(*first) <= now ? first : nullptr;
    if (on_their_way() >= window_.size()) return nullptr;
    const auto may_start = [&](const Exchange& e) {
        const auto at = may_start_at(e);
        return at && *at <= now;
    };
    if (now < line_is_free_at()) return nullptr;    // a frame would end the zero bytes of flush_
    const Exchange* const again = lost();
    if (again && !again->asker()->yields()) return again;
    const auto first = std::find_if(waiting_.begin(), waiting_.end(),
                                    [&](const Exchange& e) { return !e.asker()->yields() && may_start(e); });
    if (first != waiting_.end()) return &*first;
    if (again) return again;
    if (keeps_back_those_that_yield()) return nullptr;
    const auto fresh = std::find_if(waiting_.begin(), waiting_.end(), may_start);
    return fresh == waiting_.end() ? nullptr : &*fresh;
}

// Commands and urgent requests are at the front of the queue.
const Exchange* Device::first_of_all() const noexcept {
    const auto next = std::find_if(waiting_.begin(), waiting_.end(), [](const Exchange& e) { return !e.is_held(); });
    if (next != waiting_.end() && has_priority(*next)) return &*next;
    const auto again = std::find_if(sent_.begin(), sent_.end(),
                                    [](const Exchange& e) { return has_priority(e) && !e.is_on_its_way() && !e.is_held(); });
    return again != sent_.end() ? &*again : nullptr;
}

// std::nullopt: it can't start before a request in flight has ended, or the device is identified.
std::optional<TimePoint> Device::may_start_at(const Exchange& exchange) const noexcept {
    if (exchange.is_held()) return std::nullopt;
    const bool is_blocked = std::any_of(sent_.begin(), sent_.end(), [&](const Exchange& e) {
        return e.expects() == exchange.expects() || (e.expects().is_alone() && exchange.expects().is_alone());
    });
    if (is_blocked) return std::nullopt;
    TimePoint at = exchange.kept_until();
    if (!exchange.is_once()) return at;
    for (const auto& past : past_)
        if (past && !past->answered && past->expects == exchange.expects()) at = std::max(at, past->late_until);
    return at;
}

// An answer shows that the device receives: its parser was ready when a later request was sent. A flush made it ready for all
// that was sent before. The identification is for a request that may just have been lost.
bool Device::may_be_deaf_to(const Exchange& exchange) const noexcept {
    const std::uint64_t ready_since = std::max(heard_send_, flushed_send_);
    if (exchange.was_sent()) return ready_since < exchange.last().number;
    return exchange.waits_long() || (exchange.asker() == &identification_ && ready_since < lost_send_);
}

// It waits for a flush, unless an answer or a flush for another request made that needless meanwhile.
TimePoint Device::waits_until(const Exchange& exchange) const noexcept {
    const bool waits = !exchange.is_on_its_way() && may_be_deaf_to(exchange);
    return waits ? exchange.kept_until() : TimePoint::min();
}

TimePoint Device::line_is_free_at() const noexcept {
    TimePoint at = line_is_busy_until_;
    for (const Exchange& exchange : sent_) at = std::max(at, waits_until(exchange));
    return at;
}

// Flushes before `next` if that is needed and allowed now. Only a second try waits until it is allowed; a command never does. A
// flush for another request meanwhile serves `next` as well, so it waits only once. The question before a command is never prolonged.
bool Device::waits_for_flush(Exchange& next, TimePoint now) {
    if (!flush_ || !may_be_deaf_to(next)) return false;
    const Flush flush = flush_(next.frame());
    line_is_busy_until_ = std::max(line_is_busy_until_, now + flush.busy);
    long_answer_takes_ = std::max(long_answer_takes_, flush.busy / 2);
    no_flush_before_ = std::max(no_flush_before_, now + (flush.sent ? between_flushes : flush.later));
    if (flush.sent) on_flush();
    if (flush.sent || flush.later <= Duration::zero()) return false;
    const bool may_wait = next.was_sent() && !is_command(next) &&
                          flush.later <= next.wait_for_answer(now, round_trip_, this_send(next));
    if (may_wait && next.keep(now, flush.later)) return true;
    const bool goes_on = !next.was_sent() && next.asker() == heard_asker_ && heard_send_ == sends_;
    const bool is_for_command = next.asker() == &identification_ && identifies_for_command_;
    if (!next.is_once() && !goes_on && !is_for_command)
        next.flush_at(now + std::max(flush.later, RoundTrip::first));    // its answer may arrive before
    return false;
}

// The losses since the last answer may be those of the parser: they show nothing about the line.
void Device::on_flush() noexcept {
    flushed_send_ = sends_;
    if (!window_when_heard_.is_one_at_a_time()) window_ = window_when_heard_;
}

// Devices answer in the order of the requests. On a slow line a later answer needs its time after this one; to a send before the
// flush that this send followed, no answer will arrive: the parser has swallowed it.
void Device::adjust_waits(const Exchange& answered, TimePoint now) noexcept {
    const bool is_after_flush = answered.last().number > flushed_send_ && now > answered.last_sent();
    for (Exchange& exchange : sent_) {
        const std::uint64_t number = exchange.last().number;
        if (number > answered.last().number) exchange.wait_from(now, round_trip_.time_out());
        if (is_after_flush && number <= flushed_send_ && exchange.is_measured() && !exchange.acts()) exchange.stop_waiting(now);
    }
}

bool Device::may_be_repeated(const Exchange& exchange, TimePoint now) const noexcept {
    return !exchange.was_sent() || exchange.frame().id() != Draft<"parameter_value">::message().id ||
           (exchange.last().doubts == doubts_ && has_no_sign_since(signs(), now));
}

Exchange::Send Device::this_send(const Exchange& next) const noexcept {
    const std::size_t others = on_their_way();
    const bool answers = next.was_sent() && answered_at_ && *answered_at_ > next.last_sent();
    return {sends_ + 1, window_.is_one_at_a_time() && others == 0, answers, others, doubts_, known_as_.has_value()};
}

FrameView Device::send(Exchanges& from, Exchanges::iterator which, TimePoint now) {
    const Exchange::Send send = this_send(*which);
    if (!which->was_sent()) sent_.splice(sent_.end(), from, which);
    last_sent_ = now;
    sends_ = send.number;
    if (is_measured_write(*which)) which->wait_at_least(std::min(write_takes_ + write_takes_ / 4, RoundTrip::ceiling));
    which->send(std::max(now, line_is_busy_until_), round_trip_, send);
    if (send.others > 0 && !round_trip_.knows_others(send.others)) which->wait_from(now, RoundTrip::first);
    which->wait_from(now, long_answer_takes_);
    if (is_question_for_info(which->frame())) expect_info(now);
    return which->frame();
}

void Device::wait_to_leave(TimePoint now) noexcept {
    for (Exchange& exchange : sent_)
        if (exchange.is_on_its_way() && exchange.last().number == sends_) exchange.wait_to_leave(now);
}

void Device::was_not_sent(Checks checks) noexcept {
    for (std::size_t i = 1; i <= past_.size(); ++i) {
        auto& one = past_[(next_past_ + past_.size() - i) % past_.size()];
        if (!one || one->checks != checks) continue;
        one.reset();
        return;
    }
}

std::optional<TimePoint> Device::due() const noexcept {
    std::optional<TimePoint> first;
    if (first_of_all() != nullptr) {
        first = may_go_first_at(*first_of_all());
    } else if (on_their_way() < window_.size()) {
        const TimePoint line_is_free_at = this->line_is_free_at();
        if (lost() != nullptr) first = line_is_free_at;
        const bool keeps_back = keeps_back_those_that_yield();
        for (const Exchange& exchange : waiting_) {
            const auto at = may_start_at(exchange);
            if (at && !(keeps_back && exchange.asker()->yields()))
                first = std::min(first.value_or(TimePoint::max()), std::max(*at, line_is_free_at));
        }
    }
    for (const Exchange& exchange : sent_)
        if (exchange.is_on_its_way()) first = std::min(first.value_or(TimePoint::max()), exchange.due());
    return first;
}

}    // namespace ano::host
