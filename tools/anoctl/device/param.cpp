// anoctl param: the parameters of a device.
#include "device_client.hpp"
#include "file_text.hpp"
#include "parameter_file.hpp"

#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/gateway_json.hpp>
#include <anoctl/table.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anoctl {
namespace {

using ano::Json;

constexpr std::string_view actions[]{"list", "get", "set", "save", "reset", "export", "import", "diff"};

std::string plural(std::size_t number, const std::string& word) {
    return std::to_string(number) + " " + word + (number == 1 ? "" : "s");
}

struct Param {
    DeviceOptions options;
    std::string action;
    std::vector<std::string> words;
    bool all = false, with_calibration = false, rollback = false, longer = false, force = false;

    int run(Streams& streams) const {
        if (action == "list" || (action == "get" && all)) return no_words(), list(streams);
        if (action == "get") return get(streams);
        if (action == "set") return set(streams);
        if (action == "save") return no_words(), save(streams);
        if (action == "reset") return no_words(), reset(streams);
        if (action == "export") return export_to(streams);
        if (action == "import") return import_from(streams);
        if (action == "diff") return diff(streams);
        throw UsageError{"param " + ano::in_quotes(action) + " is nothing to do" + ano::did_you_mean(action, actions) +
                         "; list, get, set, save, reset, export, import and diff are"};
    }

private:
    void no_words() const {
        if (!words.empty()) throw UsageError{ano::in_quotes(words[0]) + " is a word too many"};
    }
    const std::string& file() const {
        if (words.empty()) throw UsageError{"the FILE is missing: anoctl param " + action + " FILE"};
        if (words.size() > 1) throw UsageError{ano::in_quotes(words[1]) + " is a word too many"};
        return words[0];
    }

    int list(Streams& streams) const {
        DeviceClient client{options, streams};
        const Json answer = client.run("GET", client.target("/parameters"));
        if (options.json) {
            for (const Json& row : at(answer, "parameters")) streams.out << row.dump() << '\n';
        } else if (action == "get") {
            for (const Json& row : at(answer, "parameters")) write_assigned(row, streams.out);
        } else {
            Table table{{" ID", "NAME", "TYPE", "VALUE", "MIN", "MAX", "WHAT"}};
            for (const Json& row : at(answer, "parameters"))
                table.row({text_at(row, "id"), text_at(row, "name"), text_at(row, "type"),
                           row.contains("value") ? without_controls(value_text(row["value"])) : "did not come",
                           text_at(row, "min"), text_at(row, "max"), text_at(row, "text")});
            table.write(streams.out);
        }
        if (const std::string missing = text_at(answer, "incomplete"); !missing.empty()) throw Failure{missing};
        return fine;
    }

    // NAME=VALUE, as `set` takes it.
    static void write_assigned(const Json& row, std::ostream& out) {
        out << text_at(row, "name") << '=' << plain_at(row, "value") << '\n';
    }

    int get(Streams& streams) const {
        if (words.empty()) throw UsageError{"which? anoctl param get NAME..., or --all"};
        DeviceClient client{options, streams};
        for (const std::string& name : words) {
            const Json row = client.run("GET", client.target("/parameters/" + percent_encoded(name)));
            if (options.json) streams.out << row.dump() << '\n';
            else write_assigned(row, streams.out);
        }
        return fine;
    }

    // NAME VALUE, or NAME=VALUE...
    std::vector<std::pair<std::string, std::string>> assignments() const {
        if (words.size() == 2 && words[0].find('=') == std::string::npos) return {{words[0], words[1]}};
        std::vector<std::pair<std::string, std::string>> found;
        for (const std::string& word : words) {
            const std::size_t equals = word.find('=');
            if (equals == std::string::npos || equals == 0)
                throw UsageError{ano::in_quotes(word) + " is no NAME=VALUE; one parameter is NAME VALUE as well"};
            found.emplace_back(word.substr(0, equals), word.substr(equals + 1));
        }
        if (found.empty()) throw UsageError{"what? anoctl param set NAME VALUE, or NAME=VALUE..."};
        return found;
    }

    Json wanted_value(const std::string& value) const {
        Json body{{"value", value}};
        if (longer) body["longer"] = true;
        return body;
    }

    int set(Streams& streams) const {
        const auto wanted = assignments();
        DeviceClient client{options, streams};
        for (const auto& [name, value] : wanted) {
            const Json came = client.run("PUT", client.target("/parameters/" + percent_encoded(name)),
                                         wanted_value(value).dump());
            if (options.json) {
                streams.out << came.dump() << '\n';
                continue;
            }
            streams.out << text_at(came, "name") << '=' << plain_at(came, "stored");
            if (text_at(came, "clamped") == "true") streams.out << " (the device clamps " << plain_at(came, "written") << ')';
            streams.out << '\n';
        }
        return fine;
    }

    int act(DeviceClient& client, const char* what, const std::string& words_of_success, Streams& streams) const {
        const Json came = client.run("POST", client.target(force ? "/actions?force" : "/actions"), Json{{"action", what}}.dump());
        if (options.json) streams.out << came.dump() << '\n';
        else streams.out << client.device_words() << ": " << words_of_success << '\n';
        return fine;
    }
    int save(Streams& streams) const {
        DeviceClient client{options, streams};
        return act(client, "save", "saved", streams);
    }
    int reset(Streams& streams) const {
        DeviceClient client{options, streams};
        client.must_be_able_to_ask("param reset");
        if (!client.may("All parameters of " + client.device_words() + " become what its maker meant. Go on?"))
            return declined(streams);
        return act(client, "restore_defaults", "has the parameters that its maker meant", streams);
    }
    static int declined(Streams& streams) {
        streams.err << "anoctl: nothing was changed\n";
        return failed;
    }

