#include <host/parameter_apply.hpp>

#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>

namespace ano::host {
namespace {

// Whether the device answers and did not accept this value: it may accept others.
bool is_refusal(const ParameterWrite& write) {
    const Ending ending = write.end()->ending;
    return ending == Ending::refused || ending == Ending::invalid || ending == Ending::unsupported ||
           (ending == Ending::timeout && write.stored());
}

}    // namespace

ParameterApply::ParameterApply(Device& device, DescriptionCache* cache,
                               const std::vector<std::pair<std::string, AnyValue>>& values, ApplyOptions options)
    : Task{device},
      options_{std::move(options)},
      cache_{cache != nullptr ? cache : &own_cache_},
      parameters_{device, cache_},
      repeated_(values.size()),
      undone_again_(values.size()) {
    rows_.reserve(values.size());
    for (const auto& [name, value] : values) rows_.push_back({name, value});
}

void ParameterApply::start(TimePoint now) {
    parameters_.on_end([this](TimePoint then) { described(then); });
    std::vector<std::string> names;
    for (const Row& row : rows_) names.push_back(row.name);
    if (options_.ids.empty()) return parameters_.read_named(std::move(names), now);
    parameters_.read_where(
        [names = std::move(names)](const ParameterInfo& one) {
            return std::find(names.begin(), names.end(), one.name) != names.end();
        },
        now);
}

Found ParameterApply::found(std::size_t row) const {
    const auto id = row < options_.ids.size() ? options_.ids[row] : std::nullopt;
    if (!id) return parameters_.find(rows_[row].name);
    const auto& all = parameters_.descriptions();
    return {*id < all.size() && all[*id].name == rows_[row].name ? &all[*id] : nullptr, false};
}

void ParameterApply::described(TimePoint now) {
    if (end()) return;
    if (parameters_.end()->ending != Ending::done) return finish_as(parameters_, now);
    if (!check(now)) return;
    if (options_.dry_run) return finish({}, now);
    renew_identity();
    presence_ = device().presence();
    announcements_ = device().announcements();
    compared_ = parameters_.doubts();
    signs_ = device().signs();
    next(now);
}

bool ParameterApply::is_restarted() const noexcept {
    return lost_ > 0 || device().announcements() != announcements_ || device().presence() != presence_;
}

// A restart loses values that were not saved.
Fault ParameterApply::restart() const {
    if (device().announcements() != announcements_) return {"device_restarted"};
    if (device().presence() != presence_) return {"device_was_offline"};
    return lost_ > 0 ? Fault{"device_probably_restarted"} : Fault{};
}

bool ParameterApply::is_same(const AnyValue& wanted, const AnyValue& has, const ParameterInfo& info) const {
    if (same_bytes(wanted, has, info)) return true;
    const auto* const one = std::get_if<std::string>(&wanted);
    const auto* const other = std::get_if<std::string>(&has);
    return one != nullptr && other != nullptr && options_.same_text && options_.same_text(*one, *other);
}

// Why the row can't be written, as far as known before writing; empty: it can.
Fault ParameterApply::fault_of(const Row& row, const Found& found) const {
    if (found.several) return {"several_parameters", row.name};
    if (found.parameter == nullptr) return {"unknown_parameter", row.name};
    if (!found.parameter->type) return {"unknown_type", row.name};
    const ParameterInfo& info = *found.parameter;
    std::vector<std::uint8_t> wire;
    Misfit misfit = with_range(append(wire, row.wanted, info), info);
    const Bytes has = parameters_.bytes(info.id);
    const auto before = value_of(has, info);
    const bool differs = value_of(wire, info) != before && !(before && is_same(row.wanted, *before, info));
    if (misfit.empty() && differs) misfit = length_misfit(wire.size(), has.size(), info);
    if (misfit.empty() && differs) misfit = range_misfit(row.wanted, info, options_.text);
    if (misfit.empty() && *info.type == Type::text && differs) misfit = text_misfit(wire.size(), has.size(), options_.text);
    return misfit.empty() ? misfit : Fault{"value_unfit", row.name, to_string(row.wanted), misfit};
}

// Determines which rows differ, and whether all rows can be written.
bool ParameterApply::check(TimePoint now) {
    infos_.clear();
    bool all_can = true;
    for (Row& row : rows_) {
        const Found found = this->found(infos_.size());
        row.fault = fault_of(row, found);
        infos_.push_back(found.parameter != nullptr ? *found.parameter : ParameterInfo{});
        if (found.parameter != nullptr) row.before = row.stored = parameters_.value(found.parameter->id);
        if (!row.fault.empty()) {
            row.state = State::failed;
            all_can = false;
            continue;
        }
        if (!options_.also_the_same && row.before && is_same(row.wanted, *row.before, *found.parameter)) row.state = State::same;
    }
    if (all_can) return true;
    why_ = End{Ending::invalid, {}, {}};
    finish(failure("can_not_be_written"), now);
    return false;
}

// For one failed row its reason, for several their names; `fault` of each row has its reason.
End ParameterApply::failure(SeveralId if_several) const {
    constexpr std::ptrdiff_t max_names = 5;
    std::ptrdiff_t number = 0;
    std::string names;
    End end = *why_;
    for (const Row& row : rows_) {
        if (row.state != State::failed) continue;
        if (++number == 1) end.fault = row.fault;
        if (number <= max_names) names += (number == 1 ? "" : ", ") + row.name;
    }
    if (number == 1) return end;
    Fault list = number > max_names ? Fault{"names_and_more", names, number - max_names} : Fault{"other", names};
    end.fault = {if_several, number, rows_.size(), std::move(list)};
    return end;
}

void ParameterApply::write(std::size_t row, const AnyValue& value, WriteLimits limits, void (ParameterApply::*then)(TimePoint),
                           TimePoint now) {
    last_ = std::move(write_);
    write_ = std::make_unique<ParameterWrite>(device(), infos_[row], value, limits);
    write_->mean(identity());
    if (undoing_) write_->set_known(compared_);
    else write_->set_before(parameters_.bytes(infos_[row].id), compared_);
    write_->on_end([this, then](TimePoint later) { (this->*then)(later); });
    write_->start(now);
}

void ParameterApply::next(TimePoint now) {
    while (at_ < rows_.size() && rows_[at_].state != State::waiting) ++at_;
    if (at_ == rows_.size()) return check_written(now);
    write(at_, rows_[at_].wanted, options_.text, &ParameterApply::row_ended, now);
}

void ParameterApply::row_ended(TimePoint now) {
    if (end() || undoing_) return;
    Row& row = rows_[at_];
    if (const auto stored = write_->stored()) row.stored = stored;
    const bool is_noted = std::find(touched_.begin(), touched_.end(), at_) != touched_.end();
    if (write_->was_sent() && write_->stored() != row.before && !is_noted) touched_.push_back(at_);
    End ended = *write_->end();
    if (write_->is_of_another()) be_of_another();
    if (ended.ending != Ending::done && is_restarted() && is_refusal(*write_) && !repeated_[at_]) {
        repeated_[at_] = true;
        return next(now);
    }
    if (Fault because = restart(); ended.ending != Ending::done && !is_of_another() && !because.empty())
        ended.fault.add({"written_before_lost", std::move(because)});
    row.fault = ended.fault;
    row.acknowledged = write_->was_acknowledged();
    row.wrongly_acknowledged = !ended.evidence.unfit.empty();
    if (ended.ending != Ending::done) {
        row.state = State::failed;
        if (!options_.goes_on || options_.rollback || !is_refusal(*write_)) return fail(ended, now);
        if (!why_) why_ = ended;
        ++at_;
        return next(now);
    }
    row.state = write_->is_clamped() ? State::clamped : State::written;
    if (!is_restarted() && device().signs() == signs_) compared_ = write_->known().value_or(compared_);
    ++at_;
    next(now);
}

void ParameterApply::fail(const End& end, TimePoint now) {
    if (!options_.rollback) return finish(end, now);
    why_ = end;
    undoing_ = true;
    if (is_of_another()) undo_no_more();
    undo_next(now);
}

void ParameterApply::read_again(void (ParameterApply::*then)(TimePoint), TimePoint now) {
    std::vector<std::uint16_t> ids;
    for (std::size_t i = 0; i < rows_.size(); ++i)
        if (is_read_again(rows_[i])) ids.push_back(infos_[i].id);
    last_again_ = std::move(again_);
    again_ = std::make_unique<Parameters>(device(), cache_);
    again_->on_end([this, then](TimePoint later) { (this->*then)(later); });
    again_->read_numbered(std::move(ids), now);
}

bool ParameterApply::is_read_again(const Row& row) const noexcept {
    if (undoing_) return row.before.has_value();
    return row.state == State::written || row.state == State::clamped || (row.state == State::same && is_restarted());
}

// Whether the device has this value, according to the last reading.
bool ParameterApply::has(std::size_t row, const std::optional<AnyValue>& value) const {
    const auto read = again_->value(infos_[row].id);
    return read && value && same_bytes(*read, *value, infos_[row]);
}

void ParameterApply::check_written(TimePoint now) {
    const auto number = std::count_if(rows_.begin(), rows_.end(), [this](const Row& row) { return is_read_again(row); });
    if (number == 0 || (number == 1 && !is_restarted())) return finish_written(now);
    read_again(&ParameterApply::written_is_read, now);
}

void ParameterApply::written_is_read(TimePoint now) {
    if (end() || undoing_) return;
    if (again_->end()->ending != Ending::done) return fail(*again_->end(), now);
    if (finds_another()) {
        be_of_another();
        return fail({Ending::failed, another_device(), {}}, now);
    }
    std::optional<End> failed;
    bool is_one_lost = false;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        Row& row = rows_[i];
        if (!is_read_again(row) || has(i, row.stored)) continue;
        ++lost_;
        if (!repeated_[i]) {
            repeated_[i] = is_one_lost = true;
            row.state = State::waiting;
            continue;
        }
        row.stored = again_->value(infos_[i].id);
        row.state = State::failed;
        const std::string who = hex_of(device().address());
        row.fault = row.stored ? Fault{"lost_again_now", who, row.name, to_string(*row.stored)}
                               : Fault{"lost_again", who, row.name};
        if (!failed) failed = End{Ending::failed, row.fault, {}};
    }
    if (failed && (options_.rollback || !options_.goes_on)) return fail(*failed, now);
    if (failed && !why_) why_ = failed;
    if (!is_one_lost) return finish_written(now);
    at_ = 0;
    next(now);
}

