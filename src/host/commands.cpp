#include <ano/typed.hpp>
#include <host/commands.hpp>

#include <utility>

namespace ano::host {

std::optional<CommandInfo> command_info_in(FrameView frame, ValueType7 seven) {
    const auto said = as<"command_info">(frame);
    if (!said) return std::nullopt;
    CommandInfo info{said->get<"cmd_id">(),
                     {said->get<"cid0">(), said->get<"cid1">(), said->get<"cid2">()},
                     {},
                     false,
                     std::string{said->get<"name">()},
                     std::string{said->get<"info">()}};
    for (const std::uint8_t number : said->get<"val_type">()) {
        if (number == 0) continue;
        if (const auto type = command_value_type(number, seven)) info.types.push_back(*type);
        else info.has_unknown_type = true;
    }
    return info;
}

const CommandInfo* Commands::find(std::string_view name) const noexcept {
    const CommandInfo* found = nullptr;
    for (const CommandInfo& one : descriptions_) {
        if (one.name.empty() || one.name != name) continue;
        if (found != nullptr) return nullptr;
        found = &one;
    }
    return found;
}

Request Commands::how_many(std::uint32_t tag) { return request(Draft<"command_query">{}, tag); }

Request Commands::question(std::uint32_t i) {
    Draft<"command_query"> draft;
    (void)draft.set<"cmd">(1);
    (void)draft.set<"val">(i);
    return request(draft);
}

bool Commands::took(std::uint32_t i, FrameView answer) {
    auto info = command_info_in(answer, seven_);
    if (!info) return false;
    descriptions_[i] = std::move(*info);
    return true;
}

void Commands::step_ended(const Ended& ended, TimePoint now) {
    if (ended.outcome != Outcome::answered)
        return finish_silent("number of commands", ended.evidence, now, "it probably has none");
    const std::uint16_t count = as<"command_query">(*ended.answer)->get<"val">();
    if (ended.tag == ask_count) {
        descriptions_.assign(count, {});
        return gather(count, now);
    }
    if (count != descriptions_.size())
        return finish({Ending::failed, hex_of(device().address()) + " changes while its commands are read", {}}, now);
    if (!missing().empty())
        return finish({Ending::incomplete, "command " + std::to_string(missing().front()) + " was not described", {}}, now);
    finish({}, now);
}

CommandCall::CommandCall(Device& device, CommandInfo command, std::vector<AnyValue> values, bool repeat)
    : Task{device}, command_{std::move(command)}, values_{std::move(values)}, repeat_{repeat} {}

std::optional<std::string> CommandCall::pack(std::vector<std::uint8_t>& out) const {
    const std::size_t n = command_.types.size();
    if (values_.size() != n)
        return command_.name + " takes " + std::to_string(n) + (n == 1 ? " value" : " values") + ", not " +
               std::to_string(values_.size());
    for (std::size_t i = 0; i < n; ++i) {
        const Misfit misfit = append(out, values_[i], command_.types[i]);
        if (misfit.empty()) continue;
        return command_.name + ": value " + std::to_string(i + 1) + ", " + words_of(values_[i]) + ", " + std::string{misfit} +
               " for " + std::string{ano::name_of(command_.types[i])};
    }
    return std::nullopt;
}

void CommandCall::start(TimePoint now) {
    if (command_.has_unknown_type)
        return finish({Ending::unsupported, command_.name + " takes a value of a type that is not known", {}}, now);
    std::vector<std::uint8_t> values;
    if (auto wrong = pack(values)) return finish({Ending::invalid, std::move(*wrong), {}}, now);
    Draft<"command"> draft;
    (void)draft.set<"cid0">(command_.cid[0]);
    (void)draft.set<"cid1">(command_.cid[1]);
    (void)draft.set<"cid2">(command_.cid[2]);
    (void)draft.set<"values">(Bytes{values});
    ask(request(draft, 0, {.sends = repeat_ ? 5u : 1u, .wait = std::chrono::seconds{2}}), now);
}

void CommandCall::ended(const Ended& ended, TimePoint now) {
    if (ended.outcome == Outcome::answered) return finish({}, now);
    if (repeat_) return finish_unacknowledged("command " + command_.name, ended.evidence, now, "it probably can't do that now");
    finish({Ending::unknown,
            "no answer to " + command_.name + ": it may have been carried out" +
                (ended.evidence.is_heard ? ", or it can't be done now" : ""),
            ended.evidence},
           now);
}

void CommandCall::cancel(TimePoint now) { finish({Ending::cancelled, command_.name + " may have been carried out", {}}, now); }

}    // namespace ano::host
