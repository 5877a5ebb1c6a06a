#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <ano/values.hpp>
#include <host/parameter_write.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

namespace ano::host {

namespace {

constexpr FaultId<> not_accepted{"accepts_no_such_value"};

Fault fault_of(const Evidence& silence) {
    if (silence.unfit.empty()) return {"without_acknowledgement"};
    return {"with_wrong_check_bytes", spaced_hex(silence.unfit)};
}

}    // namespace

Misfit text_misfit(std::size_t size, std::size_t had, const WriteLimits& limits) {
    if (limits.max_bytes && size > *limits.max_bytes) return {"longer_than_possible", *limits.max_bytes};
    return size <= had || limits.longer ? Misfit{} : Misfit{"longer_than_before", had};
}

Misfit range_misfit(const AnyValue& value, const ParameterInfo& info, const WriteLimits& limits) {
    if (!info.limits || limits.beyond_range || info.limits->min >= info.limits->max)
        return {};    // min >= max: no range is
                      // stated
    const auto as_real = [](const auto& plain) -> std::optional<double> {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(plain)>>) return static_cast<double>(plain);
        else return std::nullopt;
    };
    const auto number = std::visit(as_real, value);
    if (!number || (*number >= info.limits->min && *number <= info.limits->max)) return {};
    return {"out_of_stated_range", info.limits->min, info.limits->max};
}

ParameterWrite::ParameterWrite(Device& device, ParameterInfo info, AnyValue value, WriteLimits limits)
    : Task{device}, info_{std::move(info)}, value_{std::move(value)}, limits_{limits} {}

void ParameterWrite::refuse(const Misfit& why, TimePoint now) {
    finish({Ending::invalid, {"value_unfit", info_.name, to_string(value_), why}, {}}, now);
}

void ParameterWrite::start(TimePoint now) {
    if (!info_.type) return finish({Ending::unsupported, {"unknown_type", info_.name}, {}}, now);
    const Misfit misfit = append(wire_, value_, info_);
    if (!misfit.empty()) return refuse(with_range(misfit, info_), now);
    if (const Misfit beyond = range_misfit(value_, info_, limits_); !beyond.empty()) return refuse(beyond, now);
    const Misfit too_long = *info_.type == Type::text ? text_misfit(wire_.size(), wire_.size(), limits_) : Misfit{};
    if (!too_long.empty()) return refuse(too_long, now);
    if (!doubts_) doubts_ = device().doubts();
    count_ = device().parameter_count();
    if (before_ && doubts_ == device().doubts()) step_ = write_value;
    go_on(now);
}

void ParameterWrite::set_before(Bytes value, std::uint32_t doubts) {
    before_.emplace(value.begin(), value.end());
    doubts_ = doubts;
}

// Sends the request of the step. If the device was away or may have restarted, its parameter count and the description are read
// first.
void ParameterWrite::go_on(TimePoint now) {
    const auto count = device().parameter_count();
    if (!count) return ask(question::parameter_count(ask_count), now);
    if (info_.id >= *count && !device().is_asked_by_number())
        return finish({Ending::invalid, {"no_parameter", hex_of(device().address()), info_.id}, {}}, now);
    if (device().doubts() != doubts_) return ask_description(now);
    if (step_ == write_value) return write(now);
    ask(question::parameter_value(info_.id, step_), now);
}

// Units of one type have the same device info but may have other parameters, because of other firmware or options.
void ParameterWrite::ask_description(TimePoint now) {
    Request count = question::parameter_count(recount);
    count.of_same = true;
    ask(count, now);
}

void ParameterWrite::described(const Ended& ended, TimePoint now) {
    const auto info = parameter_info_in(*ended.answer, info_.layout);
    if (!info || info->name != info_.name || info->type != info_.type || info->mul != info_.mul)
        return finish_another(was_sent_ ? order() : Fault{}, now);
    doubts_ = device().doubts();
    go_on(now);
}

