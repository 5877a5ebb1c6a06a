#include <ano/hex.hpp>
#include <ano_json/compact_json.hpp>
#include <ano_json/text.hpp>
#include <devices/device_json.hpp>
#include <devices/rows_text.hpp>
#include <devices/works/command_works.hpp>
#include <host/commands.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::TimePoint;
using ano::host::CommandCheck;
using ano::host::CommandInfo;
using ano::host::Commands;
using ano::host::Task;

Json command_json(const CommandInfo& info, const DeviceTexts& texts) {
    Json values = Json::array();
    std::size_t at = 0;    // index in `types`, which has no entry for unknown types
    for (const std::uint8_t number : info.numbers) {
        if (!ano::command_value_type(number, ano::ValueType7::f32)) continue;
        const ano::Type type = info.types[at++];
        if (info.has_open_type && number == 7) values.push_back("f32|u64");
        else values.push_back(name_of(type));
    }
    Json json{{"id", info.id}, {"name", texts.display_text(info.name)}};
    if (!info.info.empty()) json["text"] = texts.display_text(info.info);
    json["values"] = std::move(values);
    if (info.has_unknown_type) json["unsupported"] = true;
    return json;
}

class CommandWork : public TaskWork {
public:
    using TaskWork::TaskWork;

protected:
    /// The stated meaning of value type 7; std::nullopt: none, so that the device's descriptions decide.
    std::optional<ano::ValueType7> stated_type_7() {
        const auto of_link = place().net.device_limits(place().device.address()).value_type_7;
        if (of_link) return of_link;
        return given_type_7_ ? given_type_7_ : kept_type_7(place());
    }
    /// Applies the meaning that the client states; it is stored when the command is called. False if the link's key states the
    /// opposite; the work has then ended.
    bool state_type_7(std::optional<ano::ValueType7> seven) {
        const auto of_link = place().net.device_limits(place().device.address()).value_type_7;
        if (!seven || of_link == seven) return true;
        if (of_link) {
            finish(work_fault({"type_7_of_link", to_string(*of_link)}));
            return false;
        }
        given_type_7_ = seven;
        return true;
    }
    /// Whether the descriptions `all` of the device have the stated meaning. False if they show the other one; the work has then
    /// ended.
    bool agrees(const std::vector<CommandInfo>& all) {
        if (!given_type_7_) return true;
        for (const CommandInfo& one : all) {
            const auto display_text = ano::host::reported_type_7(one);
            if (!display_text || display_text == given_type_7_) continue;
            finish(work_fault({"type_7_of_device", to_string(*display_text), to_string(*given_type_7_)}));
            return false;
        }
        return true;
    }
    void read(TimePoint now) {
        const auto of_link = place().net.device_limits(place().device.address()).value_type_7;
        auto task = std::make_unique<Commands>(place().device, of_link, &place().commands);
        commands_ = task.get();
        next(std::move(task)).read(now);
    }
    /// The commands as read before, if the device was not away since.
    std::optional<std::vector<CommandInfo>> known(TimePoint now) {
        const auto* const all = known_commands(place().commands, place().device, now);
        if (all != nullptr && !agrees(*all)) return std::nullopt;
        return all != nullptr ? std::optional{with_stated_types(*all)} : std::nullopt;
    }
    /// The same even if it was away: a command from these must be confirmed unless is_certain().
    std::optional<std::vector<CommandInfo>> read_last() {
        const auto* const all = commands_read_last(place().commands, place().device);
        if (all != nullptr && !agrees(*all)) return std::nullopt;
        return all != nullptr ? std::optional{with_stated_types(*all)} : std::nullopt;
    }
    bool is_certain(const CommandInfo& command, TimePoint now) const {
        return place().device.has_no_sign_since(command.signs, now);
    }
    void confirm(const CommandInfo& command, TimePoint now) {
        auto task = std::make_unique<CommandCheck>(place().device, command, place().commands);
        check_ = task.get();
        next(std::move(task)).start(now);
    }
    void report_unconfirmed() {
        note_ = ano::host::hex_of(place().device.address()) +
                " did not confirm that the command is unchanged: it was sent as described earlier";
    }
    /// The check, if it is the current task; otherwise nullptr.
    const CommandCheck* check() const { return check_ != nullptr && task() == check_ ? check_ : nullptr; }
    bool agrees_as_read() { return agrees(commands_->descriptions()); }
    /// The commands that were read.
    std::vector<CommandInfo> commands() { return with_stated_types(commands_->descriptions()); }

