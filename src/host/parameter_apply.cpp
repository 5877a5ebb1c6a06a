#include <host/parameter_apply.hpp>

namespace ano::host {
namespace {

// The device answers and did not accept this value: it may accept others.
bool is_refusal(const ParameterWrite& write) {
    const Ending ending = write.end()->ending;
    return ending == Ending::refused || ending == Ending::invalid || ending == Ending::unsupported ||
           (ending == Ending::timeout && write.stored());
}

}    // namespace

ParameterApply::ParameterApply(Device& device, DescriptionCache* cache,
                               const std::vector<std::pair<std::string, AnyValue>>& values, ApplyOptions options)
    : Task{device}, options_{options}, parameters_{device, cache} {
    rows_.reserve(values.size());
    for (const auto& [name, value] : values) rows_.push_back({name, value});
}

void ParameterApply::start(TimePoint now) {
    parameters_.on_end([this](TimePoint then) { described(then); });
    std::vector<std::string> names;
    for (const Row& row : rows_) names.push_back(row.name);
    parameters_.read_named(std::move(names), now);
}

void ParameterApply::described(TimePoint now) {
    if (end()) return;
    if (parameters_.end()->ending != Ending::done) return finish_as(parameters_, now);
    if (!check(now)) return;
    if (options_.dry_run) return finish({}, now);
    next(now);
}

// Why the row can't be written, as far as is known before writing; empty: it can.
std::string ParameterApply::fault_of(const Row& row, const Found& found) const {
    if (found.several) return "several parameters are called " + row.name;
    if (found.parameter == nullptr) return "no parameter is called " + row.name;
    if (!found.parameter->type) return row.name + " is of a type that is not known";
    const Type type = *found.parameter->type;
    std::vector<std::uint8_t> wire;
    std::string misfit = words_of_misfit(append(wire, row.wanted, type), type);
    const Bytes has = parameters_.bytes(found.parameter->id);
    const bool differs = value_of(wire, type) != value_of(has, type);
    if (misfit.empty() && type == Type::text && differs) misfit = text_misfit(wire.size(), has.size(), options_.text);
    return misfit.empty() ? misfit : row.name + ": " + words_of(row.wanted) + ' ' + misfit;
}

// Finds out which rows differ, and whether all rows can be written.
bool ParameterApply::check(TimePoint now) {
    infos_.clear();
    bool all_can = true;
    for (Row& row : rows_) {
        const Found found = parameters_.find(row.name);
        row.what = fault_of(row, found);
        infos_.push_back(found.parameter != nullptr ? *found.parameter : ParameterInfo{});
        if (found.parameter != nullptr) row.before = row.stored = parameters_.value(found.parameter->id);
        if (!row.what.empty()) {
            row.state = State::failed;
            all_can = false;
            continue;
        }
        if (!options_.also_the_same && row.before && same_bytes(row.wanted, *row.before, *found.parameter->type))
            row.state = State::same;
    }
    if (all_can) return true;
    why_ = End{Ending::invalid, {}, {}};
    finish(failure("can't be written"), now);
    return false;
}

// For one failed row its reason, for several their names: each row has its reason in `what`.
End ParameterApply::failure(const char* deed) const {
    constexpr std::size_t max_names = 5;
    std::size_t number = 0;
    std::string names, what;
    for (const Row& row : rows_) {
        if (row.state != State::failed) continue;
        if (++number == 1) what = row.what;
        if (number <= max_names) names += (number == 1 ? "" : ", ") + row.name;
    }
    End end = *why_;
    end.what = std::move(what);
    if (number == 1) return end;
    end.what = std::to_string(number) + " of " + std::to_string(rows_.size()) + " parameters " + deed + ": " + names;
    if (number > max_names) end.what += " and " + std::to_string(number - max_names) + " more";
    return end;
}

void ParameterApply::write(std::size_t row, const AnyValue& value, TextLimits limits, void (ParameterApply::*then)(TimePoint),
                           TimePoint now) {
    last_ = std::move(write_);
    write_ = std::make_unique<ParameterWrite>(device(), infos_[row], value, limits);
    write_->on_end([this, then](TimePoint later) { (this->*then)(later); });
    write_->start(now);
}

void ParameterApply::next(TimePoint now) {
    while (at_ < rows_.size() && rows_[at_].state != State::waiting) ++at_;
    if (at_ == rows_.size()) return finish(why_ ? failure("were not written") : End{}, now);
    write(at_, rows_[at_].wanted, options_.text, &ParameterApply::row_ended, now);
}

void ParameterApply::row_ended(TimePoint now) {
    if (end() || undoing_) return;
    Row& row = rows_[at_];
    if (const auto stored = write_->stored()) row.stored = stored;
    if (write_->was_sent() && write_->stored() != row.before) touched_.push_back(at_);
    const End& ended = *write_->end();
    row.what = ended.what;
    if (ended.ending != Ending::done) {
        row.state = State::failed;
        if (!options_.goes_on || options_.rollback || !is_refusal(*write_)) return fail(ended, now);
        if (!why_) why_ = ended;
        ++at_;
        return next(now);
    }
    row.state = write_->is_clamped() ? State::clamped : State::written;
    ++at_;
    next(now);
}

void ParameterApply::fail(const End& end, TimePoint now) {
    if (!options_.rollback) return finish(end, now);
    why_ = end;
    undoing_ = true;
    undo_next(now);
}

// In reverse order, since parameters may depend on those before them.
void ParameterApply::undo_next(TimePoint now) {
    if (touched_.empty()) return finish(*why_, now);
    at_ = touched_.back();
    touched_.pop_back();
    write(at_, *rows_[at_].before, {.longer = true}, &ParameterApply::undone, now);
}

void ParameterApply::undone(TimePoint now) {
    if (end()) return;
    const bool back = write_->end()->ending == Ending::done && !write_->is_clamped();
    if (const auto stored = write_->stored()) rows_[at_].stored = stored;
    rows_[at_].state = back ? State::undone : State::not_undone;
    if (!back) why_->what += "; " + rows_[at_].name + " could not be undone";
    if (!write_->before())    // the device does not answer questions either, so the others can't be undone
        for (; !touched_.empty(); touched_.pop_back()) rows_[touched_.back()].state = State::not_undone;
    undo_next(now);
}

void ParameterApply::cancel(TimePoint now) {
    if (end()) return;
    End end{Ending::cancelled, "cancelled after " + std::to_string(at_) + " of " + std::to_string(rows_.size()), {}};
    if (undoing_) end.what = "cancelled while it was undone";
    parameters_.on_end({});
    parameters_.cancel(now);
    if (write_) {
        write_->on_end({});
        write_->cancel(now);
        const bool is_sent = write_->was_sent() && at_ < rows_.size();
        if (is_sent && !undoing_) {
            rows_[at_].state = State::failed;
            rows_[at_].what = write_->end()->what;
        }
        if (is_sent || undoing_) touched_.push_back(at_);
    }
    if (!undoing_) return fail(end, now);
    for (const std::size_t row : touched_) rows_[row].state = State::not_undone;
    finish(std::move(end), now);
}

}    // namespace ano::host