void ParameterWrite::ended(const Ended& ended, TimePoint now) {
    if (ended.tag == read_early) return read_along(ended, now);
    if (ended.outcome == Outcome::not_there) return go_on(now);
    if (ended.outcome == Outcome::uncertain) was_silent(ended.evidence);
    if (ended.outcome == Outcome::uncertain && ++uncertain_ <= max_uncertain) return ask_description(now);
    const bool answered = ended.outcome == Outcome::answered;
    const bool is_compared = ended.tag == recount || ended.tag == describe;
    if (is_compared && !answered && silence_) return finish_not_returned(ended, now);
    switch (ended.tag) {
    case ask_count: return answered ? go_on(now) : finish_silent({"number_of_parameters"}, ended.evidence, now);
    case recount:
        if (!answered) return finish_silent({"number_of_parameters"}, ended.evidence, now);
        if (count_ && device().parameter_count() != count_) return finish_another(was_sent_ ? order() : Fault{}, now);
        if (device().is_asked_by_number()) {    // nothing describes it
            doubts_ = device().doubts();
            return go_on(now);
        }
        return ask(question::parameter_info(info_.id, describe), now);
    case describe: return answered ? described(ended, now) : finish_silent({"description_of", info_.name}, ended.evidence, now);
    case write_value: return written(ended, now);
    default:
        if (answered) return took(ended, now);
        if (ended.tag == read_before) return finish_silent({"value_of", info_.name}, ended.evidence, now);
        finish_not_returned(ended, now);
    }
}

// Without a fitting acknowledgement, the value that is read back shows whether the write was carried out.
void ParameterWrite::written(const Ended& ended, TimePoint now) {
    if (ended.outcome == Outcome::timeout) was_silent(ended.evidence);
    if (ended.outcome == Outcome::answered) {
        silence_.reset();
        acknowledgement_ = ended.evidence;
    }
    was_repeated_ = was_repeated_ || ended.evidence.sent > 1 || uncertain_ > 0;
    write_ended_ = true;
    both_ended(now);
}

void ParameterWrite::was_silent(const Evidence& evidence) {
    sends_ += evidence.sent;
    silence_ = evidence;
    silence_->sent = sends_;
}

void ParameterWrite::not_meant(const Ended& ended, TimePoint now) {
    if (ended.outcome == Outcome::unidentified && silence_) return finish_not_returned(ended, now);
    if (ended.outcome == Outcome::another && was_sent_) return finish_another(order(), now);
    Task::not_meant(ended, now);
}

void ParameterWrite::read_along(const Ended& ended, TimePoint now) {
    if (step_ != write_value) return;
    const auto value = ended.outcome == Outcome::answered ? std::optional{as<"parameter_value">(*ended.answer)->get<"value">()}
                                                          : std::nullopt;
    if (value && (*info_.type == Type::text || is_whole_value(value->size(), info_.type)))
        stored_.emplace(value->begin(), value->end());
    early_ended_ = true;
    both_ended(now);
}

void ParameterWrite::both_ended(TimePoint now) {
    if (!write_ended_ || !early_ended_) return;
    if (stored_ && is_as_written()) return compare(now);
    if (stored_ && !was_repeated_ && !silence_) return ask_value(read_again, now);
    stored_.reset();
    ask_value(read_back, now);
}

void ParameterWrite::finish_not_returned(const Ended& ended, TimePoint now) {
    if (silence_) return finish_unacknowledged({"uncertain_write_of", info_.name}, *silence_, now, {not_accepted});
    finish({Ending::refused, {"not_returned", hex_of(device().address()), info_.name}, ended.evidence}, now);
}

void ParameterWrite::took(const Ended& ended, TimePoint now) {
    const Bytes value = as<"parameter_value">(*ended.answer)->get<"value">();
    if (*info_.type != Type::text && !is_whole_value(value.size(), info_.type))
        return finish({Ending::failed, {"shorter_than_type", hex_of(device().address()), info_.name}, ended.evidence}, now);
    auto& kept = ended.tag == read_before ? before_ : stored_;
    kept.emplace(value.begin(), value.end());
    if (ended.tag == read_before) return ask_value(write_value, now);
    if (ended.tag == read_back && !is_as_written()) {
        stored_.reset();    // it may be an answer from before the write
        return ask_value(read_again, now);
    }
    compare(now);
}

