#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <host/commands.hpp>

#include <algorithm>
#include <utility>

namespace ano::host {
namespace {

constexpr std::uint8_t open_number = 7;    // f32 or u64

bool has_seven(const CommandInfo& info) noexcept {
    return std::find(info.numbers.begin(), info.numbers.end(), open_number) != info.numbers.end();
}

// Whether it has a value type that only the newest generation has.
bool is_of_newest(const CommandInfo& info) noexcept {
    return std::any_of(info.numbers.begin(), info.numbers.end(),
                       [](std::uint8_t number) { return command_value_type(number, ValueType7::u64) && number > open_number; });
}

}    // namespace

std::optional<CommandInfo> command_info_in(FrameView frame) {
    const auto view = as<"command_info">(frame);
    if (!view) return std::nullopt;
    CommandInfo info{view->get<"cmd_id">(),
                     {view->get<"cid0">(), view->get<"cid1">(), view->get<"cid2">()},
                     {},
                     false,
                     std::string{view->get<"name">()},
                     std::string{view->get<"info">()}};
    for (const std::uint8_t number : view->get<"val_type">())
        if (number != 0) info.numbers.push_back(number);
    info = with_type_7(std::move(info), ValueType7::f32);
    info.has_open_type = has_seven(info);
    return info;
}

CommandInfo with_type_7(CommandInfo info, ValueType7 seven) {
    info.types.clear();
    info.has_open_type = false;
    for (const std::uint8_t number : info.numbers) {
        if (const auto type = command_value_type(number, seven)) info.types.push_back(*type);
        else info.has_unknown_type = true;
    }
    return info;
}

std::optional<ValueType7> reported_type_7(const CommandInfo& info) noexcept {
    if (info.has_open_type) return std::nullopt;
    std::size_t at = 0;
    for (const std::uint8_t number : info.numbers) {
        if (!command_value_type(number, ValueType7::f32)) continue;    // unknown types have no entry in `types`
        if (number == open_number && at < info.types.size())
            return info.types[at] == Type::u64 ? ValueType7::u64 : ValueType7::f32;
        ++at;
    }
    return std::nullopt;
}

const CommandInfo* find_command(std::span<const CommandInfo> all, std::string_view name) noexcept {
    const CommandInfo* found = nullptr;
    for (const CommandInfo& one : all) {
        if (one.name.empty() || one.name != name) continue;
        if (found != nullptr) return nullptr;
        found = &one;
    }
    return found;
}

const std::vector<CommandInfo>* known_commands(CommandCache& cache, const Device& device, TimePoint now) {
    const auto key = key_of(device, device.command_count(), now);
    return key ? cache.find(*key) : nullptr;
}

bool is_same_command(const CommandInfo& one, const CommandInfo& other) noexcept {
    return one.id == other.id && one.cid == other.cid && one.numbers == other.numbers && one.name == other.name;
}

const std::vector<CommandInfo>* commands_read_last(CommandCache& cache, const Device& device) {
    const auto* const entry = cache.last_of(device.address());
    if (entry == nullptr) return nullptr;
    const bool is_other = (device.info() && *device.info() != entry->key.info) ||
                          (device.command_count() && *device.command_count() != entry->key.count);
    return is_other ? nullptr : &entry->descriptions;
}

void CommandCheck::start(TimePoint now) {
    losses_ = device().losses();
    Draft<"command_query"> draft;
    (void)draft.set<"cmd">(1);
    (void)draft.set<"val">(known_.id);
    device().identify_for_command(now);
    Request question = request(draft, 0, device().patience_before_command());
    question.urgent = true;
    ask(question, now);
}

void CommandCheck::ended(const Ended& ended, TimePoint now) {
    const auto* const last = commands_read_last(cache_, device());
    const auto described = ended.outcome == Outcome::answered ? command_info_in(*ended.answer) : std::nullopt;
    if (finds_another()) {
        found_ = Found::another;
    } else if (ended.outcome != Outcome::answered) {
        found_ = found_without_answer(now);
    } else if (!described || !is_same_command(*described, known_)) {
        found_ = Found::another;
    } else {
        found_ = Found::same;
        if (last != nullptr && known_.id < last->size()) {
            CommandInfo& kept = cache_.last_of(device().address())->descriptions[known_.id];
            kept.signs = device().signs();
            kept.presence = device().presence();
        }
    }
    finish({}, now);
}

CommandCheck::Found CommandCheck::found_without_answer(TimePoint now) const {
    if (commands_read_last(cache_, device()) == nullptr) return Found::another;
    if (device().is_lost() || device().losses() != losses_) return Found::interrupted;
    return known_.presence != device().presence() && device().is_present(now) ? Found::unknown : Found::unconfirmed;
}

void Commands::read(TimePoint now) {
    ask(how_many(ask_count), now);
    const bool is_known = device().info() && device().is_present(now);
    if (!end() && cache_ != nullptr && !is_known) ask(question::device_info(ask_info), now);
}

Request Commands::how_many(std::uint32_t tag) { return request(Draft<"command_query">{}, tag); }

Request Commands::question(std::uint32_t i) {
    Draft<"command_query"> draft;
    (void)draft.set<"cmd">(1);
    (void)draft.set<"val">(asked_for(i));
    return request(draft);
}

bool Commands::took(std::uint32_t i, FrameView answer) {
    auto info = command_info_in(answer);
    if (!info) return false;
    info->signs = device().signs();
    info->presence = device().presence();
    descriptions_[asked_for(i)] = std::move(*info);
    return true;
}

void Commands::step_ended(const Ended& ended, TimePoint now) {
    if (ended.tag == ask_info) return;    // Device stores the info; without it nothing is cached
    if (ended.tag == ask_parameter_count) return look_at_a_parameter(now);
    if (ended.tag == ask_parameter) {
        const auto parameter = ended.outcome == Outcome::answered ? parameter_info_in(*ended.answer) : std::nullopt;
        return complete(parameter && parameter->limits ? std::optional{ValueType7::f32} : std::nullopt, now);
    }
    if (ended.outcome != Outcome::answered)
        return finish_silent({"number_of_commands"}, ended.evidence, now, {"probably_has_none"});
    counted(ended, now);
}

void Commands::counted(const Ended& ended, TimePoint now) {
    const std::uint16_t count = as<"command_query">(*ended.answer)->get<"val">();
    if (ended.tag == ask_count) {
        descriptions_.assign(count, {});
        wanted_.clear();
        again_ = 0;
        presence_ = device().presence();
        return gather(count, now);
    }
    if (count != descriptions_.size())
        return finish({Ending::failed, {"changes", hex_of(device().address()), Fault{"commands"}}, {}}, now);
    if (!missing().empty() && again_ < more_rounds) {
        ++again_;
        std::vector<std::uint32_t> wanted;
        for (const std::uint32_t i : missing()) wanted.push_back(asked_for(i));
        wanted_ = std::move(wanted);
        return gather(wanted_.size(), now);
    }
    if (!missing().empty()) return finish({Ending::incomplete, {"command_not_described", asked_for(missing().front())}, {}}, now);
    if (std::none_of(descriptions_.begin(), descriptions_.end(), has_seven)) return complete(std::nullopt, now);
    if (std::any_of(descriptions_.begin(), descriptions_.end(), is_of_newest)) return complete(ValueType7::u64, now);
    if (seven_) return complete(std::nullopt, now);
    if (device().parameter_count()) return look_at_a_parameter(now);
    ask(question::parameter_count(ask_parameter_count), now);
}

void Commands::look_at_a_parameter(TimePoint now) {
    if (device().parameter_count().value_or(0) == 0) return complete(std::nullopt, now);
    ask(question::parameter_info(0, ask_parameter), now);
}

// `shown`: the meaning of value type 7 that the device's descriptions show.
void Commands::complete(std::optional<ValueType7> shown, TimePoint now) {
    const auto mean = [&](ValueType7 seven) {
        for (CommandInfo& info : descriptions_)
            if (has_seven(info)) info = with_type_7(std::move(info), seven);
    };
    if (shown) mean(*shown);
    const auto key = key_of(device(), device().command_count(), now);
    const bool is_same = key && key->presence == presence_ && key->count == descriptions_.size();
    if (cache_ != nullptr && is_same) cache_->store(*key, descriptions_);
    if (seven_) mean(*seven_);
    finish({}, now);
}

CommandCall::CommandCall(Device& device, CommandInfo command, std::vector<AnyValue> values, bool repeat)
    : Task{device}, command_{std::move(command)}, values_{std::move(values)}, repeat_{repeat} {}

Fault CommandCall::order() const {
    if (!command_.name.empty()) return {"command_named", command_.name};
    return {"command_named", hex_of(command_.cid[0]) + ' ' + hex_of(command_.cid[1]) + ' ' + hex_of(command_.cid[2])};
}

Fault CommandCall::pack(std::vector<std::uint8_t>& out) const {
    const std::size_t n = command_.types.size();
    if (values_.size() != n) return {"values_needed", called(), n, values_.size()};
    for (std::size_t i = 0; i < n; ++i) {
        const Misfit misfit = append(out, values_[i], command_.types[i]);
        if (misfit.empty()) continue;
        return {"command_value_unfit", called(), i + 1, to_string(values_[i]), misfit, ano::name_of(command_.types[i])};
    }
    return {};
}

void CommandCall::start(TimePoint now) {
    if (command_.has_unknown_type) return finish({Ending::unsupported, {"command_unknown_type", called()}, {}}, now);
    if (command_.has_open_type) return finish({Ending::invalid, {"command_open_type", called()}, {}}, now);
    std::vector<std::uint8_t> values;
    if (Fault wrong = pack(values); !wrong.empty()) return finish({Ending::invalid, std::move(wrong), {}}, now);
    Draft<"command"> draft;
    (void)draft.set<"cid0">(command_.cid[0]);
    (void)draft.set<"cid1">(command_.cid[1]);
    (void)draft.set<"cid2">(command_.cid[2]);
    (void)draft.set<"values">(Bytes{values});
    ask(request(draft, 0, {.sends = repeat_ ? 5u : 1u, .wait = std::chrono::seconds{2}}), now);
}

void CommandCall::ended(const Ended& ended, TimePoint now) {
    if (ended.evidence.may_be_of_equal)
        return finish({Ending::unknown,
                       {"ambiguous_acknowledgement", hex_of(ended.evidence.by_port.value_or(device().address())), called()},
                       ended.evidence},
                      now);
    if (ended.outcome == Outcome::answered) return finish({Ending::done, port_answer(ended.evidence), ended.evidence}, now);
    if (!ended.evidence.unfit.empty())
        return finish({Ending::unknown,
                       {"probably_carried_out", hex_of(device().address()), called(), spaced_hex(ended.evidence.unfit)},
                       ended.evidence},
                      now);
    if (repeat_) return finish_unacknowledged(order(), ended.evidence, now, {"cannot_do_now"});
    finish({Ending::unknown,
            ended.evidence.is_heard ? Fault{"may_be_executed_or_not", called()} : Fault{"may_be_executed", called()},
            ended.evidence},
           now);
}

void CommandCall::cancel(TimePoint now) { finish({Ending::cancelled, {"may_be_carried_out", called()}, {}}, now); }

}    // namespace ano::host