void ParameterApply::finish_written(TimePoint now) {
    Fault remark = restart();
    if (lost_ > 0) remark = Fault{"values_lost", remark, lost_};
    const auto is_wrong = [](const Row& row) { return row.state == State::written && row.wrongly_acknowledged; };
    if (const auto first = std::find_if(rows_.begin(), rows_.end(), is_wrong); first != rows_.end()) {
        const auto others = std::count_if(std::next(first), rows_.end(), is_wrong);
        remark.add(others > 0 ? Fault{"others_too", first->fault, others} : first->fault);
    }
    finish(why_ ? failure("were_not_written") : End{Ending::done, std::move(remark), {}}, now);
}

// In reverse order, since a parameter may depend on those before it.
void ParameterApply::undo_next(TimePoint now) {
    if (touched_.empty()) {
        const bool is_lost = std::any_of(rows_.begin(), rows_.end(),
                                         [](const Row& row) { return row.state == State::not_undone; });
        const bool is_done = std::none_of(rows_.begin(), rows_.end(), [](const Row& row) { return row.state == State::undone; });
        return is_lost || is_done ? finish_undone(now) : read_again(&ParameterApply::undone_is_read, now);
    }
    at_ = touched_.back();
    touched_.pop_back();
    write(at_, *rows_[at_].before, {.longer = true, .beyond_range = true}, &ParameterApply::undone, now);
}

