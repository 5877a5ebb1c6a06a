#include <ano/typed.hpp>
#include <ano/values.hpp>
#include <host/parameters.hpp>

#include <algorithm>
#include <string>
#include <utility>

namespace ano::host {
namespace {

constexpr std::size_t older_size = 4;               // of every value of an older device
constexpr std::int32_t no_parameter = INT32_MIN;    // the value of an unused number in protocol V7

// A value that is shorter than its type is not usable. A text may be empty.
bool is_usable(std::size_t size, std::optional<Type> type) noexcept {
    return !type || *type == Type::text || is_whole_value(size, type);
}

}    // namespace

void Parameters::read(Values values, TimePoint now) {
    values_wanted_ = values;
    start(now);
}

void Parameters::start(TimePoint now) {
    checks_ = 0;
    compares_ = differs_ = false;
    const bool may_be_known = cache_ != nullptr && !started_again_ && values_wanted_ != Values::all && !is_unlisted();
    const auto key = may_be_known ? key_of(device(), device().parameter_count(), now) : std::nullopt;
    if (const auto* const known = key ? cache_->find(*key) : nullptr) return start_known(*known, now);
    ask(question::device_info(ask_info), now);
}

void Parameters::start_known(const std::vector<ParameterInfo>& known, TimePoint now) {
    checks_ = 2;
    count_ = device().parameter_count();
    presence_ = device().presence();
    from_cache_ = true;
    compares_ = compares_anyway_ || !is_certain(now);
    doubts_ = device().doubts();
    signs_ = device().signs();
    descriptions_ = known;
    values_.assign(*count_, {});
    ask_named(now);
}

// Whether the cached data certainly belongs to this device.
bool Parameters::is_certain(TimePoint now) const {
    const auto* const entry = cache_->last_of(device().address());
    return entry != nullptr && device().has_no_sign_since(entry->signs, now);
}

void Parameters::step_ended(const Ended& ended, TimePoint now) {
    const bool answered = ended.outcome == Outcome::answered;
    switch (ended.tag) {
    case ask_info:
        if (!answered) return finish_without_info({"device_info"}, ended.evidence, now);
        return ask(question::parameter_count(ask_count), now);
    case ask_count:
        if (!answered)
            return finish({Ending::unsupported, {"no_parameter_count", hex_of(device().address())}, ended.evidence}, now);
        return counted(now);
    default:
        if (!answered) return finish_silent({"number_of_parameters"}, ended.evidence, now);
        return counted_again(now);
    }
}

// The device may have been away since it sent its device info: then the info is read again.
void Parameters::counted(TimePoint now) {
    if (!device().info()) return start(now);
    count_ = device().parameter_count();
    presence_ = device().presence();
    doubts_ = device().doubts();
    signs_ = device().signs();
    descriptions_.clear();
    if (is_unlisted()) return ask_unlisted(now);
    const auto* known = cache_ == nullptr ? nullptr
                                          : cache_->find({device().address(), device().presence(), *device().info(), *count_});
    if (known != nullptr && !is_certain(now)) known = nullptr;
    from_cache_ = known != nullptr;
    if (known != nullptr) descriptions_ = *known;
    if (recall()) return ask_named(now);
    descriptions_.resize(*count_);
    values_.assign(*count_, {});
    frames_.assign(from_cache_ ? 0 : *count_, {});
    votes_.clear();
    const bool all = values_wanted_ == Values::all;
    if (from_cache_) asks_ = Asks::values;
    else asks_ = all ? Asks::both : Asks::descriptions;
    if (from_cache_ && !all) return gathered(now);
    gather(asks_ == Asks::both ? 2u * *count_ : *count_, now);
}

// True if an earlier run has stored the descriptions, and only some values are wanted.
bool Parameters::recall() {
    if (cache_ == nullptr || from_cache_ || started_again_ || values_wanted_ != Values::named) return false;
    auto earlier = cache_->recall({device().address(), device().presence(), *device().info(), *count_});
    if (!earlier || earlier->size() != *count_) return false;
    compares_ = from_cache_ = true;
    descriptions_ = *std::move(earlier);
    values_.assign(*count_, {});
    return true;
}

// The cached data is wrong, or the device became another one.
void Parameters::read_again(TimePoint now) {
    started_again_ = true;
    if (cache_ != nullptr) cache_->forget(device().address());
    start(now);
}

void Parameters::ask_unlisted(TimePoint now) {
    from_cache_ = false;
    asks_ = Asks::named_values;
    named_ = unlisted_;
    const std::size_t end = std::size_t{*std::max_element(named_.begin(), named_.end())} + 1;
    descriptions_.resize(end);
    values_.assign(end, {});
    for (const std::uint16_t id : named_)
        descriptions_[id] = ParameterInfo{.id = id, .type = Type::i32, .name = std::to_string(id)};
    gather(named_.size(), now);
}

// Called when the descriptions are known: selects the values to be read.
void Parameters::ask_named(TimePoint now) {
    asks_ = compares_ ? Asks::named_both : Asks::named_values;
    named_.clear();
    for (const std::string& name : names_) {
        const Found found = may_be_numbers_ ? parameter_called(descriptions_, name) : find(name);
        if (found.parameter != nullptr) named_.push_back(static_cast<std::uint16_t>(found.parameter - descriptions_.data()));
    }
    for (std::size_t id = 0; is_wanted_ && id < descriptions_.size(); ++id)
        if (is_wanted_(descriptions_[id])) named_.push_back(static_cast<std::uint16_t>(id));
    for (const std::uint16_t id : wanted_)
        if (id < descriptions_.size()) named_.push_back(id);
    if (compares_ && named_.size() < std::max({std::size_t{1}, names_.size(), at_least_})) return read_again(now);
    gather(checks_ + (compares_ ? 2 * named_.size() : named_.size()), now);
}

Request Parameters::question(std::uint32_t i) {
    if (i < checks_) return i == 0 ? question::device_info(i) : question::parameter_count(i);
    const std::uint16_t id = id_of_question(i);
    return is_description(i) ? question::parameter_info(id, i) : question::parameter_value(id, i);
}

bool Parameters::took(std::uint32_t i, FrameView answer) {
    if (i < checks_) return true;    // Device stores them
    const std::uint16_t id = id_of_question(i);
    return is_description(i) ? accept_description(id, answer) : accept_value(id, answer);
}

// Compares a description with the cached one; if it differs, all cached data is discarded.
bool Parameters::compared(std::uint16_t id, FrameView answer) {
    const auto info = parameter_info_in(answer, descriptions_[id].layout);
    if (!info) return false;
    differs_ = differs_ || *info != descriptions_[id];
    return true;
}

bool Parameters::accept_description(std::uint16_t id, FrameView answer) {
    if (compares_) return compared(id, answer);
    auto info = parameter_info_in(answer);
    if (!info) return false;
    descriptions_[id] = std::move(*info);
    frames_[id].assign(answer.bytes().begin(), answer.bytes().end());
    votes_.count(answer);
    return true;
}

// A single description may look like another layout than the device has.
void Parameters::settle_layout() {
    const ParameterLayout layout = votes_.winner();
    for (std::size_t id = 0; id < frames_.size(); ++id)
        if (!frames_[id].empty() && descriptions_[id].layout != layout)
            if (auto info = parameter_info_in(FrameView{frames_[id]}, layout)) descriptions_[id] = std::move(*info);
    frames_.clear();
}

// If the type is not known yet, or may be that of another layout, is_usable() is called again at the end.
bool Parameters::accept_value(std::uint16_t id, FrameView answer) {
    const auto view = as<"parameter_value">(answer);
    if (!view) return false;
    const std::size_t size = view->get<"value">().size();
    if (is_unlisted() && size == sizeof no_parameter && load<std::int32_t>(view->get<"value">().data()) == no_parameter) {
        descriptions_[id] = {};
        return true;
    }
    if (!is_usable(size, descriptions_[id].type) && (from_cache_ || size != older_size)) return false;
    values_[id].assign(view->get<"value">().begin(), view->get<"value">().end());
    return true;
}

std::optional<AnyValue> Parameters::value(std::uint16_t id) const {
    return id < values_.size() ? value_of(values_[id], descriptions_[id]) : std::nullopt;
}

void Parameters::gathered(TimePoint now) {
    if (checks_ > 0) return counted_again(now);
    settle_layout();
    if (compares_) return ask(question::parameter_count(ask_count_again), now);
    const bool descriptions_are_there = missing().empty() && asks_ != Asks::named_values;
    if (values_wanted_ == Values::named && descriptions_are_there) return ask_named(now);
    ask(question::parameter_count(ask_count_again), now);
}

// Everything is read again if the device became another one meanwhile, or the cached descriptions are wrong.
void Parameters::counted_again(TimePoint now) {
    const bool changed = has_changed() || differs_;
    const auto lacking = changed ? std::nullopt : first_lacking();
    if (!started_again_ && (changed || (lacking && from_cache_))) return read_again(now);
    if (changed) return finish({Ending::failed, {"changes", hex_of(device().address()), Fault{"parameters"}}, {}}, now);
    if (lacking) return finish({Ending::incomplete, {"parameter_incomplete", *lacking}, {}}, now);
    if (cache_ != nullptr && !from_cache_ && !is_unlisted())
        cache_->store({device().address(), presence_, *device().info(), *count_}, descriptions_, signs_);
    finish({}, now);
}

bool Parameters::has_changed() const {
    const auto is_check = [&](std::uint32_t i) { return i < checks_; };
    return device().parameter_count() != count_ || !device().info() || device().presence() != presence_ ||
           std::any_of(missing().begin(), missing().end(), is_check);
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
