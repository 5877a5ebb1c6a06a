#include <ano_json/text.hpp>
#include <devices/command_works.hpp>
#include <devices/device_json.hpp>
#include <devices/rows_text.hpp>
#include <host/commands.hpp>

#include <nlohmann/json.hpp>

#include <charconv>
#include <optional>
#include <utility>
#include <vector>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::TimePoint;
using ano::host::CommandInfo;
using ano::host::Commands;
using ano::host::Task;

Json command_json(const CommandInfo& info) {
    Json values = Json::array();
    for (const ano::Type type : info.types) values.push_back(name_of(type));
    Json json{{"id", info.id}, {"name", info.name}};
    if (!info.info.empty()) json["text"] = info.info;
    json["values"] = std::move(values);
    if (info.has_unknown_type) json["unsupported"] = true;
    return json;
}

class CommandWork : public TaskWork {
public:
    using TaskWork::TaskWork;
    void start(TimePoint now) override {
        auto task = std::make_unique<Commands>(place().device, place().net.manners(place().device.address()).value_type_7);
        commands_ = task.get();
        next(std::move(task)).read(now);
    }

protected:
    const Commands& commands() const { return *commands_; }

private:
    Commands* commands_ = nullptr;
};

class ReadCommands final : public CommandWork {
public:
    using CommandWork::CommandWork;
    std::string message() const override { return "reading commands"; }
    std::optional<TimePoint> due() const override { return text_ ? std::optional{TimePoint{}} : std::nullopt; }

private:
    // Adds a few rows at a time: it is called again until the work has ended.
    void done(const Task& task, TimePoint) override {
        const auto& all = commands().descriptions();
        const auto& device = place().device;
        if (!text_) text_.emplace(Json{{"device", identity_json(device.address(), device.info())}}, "commands");
        for (std::size_t n = 0; n < RowsText::rows_a_turn && told_ < all.size(); ++n) text_->add(command_json(all[told_++]));
        if (text_->size() > RowsText::max_bytes) return finish(too_many_bytes(device.address()));
        if (told_ == all.size()) finish(text_->ended(end_of(*task.end()), Json::object()));
    }

    std::optional<RowsText> text_;
    std::size_t told_ = 0;
};

class CallCommand final : public CommandWork {
public:
    CallCommand(const WorkPlace& place, std::string name, const Json& values, bool repeat)
        : CommandWork{place}, name_{std::move(name)}, json_{values.dump()}, repeat_{repeat} {}
    std::string message() const override { return "calling " + name_; }

private:
    void done(const Task& task, TimePoint now) override {
        if (command_) return tell(*task.end());
        command_ = called();
        if (!command_) return finish(work_fault(404, "no command is called " + ano::in_quotes(name_) + ", or several are"));
        std::vector<ano::host::AnyValue> values;
        std::size_t i = 0;
        for (const Json& json : Json::parse(json_)) {
            const auto type = i < command_->types.size() ? std::optional{command_->types[i]} : std::nullopt;
            const auto value = value_in(json, type);
            if (!value) return finish(work_fault(422, "value " + std::to_string(i + 1) + " must be a number"));
            values.push_back(*value);
            ++i;
        }
        next(std::make_unique<ano::host::CommandCall>(place().device, *command_, std::move(values), repeat_)).start(now);
    }
    std::optional<CommandInfo> called() const {
        if (const CommandInfo* const info = commands().find(name_)) return *info;
        std::size_t id = 0;
        const auto [end, ec] = std::from_chars(name_.data(), name_.data() + name_.size(), id);
        if (ec != std::errc{} || end != name_.data() + name_.size() || id >= commands().descriptions().size())
            return std::nullopt;
        return commands().descriptions()[id];
    }
    void tell(const ano::host::End& ended) {
        WorkEnd end = end_of(ended);
        end.result = Json{{"id", command_->id}, {"name", command_->name}, {"called", true}}.dump(-1, ' ', false,
                                                                                                 Json::error_handler_t::replace);
        finish(std::move(end));
    }

    std::string name_, json_;
    bool repeat_;
    std::optional<CommandInfo> command_;
};

}    // namespace

std::unique_ptr<Work> read_commands(const WorkPlace& place) { return std::make_unique<ReadCommands>(place); }

std::unique_ptr<Work> call_command(const WorkPlace& place, std::string name, const Json& values, bool repeat) {
    return std::make_unique<CallCommand>(place, std::move(name), values, repeat);
}

}    // namespace anogate
