#include <ano/hex.hpp>
#include <host/task.hpp>

#include <utility>

namespace ano::host {

std::string hex_of(std::uint8_t address) {
    constexpr std::string_view digits = "0123456789ABCDEF";
    return {'0', 'x', digits[address >> 4], digits[address & 0xF]};
}

bool Task::is_overdue(TimePoint now) {
    if (!begun_at_) begun_at_ = now;
    if (now - *begun_at_ <= max_duration()) return false;
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(max_duration()).count();
    finish({Ending::timeout, Fault{"answers_too_slowly", hex_of(device_.address()), seconds}.add(half_done()), {}}, now);
    return true;
}

void Task::ask(const Request& request, TimePoint now) {
    if (is_overdue(now)) return;
    Request meant = request;
    meant.identity = identity_;
    meant.needs_info = true;
    meant.compares_info = compares_info_;
    meant.present_device = std::exchange(means_present_device_, false);
    if (!device_.ask(meant, *this)) finish({Ending::invalid, {"no_such_parameter", hex_of(device_.address())}, {}}, now);
}

void Task::not_meant(const Ended& ended, TimePoint now) {
    if (ended.outcome == Outcome::unidentified) return finish_silent({"device_info"}, ended.evidence, now);
    finish_another(ended.evidence.sent > 0 ? order() : Fault{}, now);
}

void Task::finish_another(Fault may_be_done, TimePoint now, Fault left) {
    be_of_another();
    Fault fault = another_device();
    if (!may_be_done.empty()) fault.add({"may_have_carried_out", std::move(may_be_done)});
    finish({Ending::failed, fault.add(std::move(left)), {}}, now);
}

void Task::finish(End end, TimePoint now) {
    if (end_) return;
    device_.forget(*this);
    end_ = std::move(end);
    if (on_end_) on_end_(now);
}

void Task::finish_silent(const Fault& step, const Evidence& evidence, TimePoint now, const Fault& likely) {
    finish_unanswered("not_answered", step, evidence, now, likely);
}

void Task::finish_without_info(const Fault& step, const Evidence& evidence, TimePoint now) {
    const bool answers = evidence.round_trip.has_value();
    finish_silent(step, evidence, now, answers ? Fault{"answers_others"} : Fault{"may_not_arrive"});
}

void Task::finish_unacknowledged(const Fault& order, const Evidence& evidence, TimePoint now, const Fault& likely) {
    if (evidence.unfit.empty() || !evidence.is_heard) return finish_unanswered("not_acknowledged", order, evidence, now, likely);
    finish({Ending::timeout,
            {"wrong_check_bytes", hex_of(device_.address()), spaced_hex(evidence.unfit), order, evidence.sent},
            evidence},
           now);
}

void Task::finish_unanswered(UnansweredId if_heard, const Fault& step, const Evidence& evidence, TimePoint now,
                             const Fault& likely) {
    Fault fault{evidence.is_heard ? if_heard : UnansweredId{"silent"}, hex_of(device_.address()), step, evidence.sent};
    if (evidence.is_heard) fault.add(likely);
    finish({Ending::timeout, std::move(fault), evidence}, now);
}

Fault Task::port_answer(const Evidence& evidence) {
    return evidence.by_port ? Fault{"acknowledged_by_port", hex_of(*evidence.by_port)} : Fault{};
}

void Task::finish_as(const Task& other, TimePoint now) {
    is_of_another_ = other.is_of_another_;
    finish(*other.end(), now);
}

void Task::cancel(TimePoint now) { finish({Ending::cancelled, {"cancelled"}, {}}, now); }

}    // namespace ano::host
