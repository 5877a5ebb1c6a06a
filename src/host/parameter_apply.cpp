#include <host/parameter_apply.hpp>

namespace ano::host {

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

// Which of them differ, and whether all of them can be written.
bool ParameterApply::check(TimePoint now) {
    infos_.clear();
    for (Row& row : rows_) {
        const Found found = parameters_.find(row.name);
        std::string wrong;
        if (found.several) wrong = "several parameters are called " + row.name;
        else if (found.parameter == nullptr) wrong = "no parameter is called " + row.name;
        else if (!found.parameter->type) wrong = row.name + " is of a type that is not known";
        std::vector<std::uint8_t> wire;
        if (wrong.empty()) {
            const Misfit misfit = append(wire, row.wanted, *found.parameter->type);
            if (!misfit.empty()) wrong = row.name + ": " + words_of(row.wanted) + ' ' + std::string{misfit};
        }
        if (!wrong.empty()) {
            row.state = State::failed;
            row.what = wrong;
            finish({Ending::invalid, std::move(wrong), {}}, now);
            return false;
        }
        infos_.push_back(*found.parameter);
        row.before = row.stored = parameters_.value(found.parameter->id);
        if (!options_.also_the_same && row.before && same_bytes(row.wanted, *row.before, *found.parameter->type))
            row.state = State::same;
    }
    return true;
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
    if (at_ == rows_.size()) return finish({}, now);
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
        return fail(ended, now);
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

// Backwards: parameters may depend on those before them.
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
    if (!write_->before())    // it does not even answer questions: nor can the others be
        for (; !touched_.empty(); touched_.pop_back()) rows_[touched_.back()].state = State::not_undone;
    undo_next(now);
}

void ParameterApply::cancel(TimePoint now) {
    if (end()) return;
    End end{Ending::cancelled, "cancelled after " + std::to_string(at_) + " of " + std::to_string(rows_.size()), {}};
    if (undoing_) end.what += ", while it was undone";
    parameters_.on_end({});
    parameters_.cancel(now);
    if (write_) {
        write_->on_end({});
        write_->cancel(now);
        if (write_->was_sent() && at_ < rows_.size()) {
            rows_[at_].state = State::failed;
            rows_[at_].what = write_->end()->what;
            touched_.push_back(at_);
        }
    }
    if (undoing_) return finish(std::move(end), now);
    fail(end, now);
}

}    // namespace ano::host