    /// Calls `command`, or finishes because `given` does not fit.
    void call(const CommandInfo& command, const Json& given, bool repeat, TimePoint now) {
        std::vector<ano::host::AnyValue> values;
        for (const Json& json : given) {
            const std::size_t i = values.size();
            const auto value = value_in(json, i < command.types.size() ? std::optional{command.types[i]} : std::nullopt);
            if (!value) return finish(work_fault({"number_needed", i + 1}));
            values.push_back(*value);
        }
        if (given_type_7_) remember_change();
        if (given_type_7_) keep_type_7(place(), *given_type_7_);
        auto task = std::make_unique<ano::host::CommandCall>(place().device, command, std::move(values), repeat);
        if (means_present_device_) task->mean_present_device();
        next(std::move(task)).start(now);
    }
    /// The command is not of the device's list.
    void mean_present_device() noexcept { means_present_device_ = true; }
    void report(const ano::host::End& ended, const Json& result) {
        WorkEnd end = end_of(ended, texts());
        Json whole = result;
        if (!note_.empty()) whole["note"] = note_;
        else if (ended.evidence.by_port) whole["note"] = ended.fault.text();
        end.result = ano::compact_json(whole);
        finish(std::move(end));
    }

private:
    // Only after the device info is known: a statement of a user applies to one device.
    std::vector<CommandInfo> with_stated_types(std::vector<CommandInfo> rows) {
        if (const auto seven = stated_type_7())
            for (CommandInfo& row : rows) row = with_type_7(std::move(row), *seven);
        return rows;
    }

    void remember_change() {
        const auto before = kept_type_7(place());
        if (before && before != given_type_7_)
            note_ = "value type 7 of this device is " + std::string{to_string(*given_type_7_)} +
                    " from now on; it was stored as " + std::string{to_string(*before)};
    }

    Commands* commands_ = nullptr;
    const CommandCheck* check_ = nullptr;
    std::optional<ano::ValueType7> given_type_7_;
    std::string note_;    // of the call, for the user
    bool means_present_device_ = false;
};

class ReadCommands final : public CommandWork {
public:
    ReadCommands(const WorkPlace& place, bool may_be_known) : CommandWork{place}, may_be_known_{may_be_known} {}
    void start(TimePoint now) override {
        if (may_be_known_) rows_ = read_last();    // a call of one of them confirms it if needed
        if (!rows_) read(now);
    }
    std::string message() const override { return "reading commands"; }
    std::optional<TimePoint> due() const override { return rows_ ? std::optional{TimePoint{}} : std::nullopt; }

private:
    void done(const Task& task, TimePoint) override {
        if (rows_) return;
        rows_ = commands();
        end_ = end_of(*task.end(), texts());
    }
    // Adds a few rows per call: called again until the work has ended.
    void look(TimePoint) override {
        if (!rows_ || end()) return;
        const auto& device = place().device;
        if (!text_) {
            Json head{{"device", identity_json(device.address(), device.info(), texts())}};
            if (task() == nullptr) head["known"] = true;
            text_.emplace(head, "commands");
        }
        for (std::size_t n = 0; n < RowsText::rows_a_turn && listed_ < rows_->size(); ++n)
            text_->add(command_json((*rows_)[listed_++], texts()));
        if (text_->size() > RowsText::max_bytes) return finish(too_many_bytes(device.address()));
        if (listed_ == rows_->size()) finish(text_->ended(std::move(end_), Json::object()));
    }

    const bool may_be_known_;
    std::optional<std::vector<CommandInfo>> rows_;
    WorkEnd end_;
    std::optional<RowsText> text_;
    std::size_t listed_ = 0;
};

