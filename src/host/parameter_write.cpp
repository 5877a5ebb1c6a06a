#include <ano/typed.hpp>
#include <ano/values.hpp>
#include <host/parameter_write.hpp>

#include <algorithm>
#include <utility>

namespace ano::host {

ParameterWrite::ParameterWrite(Device& device, ParameterInfo info, AnyValue value, TextLimits limits)
    : Task{device}, info_{std::move(info)}, value_{std::move(value)}, limits_{limits} {}

void ParameterWrite::refuse(const std::string& why, TimePoint now) {
    finish({Ending::invalid, info_.name + ": " + words_of(value_) + ' ' + why, {}}, now);
}

void ParameterWrite::start(TimePoint now) {
    if (!info_.type) return finish({Ending::unsupported, info_.name + " is of a type that is not known", {}}, now);
    const Misfit misfit = append(wire_, value_, *info_.type);
    if (!misfit.empty()) return refuse(std::string{misfit}, now);
    if (limits_.most_bytes && *info_.type == Type::text && wire_.size() > *limits_.most_bytes)
        return refuse("is longer than " + std::to_string(*limits_.most_bytes) + " bytes", now);
    if (device().parameter_count()) return counted(now);
    ask(question::parameter_count(ask_count), now);
}

void ParameterWrite::counted(TimePoint now) {
    if (info_.id >= device().parameter_count().value_or(0))
        return finish({Ending::invalid, hex_of(device().address()) + " has no parameter " + std::to_string(info_.id), {}}, now);
    ask_value(read_before, now);
}

void ParameterWrite::ask_value(Step step, TimePoint now) {
    step_ = step;
    ask(question::parameter_value(info_.id, step), now);
}

void ParameterWrite::ended(const Ended& ended, TimePoint now) {
    const bool answered = ended.outcome == Outcome::answered;
    if (ended.outcome == Outcome::not_there)
        return finish({Ending::invalid, hex_of(device().address()) + " no longer has parameter " + std::to_string(info_.id), {}},
                      now);
    switch (ended.tag) {
    case ask_count: return answered ? counted(now) : finish_silent("number of parameters", ended.evidence, now);
    case write_value: return answered ? ask_value(read_back, now) : finish_silent("write of " + info_.name, ended.evidence, now);
    default:
        if (answered) return took(ended, now);
        if (ended.tag == read_before) return finish_silent("value of " + info_.name, ended.evidence, now);
        finish({Ending::refused, hex_of(device().address()) + " acknowledged " + info_.name + " and does not give it back",
                ended.evidence},
               now);
    }
}

void ParameterWrite::took(const Ended& ended, TimePoint now) {
    const Bytes value = as<"parameter_value">(*ended.answer)->get<"value">();
    if (*info_.type != Type::text && !is_whole_value(value.size(), info_.type))
        return finish(
            {Ending::failed, hex_of(device().address()) + " gives " + info_.name + " shorter than its type", ended.evidence},
            now);
    auto& kept = ended.tag == read_before ? before_ : stored_;
    kept.assign(value.begin(), value.end());
    if (ended.tag == read_before) return write(now);
    if (ended.tag == read_back && !same(stored_, wire_)) return ask_value(read_again, now);
    compare(now);
}

// A shorter text is filled up with NULs, so that nothing of the old one stays behind it.
void ParameterWrite::write(TimePoint now) {
    std::vector<std::uint8_t> value = wire_;
    if (*info_.type == Type::text) {
        if (value.size() > before_.size() && !limits_.longer)
            return refuse("is longer than the " + std::to_string(before_.size()) + " bytes that the device has", now);
        value.resize(
            std::max({value.size(), std::min(before_.size(), limits_.most_bytes.value_or(before_.size())), std::size_t{1}}));
    }
    step_ = write_value;
    Draft<"parameter_value"> draft;
    (void)draft.set<"par_id">(info_.id);
    (void)draft.set<"value">(Bytes{value});
    ask(request(draft, write_value), now);
}

void ParameterWrite::compare(TimePoint now) {
    if (!same(stored_, wire_) && same(stored_, before_))
        return finish({Ending::refused,
                       hex_of(device().address()) + " keeps " + info_.name + " at " + words_of(decoded(before_).value_or(value_)),
                       {}},
                      now);
    std::string what;
    if (!same(stored_, wire_))
        what = info_.name + " is " + words_of(decoded(stored_).value_or(value_)) + ": the device clamped it";
    finish({Ending::done, std::move(what), {}}, now);
}

// Behind its type, or behind the NUL of a text, bytes mean nothing.
bool ParameterWrite::same(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b) const {
    if (*info_.type == Type::text) return decoded(a) == decoded(b);
    const auto n = static_cast<std::ptrdiff_t>(width(*info_.type));
    return std::equal(a.begin(), a.begin() + n, b.begin(), b.begin() + n);
}

std::optional<AnyValue> ParameterWrite::decoded(const std::vector<std::uint8_t>& bytes) const {
    if (bytes.empty() || !info_.type) return std::nullopt;
    return value_of(bytes, *info_.type);
}

void ParameterWrite::cancel(TimePoint now) {
    finish({Ending::cancelled, was_sent() ? info_.name + " may have been written" : info_.name + " was not written", {}}, now);
}

Request action(Action action, std::uint32_t tag) {
    Draft<"parameter_command", "action"> draft;
    (void)draft.set<"val">(static_cast<std::uint16_t>(action));
    return request(draft, tag, Patience{.wait = std::chrono::seconds{5}});
}

void ParameterAction::ended(const Ended& ended, TimePoint now) {
    if (ended.outcome == Outcome::answered) return finish({}, now);
    const Message& row = Draft<"parameter_command", "action">::message();
    finish_silent(row.field("val")->meaning(static_cast<std::uint64_t>(action_)), ended.evidence, now);
}

}    // namespace ano::host