    int export_to(Streams& streams) const {
        const std::string path = words.empty() ? "-" : file();
        DeviceClient client{options, streams};
        const Json made = parameter_file(client.run("GET", client.target("/parameters")));
        const std::string text = made.dump(2) + "\n";
        if (path == "-") {
            streams.out << text;
            return fine;
        }
        write_file(path, text);
        if (options.json) streams.out << Json{{"file", path}, {"parameters", made["parameters"].size()}}.dump() << '\n';
        else
            streams.out << plural(made["parameters"].size(), "parameter") << " of " << client.device_words() << " in " << path
                        << '\n';
        return fine;
    }

    /// What a file would change; nothing is changed.
    struct Difference {
        Json values, answer;
        std::size_t left_out = 0, changes = 0;
    };
    Difference difference(DeviceClient& client, const Json& given) const {
        Difference d;
        d.values = wanted_values(given, with_calibration, d.left_out);
        d.answer = client.run("POST", client.target("/apply"), Json{{"parameters", d.values}, {"dry_run", true}}.dump());
        d.changes = at(d.answer, "parameters").size() - rows_with(d.answer, "unchanged");
        return d;
    }
    void show(const Difference& d, std::ostream& out) const {
        for (const std::string& line : difference_lines(d.answer)) out << line << '\n';
        if (d.changes == 0) out << "nothing differs\n";
        if (d.left_out > 0) out << plural(d.left_out, "calibration parameter") << " left out, see --with-calibration\n";
    }

    int diff(Streams& streams) const {
        const Json given = parsed_parameter_file(text_of_file(file()), file());
        DeviceClient client{options, streams};
        const Difference d = difference(client, given);
        if (options.json) {
            for (const Json& row : at(d.answer, "parameters")) streams.out << row.dump() << '\n';
            return fine;
        }
        if (const std::string other = of_another_device(given, client.known_device()); !other.empty())
            streams.err << "anoctl: " << other << '\n';
        show(d, streams.out);
        return fine;
    }

    int import_from(Streams& streams) const {
        const Json given = parsed_parameter_file(text_of_file(file()), file());
        DeviceClient client{options, streams};
        client.must_be_able_to_ask("param import");
        const Difference d = difference(client, given);
        if (!options.json) show(d, streams.out);
        if (d.changes > 0) {
            const std::string other = of_another_device(given, client.known_device());
            if (!other.empty() && options.yes) streams.err << "anoctl: " << other << '\n';
            if (!other.empty() && !client.may(other + ". Go on all the same?")) return declined(streams);
            if (!client.may("Write " + plural(d.changes, "parameter") + " into " + client.device_words() + "?"))
                return declined(streams);
        }
        return apply(client, d, streams);
    }

    int apply(DeviceClient& client, const Difference& d, Streams& streams) const {
        Json order{{"parameters", d.values}};
        if (rollback) order["rollback"] = true;
        if (longer) order["longer"] = true;
        Json came = d.answer;
        std::string why;
        try {
            if (d.changes > 0) came = client.run("POST", client.target("/apply"), order.dump());
        } catch (const JobFailure& e) {    // what became of each is told before
            came = parse_answer(e.result);
            why = e.what();
        }
        const std::size_t wrong = rows_with(came, "failed") + rows_with(came, "undone") + rows_with(came, "not_undone");
        if (options.json) {
            for (const Json& row : at(came, "parameters")) streams.out << row.dump() << '\n';
        } else if (d.changes > 0) {
            for (const Json& row : at(came, "parameters"))
                if (const std::string state = text_at(row, "state"); state != "unchanged" && state != "written")
                    for (const std::string& line : difference_lines(Json{{"parameters", Json::array({row})}}))
                        streams.out << line << '\n';
            streams.out << plural(rows_with(came, "written") + rows_with(came, "clamped"), "parameter")
                        << " written; anoctl param save keeps them over a restart\n";
        }
        if (!why.empty()) throw Failure{why};
        return wrong == 0 ? fine : failed;
    }
};

}    // namespace

Run add_param(Options& options) {
    const auto self = std::make_shared<Param>();
    options.push_back(
        {"action", &self->action, "list|get|set|save|reset|export|import|diff",
         "list, get NAME... or --all, set NAME VALUE or NAME=VALUE..., save (keeps them over a restart), reset (to what the "
         "maker meant), export [FILE], import FILE (shows what changes, and asks), diff FILE",
         true});
    options.push_back({"words", &self->words, "[PARAMETER|FILE...]", "What for"});
    options.push_back({"--all", &self->all, "", "get: every one"});
    options.push_back({"--with-calibration", &self->with_calibration, "",
                       "import, diff: CAL_... as well, which belongs to one piece of "
                       "hardware"});
    options.push_back({"--longer", &self->longer, "", "set, import: a text may be longer than the one that it replaces"});
    options.push_back({"--force", &self->force, "", "reset: although the device says that it flies"});
    options.push_back({"--rollback", &self->rollback, "", "import: all or nothing"});
    DeviceOptions::add(options, self->options);
    DeviceOptions::add_yes(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
