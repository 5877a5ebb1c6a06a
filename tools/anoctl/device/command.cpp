// anoctl command: lists and sends the commands of a device.
#include "command_values.hpp"
#include "device_client.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>

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
    std::string cid, type7;
    bool repeat = false;

    int run(Streams& streams) const {
        if (action == "list") return list(streams);
        if (action == "call") return call(streams);
        throw UsageError{"unknown action " + ano::in_quotes(action) +
                         "; actions: list, call NAME [VALUE...], call --cid CID [TYPE:VALUE...]"};
    }

private:
    int list(Streams& streams) const {
        if (!words.empty()) throw UsageError{"unexpected argument " + ano::in_quotes(words[0])};
        if (!cid.empty()) throw UsageError{"--cid requires command call"};
        DeviceClient client{options, streams};
        const Json answer = client.run("GET", client.target("/commands"));
        Table table{{" ID", "COMMAND", "WHAT"}};
        for (const Json& command : at(answer, "commands")) {
            if (options.json) streams.out << ano::json_text(command) << '\n';
            else table.row({text_at(command, "id"), command_usage(command), text_at(command, "text")});
        }
        const bool is_empty = table.empty() && text_at(answer, "incomplete").empty();
        if (!options.json && is_empty) print(streams, client.device_words() + " has no commands");
        else if (!options.json) table.write(streams.out, "", streams.terminal ? streams.width : 0);
        if (const std::string missing = text_at(answer, "incomplete"); !missing.empty()) throw Failure{missing};
        return fine;
    }

    /// The description as read before, so that the call is the first frame that is sent; otherwise as the device describes it
    /// now.
    static Json described(DeviceClient& client, const std::string& word) {
        const Json known = client.run("GET", client.target("/commands?known"));
        try {
            return command_called(at(known, "commands"), word);
        } catch (const UsageError&) {
            if (!known.contains("known")) throw;
        }
        const Json now = client.run("GET", client.target("/commands"));
        return command_called(at(now, "commands"), word);
    }

    int call(Streams& streams) const {
        if (!cid.empty()) return call_the_cid(streams);
        if (words.empty()) throw UsageError{"missing NAME: anoctl command call NAME [VALUE...]"};
        DeviceClient client{options, streams};
        client.will_act();
        client.must_be_able_to_ask("command call");
        Json command = described(client, words[0]);
        const std::vector<std::string> given{words.begin() + 1, words.end()};
        Json body = body_of(command, given);
        const std::string name = text_at(command, "name"), text = with_values(name, given);
        if (!is_wanted(client, text, streams)) return failed;
        Json came;
        try {
            came = client.run("POST", client.target("/commands/" + text_at(command, "id")), body.dump());
        } catch (const Outdated&) {    // only once: for example, the board was swapped
            if (name.empty()) throw;
            print_note(streams, client.device_words() + " has different commands than before; reading them again");
            const Json now = client.run("GET", client.target("/commands"));
            command = command_called(at(now, "commands"), name);    // to which the user agreed, even if its number changed
            body = body_of(command, given);
            body["name"] = name;
            came = client.run("POST", client.target("/commands/" + text_at(command, "id")), body.dump());
        }
        report(client, text, came, streams);
        return fine;
    }

    Json body_of(const Json& command, const std::vector<std::string>& given) const {
        Json body{
            {"values", command_values(command, given, !type7.empty())}, {"repeat", repeat}, {"name", text_at(command, "name")}};
        if (!type7.empty()) body["type7"] = type7;
        return body;
    }

    int call_the_cid(Streams& streams) const {
        Json body = call_by_cid(cid, words);
        body["repeat"] = repeat;
        DeviceOptions at_once = options;
        at_once.asks_nothing_first = true;
        DeviceClient client{at_once, streams};
        client.will_act();
        client.must_be_able_to_ask("command call");
        if (!type7.empty()) body["type7"] = type7;
        const std::string text = with_values("command " + without_controls(cid), words);
        if (!is_wanted(client, text, streams)) return failed;
        report(client, text, client.run("POST", client.target("/commands/by-cid"), body.dump()), streams);
        return fine;
    }

    static std::string with_values(std::string text, const std::vector<std::string>& values) {
        for (const std::string& word : values) text += " " + without_controls(word);
        return text;
    }
    static bool is_wanted(DeviceClient& client, const std::string& text, Streams& streams) {
        if (client.may("Send " + text + " to " + client.device_words() + "?")) return true;
        print_note(streams, "nothing was sent");
        return false;
    }
    void report(DeviceClient& client, const std::string& text, const Json& came, Streams& streams) const {
        if (options.json) streams.out << ano::json_text(came) << '\n';
        else print(streams, client.device_words() + ": " + text + ": acknowledged");
        if (const std::string note = text_at(came, "note"); !note.empty()) print_note(streams, note);
    }
};

}    // namespace

Run add_command(Options& options) {
    const auto self = std::make_shared<Command>();
    options.push_back({"action", &self->action, "list|call",
                       "list: list the commands; call NAME [VALUE...]: send a command, after confirmation", true});
    options.push_back({"words", &self->words, "[COMMAND [VALUE...]]", "Command, by name or number, and one value per argument"});
    options.push_back({"--cid", &self->cid, "CID",
                       "Select the command by its three CID bytes, such as 16,0,5, with values such as u16:150, instead of by "
                       "name (call); sends nothing else to the device first"});
    options.push_back({"--repeat", &self->repeat, "", "Retry until acknowledged; the command may be executed twice"});
    options.push_back({"--type7",
                       [self](const std::string& word) {
                           self->type7 = word;
                           return word == "f32" || word == "u64" ? std::string{}
                                                                 : ano::in_quotes(word) + " is neither f32 nor u64";
                       },
                       "f32|u64",
                       "Meaning of value type 7 for a device whose descriptions do not show it (call; f32 on older devices); the "
                       "gateway remembers it"});
    DeviceOptions::add(options, self->options, "command");
    DeviceOptions::add_yes(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
