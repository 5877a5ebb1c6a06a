#include <mavlink/command_executions.hpp>

#include <algorithm>

namespace anogate::mavlink {

void CommandExecutions::receive(const StationCommand& command, ano::TimePoint now) {
    if (Execution* const before = repeated(command, now)) {
        ++repeats_;
        before->heard_at = now;
        return acknowledge_(command, before->result.value_or(Result::in_progress));
    }
    // Another one of the same kind while one runs: it would not be clear which of them an acknowledgement is for.
    const bool is_busy = std::any_of(kept_.begin(), kept_.end(), [&](const Execution& one) {
        return !one.result && one.command.from == command.from && one.command.command == command.command;
    });
    if (is_busy || (kept_.size() == max_kept && !kept_.front().result))
        return acknowledge_(command, Result::temporarily_rejected);
    if (kept_.size() == max_kept) kept_.pop_front();
    const std::uint64_t number = ++count_;
    kept_.push_back({number, command, std::nullopt, now});
    carry_out_(command, [this, number](Result result) { end(number, result); });
    if (!kept_.back().result && kept_.back().number == number) acknowledge_(command, Result::in_progress);
}

// Stations that do not count repeats send the same command again only as their next one.
CommandExecutions::Execution* CommandExecutions::repeated(const StationCommand& command, ano::TimePoint now) noexcept {
    bool is_last = true;    // of this station
    for (auto one = kept_.rbegin(); one != kept_.rend(); ++one) {
        if (one->command.from != command.from) continue;
        if (one->command.is_same(command)) {
            const ano::Duration age = now - one->heard_at;
            if (!one->result || (command.confirmation > 0 && age <= counted_repeats) || (is_last && age <= plain_repeats))
                return &*one;
        }
        is_last = false;
    }
    return nullptr;
}

void CommandExecutions::end(std::uint64_t number, Result result) {
    for (Execution& one : kept_) {
        if (one.number != number || one.result) continue;
        one.result = result;
        acknowledge_(one.command, result);
    }
}

}    // namespace anogate::mavlink