class CallCommand final : public CommandWork {
public:
    CallCommand(const WorkPlace& place, CommandOrder order, const Json& values)
        : CommandWork{place}, order_{std::move(order)}, json_{values.dump()} {}
    void start(TimePoint now) override {
        if (!state_type_7(order_.seven)) return;
        if (const auto all = read_last()) command_ = called(*all);
        if (end()) return;
        if (command_ && command_->has_open_type) command_.reset();    // its meaning may be known meanwhile
        if (!command_) return read(now);
        if (!is_certain(*command_, now)) return confirm(*command_, now);
        call_it(now);
    }
    std::string message() const override { return "calling " + order_.command; }

private:
    void done(const Task& task, TimePoint now) override {
        if (check() != nullptr) {
            const CommandCheck::Found found = check()->found();
            if (found == CommandCheck::Found::interrupted && ++interrupted_ < max_interrupted) return confirm(*command_, now);
            const bool is_unconfirmed = found == CommandCheck::Found::unconfirmed || found == CommandCheck::Found::interrupted;
            if (is_unconfirmed) report_unconfirmed();
            if (found == CommandCheck::Found::same || is_unconfirmed) return call_it(now);
            command_.reset();
            return read(now);
        }
        if (command_)
            return report(*task.end(), {{"id", command_->id}, {"name", texts().display_text(command_->name)}, {"called", true}});
        if (!agrees_as_read()) return;
        command_ = called(commands());
        if (!command_ && order_.called) return finish_outdated();
        if (!command_) return finish(work_fault({"no_single_command", ano::in_quotes(order_.command)}));
        call_it(now);
    }
    // Nothing was sent: the client may read the commands and call again.
    void finish_outdated() {
        WorkEnd end = work_fault({"commands_changed", order_.command, ano::in_quotes(*order_.called)});
        end.what = "commands_changed";
        finish(std::move(end));
    }
    void call_it(TimePoint now) {
        if (order_.called && !texts().is(command_->name, *order_.called)) return finish_outdated();
        call(*command_, Json::parse(json_), order_.repeat, now);
    }
    std::optional<CommandInfo> called(const std::vector<CommandInfo>& all) const {
        const std::string& word = order_.command;
        const CommandInfo* found = nullptr;
        std::size_t count = 0;
        for (const CommandInfo& one : all) {
            if (word.empty() || one.name.empty() || !texts().is(one.name, word)) continue;
            found = &one;
            ++count;
        }
        if (count == 1) return *found;
        std::size_t id = 0;
        const auto [end, ec] = std::from_chars(word.data(), word.data() + word.size(), id);
        if (ec != std::errc{} || end != word.data() + word.size() || id >= all.size()) return std::nullopt;
        return all[id];
    }

    CommandOrder order_;
    std::string json_;
    std::optional<CommandInfo> command_;
    static constexpr unsigned max_interrupted = 4;    // checks over a link that was down: after these, the device counts as not
                                                      // answering
    unsigned interrupted_ = 0;
};

std::optional<ano::Type> number_type_called(std::string_view name) {
    const auto* const found = std::find(ano::type_names.begin(), ano::type_names.end(), name);
    if (found == ano::type_names.end()) return std::nullopt;
    const auto type = static_cast<ano::Type>(found - ano::type_names.begin());
    return ano::is_number(type) ? std::optional{type} : std::nullopt;
}

// The device is asked nothing: the client's statements about the command are used unchanged.
class CallByCid final : public CommandWork {
public:
    CallByCid(const WorkPlace& place, const Cid& cid, CommandOrder order, const Json& values)
        : CommandWork{place}, json_{values.dump()}, order_{std::move(order)} {
        command_.cid = cid;
        for (const std::uint8_t byte : cid) bytes_ += ' ' + ano::hex_byte(byte);
    }
    void start(TimePoint now) override {
        if (!state_type_7(order_.seven)) return;
        const auto all = known(now).value_or(std::vector<CommandInfo>{});
        if (end()) return;
        const auto known_as = std::find_if(all.begin(), all.end(),
                                           [&](const CommandInfo& one) { return one.cid == command_.cid; });
        Json values = Json::array();
        for (const Json& given : Json::parse(json_)) {
            if (!given.is_object()) {
                values.push_back(given);
                continue;
            }
            const auto type = given.size() == 1 ? number_type_called(given.begin().key()) : std::nullopt;
            if (!type)
                return finish(work_fault({"typed_value_needed", values.size() + 1, R"({TYPE: number}, as in {"u16": 150})"}));
            command_.types.push_back(*type);
            values.push_back(given.front());
        }
        if (!values.empty() && command_.types.empty() && known_as != all.end()) command_ = *known_as;
        else if (command_.types.size() != values.size()) return finish(work_fault({"types_needed", R"({"u16": 150})"}));
        mean_present_device();
        call(command_, values, order_.repeat, now);
    }
    std::string message() const override { return "calling " + (command_.name.empty() ? "command" + bytes_ : command_.name); }

private:
    void done(const Task& task, TimePoint) override { report(*task.end(), {{"cid", command_.cid}, {"called", true}}); }

    std::string json_, bytes_;
    CommandOrder order_;
    CommandInfo command_;
};

}    // namespace

std::unique_ptr<Work> read_commands(const WorkPlace& place, bool known) { return std::make_unique<ReadCommands>(place, known); }

std::unique_ptr<Work> call_command(const WorkPlace& place, CommandOrder order, const Json& values) {
    return std::make_unique<CallCommand>(place, std::move(order), values);
}

std::unique_ptr<Work> call_by_cid(const WorkPlace& place, const Cid& cid, CommandOrder order, const Json& values) {
    return std::make_unique<CallByCid>(place, cid, std::move(order), values);
}

}    // namespace anogate