void ParameterApply::undo_no_more() noexcept {
    for (; !touched_.empty(); touched_.pop_back()) rows_[touched_.back()].state = State::not_undone;
}

void ParameterApply::undone(TimePoint now) {
    if (end()) return;
    const bool back = write_->end()->ending == Ending::done && !write_->is_clamped();
    if (const auto stored = write_->stored()) rows_[at_].stored = stored;
    rows_[at_].state = back ? State::undone : State::not_undone;
    if (write_->is_of_another()) be_of_another();
    if (is_of_another() || !write_->before()) undo_no_more();    // the device does not answer questions either
    undo_next(now);
}

void ParameterApply::undone_is_read(TimePoint now) {
    if (end()) return;
    const bool is_read = again_->end()->ending == Ending::done && !finds_another();
    if (!is_read) why_->fault.add({"not_checked_back"});
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        Row& row = rows_[i];
        if (!is_read && row.state == State::undone) row.state = State::not_undone;
        if (!is_read || !row.before || has(i, row.before)) continue;
        row.stored = again_->value(infos_[i].id);
        if (!undone_again_[i]) touched_.push_back(i);
        else row.state = State::not_undone;
        undone_again_[i] = true;
    }
    if (touched_.empty()) return finish_undone(now);
    undo_next(now);
}

void ParameterApply::finish_undone(TimePoint now) {
    std::string names;
    for (const Row& row : rows_)
        if (row.state == State::not_undone) names += (names.empty() ? "" : ", ") + row.name;
    if (!names.empty()) why_->fault.add({"not_undone", names});
    finish(*why_, now);
}

void ParameterApply::cancel(TimePoint now) {
    if (end()) return;
    End end{Ending::cancelled, {"cancelled_after", at_, rows_.size()}, {}};
    if (undoing_) end.fault = {"cancelled_undoing"};
    parameters_.on_end({});
    parameters_.cancel(now);
    if (again_) {
        again_->on_end({});
        again_->cancel(now);
    }
    if (write_) {
        write_->on_end({});
        write_->cancel(now);
        const bool is_sent = write_->was_sent() && at_ < rows_.size();
        if (is_sent && !undoing_) {
            rows_[at_].state = State::failed;
            rows_[at_].fault = write_->end()->fault;
        }
        if (is_sent || (undoing_ && at_ < rows_.size())) touched_.push_back(at_);
    }
    if (!undoing_) return fail(end, now);
    for (const std::size_t row : touched_) rows_[row].state = State::not_undone;
    finish(std::move(end), now);
}

}    // namespace ano::host
