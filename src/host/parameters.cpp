#include <ano/typed.hpp>
#include <ano/values.hpp>
#include <host/parameters.hpp>

#include <algorithm>
#include <string>
#include <utility>

namespace ano::host {
namespace {

// A value that is shorter than its type is not usable. A text may be empty.
bool is_usable(std::size_t size, std::optional<Type> type) noexcept {
    return !type || *type == Type::text || is_whole_value(size, type);
}

}    // namespace

void Parameters::read(Values values, TimePoint now) {
    values_wanted_ = values;
    start(now);
}

void Parameters::start(TimePoint now) { ask(question::device_info(ask_info), now); }

void Parameters::step_ended(const Ended& ended, TimePoint now) {
    const bool answered = ended.outcome == Outcome::answered;
    switch (ended.tag) {
    case ask_info:
        if (!answered) return finish_silent("device info", ended.evidence, now, "what is sent to it probably does not arrive");
        return ask(question::parameter_count(ask_count), now);
    case ask_count:
        if (!answered)
            return finish(
                {Ending::unsupported, hex_of(device().address()) + " does not say how many parameters it has", ended.evidence},
                now);
        return counted(now);
    default:
        if (!answered) return finish_silent("number of parameters", ended.evidence, now);
        return counted_again(now);
    }
}

// The device may have been away since it sent its device info: then that is read again.
void Parameters::counted(TimePoint now) {
    if (!device().info()) return start(now);
    count_ = device().parameter_count();
    presence_ = device().presence();
    descriptions_.clear();
    const auto* known = cache_ == nullptr ? nullptr
                                          : cache_->find({device().address(), device().presence(), *device().info(), *count_});
    from_cache_ = known != nullptr;
    if (known != nullptr) descriptions_ = *known;
    descriptions_.resize(*count_);
    values_.assign(*count_, {});
    const bool all = values_wanted_ == Values::all;
    if (from_cache_) asks_ = Asks::values;
    else asks_ = all ? Asks::both : Asks::descriptions;
    if (from_cache_ && !all) return gathered(now);
    gather(asks_ == Asks::both ? 2u * *count_ : *count_, now);
}

// Called when the descriptions are there: selects the values to be read.
void Parameters::ask_named(TimePoint now) {
    asks_ = Asks::named_values;
    named_.clear();
    for (const std::string& name : names_)
        if (const auto* found = find(name).parameter) named_.push_back(found->id);
    for (const std::uint16_t id : wanted_)
        if (id < descriptions_.size()) named_.push_back(id);
    gather(named_.size(), now);
}

Request Parameters::question(std::uint32_t i) {
    const std::uint16_t id = id_of_question(i);
    return is_description(i) ? question::parameter_info(id, i) : question::parameter_value(id, i);
}

bool Parameters::took(std::uint32_t i, FrameView answer) {
    const std::uint16_t id = id_of_question(i);
    return is_description(i) ? took_description(id, answer) : took_value(id, answer);
}

bool Parameters::took_description(std::uint16_t id, FrameView answer) {
    auto info = parameter_info_in(answer);
    if (!info) return false;
    descriptions_[id] = std::move(*info);
    return true;
}

// If the type is not known yet, is_usable() is called again at the end.
bool Parameters::took_value(std::uint16_t id, FrameView answer) {
    const auto said = as<"parameter_value">(answer);
    if (!said || !is_usable(said->get<"value">().size(), descriptions_[id].type)) return false;
    values_[id].assign(said->get<"value">().begin(), said->get<"value">().end());
    return true;
}

std::optional<AnyValue> Parameters::value(std::uint16_t id) const {
    if (id >= values_.size() || !descriptions_[id].type) return std::nullopt;
    return value_of(values_[id], *descriptions_[id].type);
}

void Parameters::gathered(TimePoint now) {
    const bool descriptions_are_there = missing().empty() && asks_ != Asks::named_values;
    if (values_wanted_ == Values::named && descriptions_are_there) return ask_named(now);
    ask(question::parameter_count(ask_count_again), now);
}

// Everything is read again when the device became another one meanwhile, or when the cached descriptions are wrong.
void Parameters::counted_again(TimePoint now) {
    const auto lacking = first_lacking();
    const bool changed = device().parameter_count() != count_ || !device().info() || device().presence() != presence_;
    if (!started_again_ && (changed || (lacking && from_cache_))) {
        started_again_ = true;
        if (cache_ != nullptr) cache_->forget(device().address());
        return start(now);
    }
    if (changed) return finish({Ending::failed, hex_of(device().address()) + " changes while its parameters are read", {}}, now);
    if (lacking) return finish({Ending::incomplete, "parameter " + std::to_string(*lacking) + " did not come whole", {}}, now);
    if (cache_ != nullptr && !from_cache_)
        cache_->store({device().address(), presence_, *device().info(), *count_}, descriptions_);
    finish({}, now);
}

std::optional<std::uint16_t> Parameters::first_lacking() const {
    if (!missing().empty()) return id_of_question(missing().front());
    const auto lacks_value = [&](std::uint16_t id) { return !is_usable(values_[id].size(), descriptions_[id].type); };
    if (values_wanted_ == Values::named) {
        const auto first = std::find_if(named_.begin(), named_.end(), lacks_value);
        return first == named_.end() ? std::nullopt : std::optional{*first};
    }
    for (std::uint16_t id = 0; values_wanted_ == Values::all && id < descriptions_.size(); ++id)
        if (lacks_value(id)) return id;
    return std::nullopt;
}

}    // namespace ano::host
