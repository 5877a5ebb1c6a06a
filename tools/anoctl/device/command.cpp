// anoctl command: lists and sends the commands of a device.
#include "command_values.hpp"
#include "device_client.hpp"

#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/gateway_json.hpp>
#include <anoctl/say.hpp>
#include <anoctl/table.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>
#include <vector>

namespace anoctl {
namespace {

using ano::Json;

struct Command {
    DeviceOptions options;
    std::string action;
    std::vector<std::string> words;
    bool repeat = false;

    int run(Streams& streams) const {
        if (action == "list") return list(streams);
        if (action == "call") return call(streams);
        throw UsageError{"command " + ano::in_quotes(action) + " is nothing to do; list and call NAME [VALUE...] are"};
    }

private:
    int list(Streams& streams) const {
        if (!words.empty()) throw UsageError{ano::in_quotes(words[0]) + " is a word too many"};
        DeviceClient client{options, streams};
        const Json answer = client.run("GET", client.target("/commands"));
        Table table{{" ID", "COMMAND", "WHAT"}};
        for (const Json& command : at(answer, "commands")) {
            if (options.json) streams.out << command.dump() << '\n';
            else table.row({text_at(command, "id"), command_usage(command), text_at(command, "text")});
        }
        const bool is_empty = table.empty() && text_at(answer, "incomplete").empty();
        if (!options.json && is_empty) say(streams, client.device_words() + " has no commands");
        else if (!options.json) table.write(streams.out, "", streams.terminal ? streams.width : 0);
        if (const std::string missing = text_at(answer, "incomplete"); !missing.empty()) throw Failure{missing};
        return fine;
    }

    int call(Streams& streams) const {
        if (words.empty()) throw UsageError{"which? anoctl command call NAME [VALUE...]"};
        DeviceClient client{options, streams};
        client.must_be_able_to_ask("command call");
        const Json answer = client.run("GET", client.target("/commands"));
        const Json& command = command_called(at(answer, "commands"), words[0]);
        const std::vector<std::string> given{words.begin() + 1, words.end()};
        const Json values = command_values(command, given);
        std::string said = text_at(command, "name");
        for (const std::string& word : given) said += " " + without_controls(word);
        if (!client.may("Tell " + client.device_words() + ": " + said + "?")) {
            tell(streams, "nothing was sent");
            return failed;
        }
        const Json came = client.run("POST", client.target("/commands/" + text_at(command, "id")),
                                     Json{{"values", values}, {"repeat", repeat}}.dump());
        if (options.json) streams.out << came.dump() << '\n';
        else say(streams, client.device_words() + ": " + said + ": acknowledged");
        return fine;
    }
};

}    // namespace

Run add_command(Options& options) {
    const auto self = std::make_shared<Command>();
    options.push_back({"action", &self->action, "list|call", "list, or call NAME [VALUE...]: asks before it is sent", true});
    options.push_back(
        {"words", &self->words, "[COMMAND [VALUE...]]", "The command by name or number, and a value for each of its types"});
    options.push_back({"--repeat", &self->repeat, "", "Sends it again when no answer comes: it may be carried out twice then"});
    DeviceOptions::add(options, self->options, "command");
    DeviceOptions::add_yes(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