// A shorter text is padded with NULs, so that no part of the old text remains after it.
void ParameterWrite::write(TimePoint now) {
    Wire value = wire_;
    if (*info_.type == Type::text) {
        const std::size_t had = before_->size();
        if (const Misfit too_long = text_misfit(value.size(), had, limits_); !too_long.empty()) return refuse(too_long, now);
        value.resize(std::max({value.size(), std::min(had, limits_.max_bytes.value_or(had)), std::size_t{1}}));
    }
    if (const Misfit other_length = length_misfit(value.size(), before_->size(), info_); !other_length.empty())
        return refuse(other_length, now);
    was_sent_ = true;
    write_ended_ = early_ended_ = false;
    Draft<"parameter_value"> draft;
    (void)draft.set<"par_id">(info_.id);
    (void)draft.set<"value">(Bytes{value});
    ask(request(draft, write_value), now);
    if (!end()) ask(question::parameter_value(info_.id, read_early), now);
}

void ParameterWrite::compare(TimePoint now) {
    if (is_as_written())
        return finish(
            {Ending::done, silence_ ? Fault{"written_but", info_.name, fault_of(*silence_)} : port_answer(acknowledgement_),
             silence_.value_or(acknowledgement_)},
            now);
    if (same(*stored_, *before_) && silence_) return finish_unacknowledged(order(), *silence_, now, {not_accepted});
    if (same(*stored_, *before_))
        return finish({Ending::refused,
                       {"keeps_old_value", hex_of(device().address()), info_.name, to_string(before().value_or(value_))},
                       {}},
                      now);
    if ((silence_ || was_repeated_) && !std::exchange(is_compared_, true)) {
        device().doubt();
        return ask_value(read_again, now);
    }
    const std::string has = to_string(stored().value_or(value_));
    if (silence_) return finish({Ending::timeout, {"neither_value", info_.name, has, fault_of(*silence_)}, *silence_}, now);
    finish({Ending::done, {"device_limited", info_.name, has}, {}}, now);
}

// Bytes beyond the size of the type, or after the NUL of a text, are ignored.
bool ParameterWrite::same(const Wire& a, const Wire& b) const {
    if (*info_.type == Type::text) return decoded(a) == decoded(b);
    const auto n = static_cast<std::ptrdiff_t>(width(*info_.type));
    return std::equal(a.begin(), a.begin() + n, b.begin(), b.begin() + n);
}

// The device stored the value, as exactly as required.
bool ParameterWrite::is_as_written() const {
    if (same(*stored_, wire_)) return true;
    const auto number = [this](const Wire& bytes) {
        const auto value = decoded(bytes);
        const auto* real = value ? std::get_if<double>(&*value) : nullptr;
        return real != nullptr ? std::optional{*real} : std::nullopt;
    };
    const auto has = number(*stored_), wanted = number(wire_);
    return has && wanted && std::abs(*has - *wanted) <= limits_.rounding;
}

std::optional<AnyValue> ParameterWrite::decoded(const Wire& bytes) const { return value_of(bytes, info_); }

void ParameterWrite::cancel(TimePoint now) {
    finish({Ending::cancelled, was_sent() ? Fault{"may_be_written", info_.name} : Fault{"not_written", info_.name}, {}}, now);
}

Request action(Action action, std::uint32_t tag) {
    Draft<"parameter_command", "action"> draft;
    (void)draft.set<"val">(static_cast<std::uint16_t>(action));
    // Each save wears the flash, and a late reset would undo later writes.
    const bool has_effects = action == Action::save || action == Action::restore_defaults;
    return request(draft, tag, Patience{.sends = has_effects ? 2u : 5u, .wait = std::chrono::seconds{5}});
}

Fault ParameterAction::order() const {
    return {"other", Draft<"parameter_command", "action">::message().field("val")->meaning(static_cast<std::uint64_t>(action_))};
}

void ParameterAction::ended(const Ended& ended, TimePoint now) {
    if (ended.outcome == Outcome::answered) return finish({Ending::done, port_answer(ended.evidence), ended.evidence}, now);
    finish_unacknowledged(order(), ended.evidence, now, {"cannot_do"});
}

void ParameterAction::cancel(TimePoint now) { finish({Ending::cancelled, {"may_be_carried_out", order()}, {}}, now); }

}    // namespace ano::host
