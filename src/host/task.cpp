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
    std::string what = hex_of(device_.address()) + " answers too slowly: given up after " + std::to_string(seconds) + " s";
    finish({Ending::timeout, what.append(half_done()), {}}, now);
    return true;
}

void Task::ask(const Request& request, TimePoint now) {
    if (is_overdue(now)) return;
    Request meant = request;
    meant.identity = identity_;
    meant.needs_info = true;
    meant.compares_info = compares_info_;
    meant.present_device = std::exchange(means_present_device_, false);
    if (!device_.ask(meant, *this)) finish({Ending::invalid, hex_of(device_.address()) + " has no such parameter", {}}, now);
}

void Task::not_meant(const Ended& ended, TimePoint now) {
    if (ended.outcome == Outcome::unidentified) return finish_silent("device info", ended.evidence, now);
    finish_another(ended.evidence.sent > 0 ? order() : std::string{}, now);
}

void Task::finish_another(std::string_view may_be_done, TimePoint now, std::string_view left) {
    be_of_another();
    std::string what = format_another_device();
    if (!may_be_done.empty()) what += "; the one before may have carried out: " + std::string{may_be_done};
    if (!left.empty()) what += "; " + std::string{left};
    finish({Ending::failed, std::move(what), {}}, now);
}

void Task::finish(End end, TimePoint now) {
    if (end_) return;
    device_.forget(*this);
    end_ = std::move(end);
    if (on_end_) on_end_(now);
}

void Task::finish_silent(std::string_view step, const Evidence& evidence, TimePoint now, std::string_view likely) {
    finish_unanswered("is online, but did not answer the request for its ", step, evidence, now, likely);
}

void Task::finish_without_info(std::string_view step, const Evidence& evidence, TimePoint now) {
    const bool answers = evidence.round_trip.has_value();
    finish_silent(step, evidence, now, answers ? "it has answered other requests" : "frames to it may not arrive");
}

void Task::finish_unacknowledged(std::string_view order, const Evidence& evidence, TimePoint now, std::string_view likely) {
    if (evidence.unfit.empty()) return finish_unanswered("is online, but did not acknowledge: ", order, evidence, now, likely);
    finish_unanswered("acknowledged with wrong check bytes (" + spaced_hex(evidence.unfit) + "): ", order, evidence, now, {});
}

void Task::finish_unanswered(const std::string& heard_but, std::string_view step, const Evidence& evidence, TimePoint now,
                             std::string_view likely) {
    std::string what = hex_of(device_.address()) + ' ' + (evidence.is_heard ? heard_but : "does not answer: ") +
                       std::string{step} + ", sent " + std::to_string(evidence.sent) + (evidence.sent == 1 ? " time" : " times");
    if (evidence.is_heard && !likely.empty()) what += "; " + std::string{likely};
    finish({Ending::timeout, std::move(what), evidence}, now);
}

std::string Task::format_port_answer(const Evidence& evidence) {
    return evidence.by_port ? "acknowledged by " + hex_of(*evidence.by_port) + ", a port" : std::string{};
}

void Task::finish_as(const Task& other, TimePoint now) {
    is_of_another_ = other.is_of_another_;
    finish(*other.end(), now);
}

void Task::cancel(TimePoint now) { finish({Ending::cancelled, "cancelled", {}}, now); }

}    // namespace ano::host
