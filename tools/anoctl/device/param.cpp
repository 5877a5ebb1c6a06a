// anoctl param: the parameters of a device.
#include "device_client.hpp"
#include "file_text.hpp"
#include "kept_values.hpp"
#include "parameter_assignments.hpp"
#include "parameter_file.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/json_line.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <filesystem>
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
        throw UsageError{"unknown action " + ano::in_quotes(action) + ano::did_you_mean(action, actions) +
                         "; actions: list, get, set, save, reset, export, import, diff"};
    }

private:
    void no_words() const {
        if (!words.empty()) throw UsageError{"unexpected argument " + ano::in_quotes(words[0])};
    }
    const std::string& file() const {
        if (words.empty()) throw UsageError{"missing FILE: anoctl param " + action + " FILE"};
        if (words.size() > 1) throw UsageError{"unexpected argument " + ano::in_quotes(words[1])};
        return words[0];
    }

    int list(Streams& streams) const {
        DeviceClient client{options, streams};
        const Json answer = client.run("GET", client.target("/parameters"));
        if (options.json) {
            for (const Json& row : at(answer, "parameters")) streams.out << ano::json_text(row) << '\n';
        } else if (action == "get") {
            for (const Json& row : at(answer, "parameters"))
                if (!row.contains("unreadable")) write_assigned(row, streams.out);
            if (const std::string names = names_not_readable(at(answer, "parameters")); !names.empty())
                throw Failure{"not readable: " + names};
        } else {
            Table table{{" ID", "NAME", "TYPE", "VALUE", "MIN", "MAX", "WHAT"}};
            for (const Json& row : at(answer, "parameters"))
                table.row({text_at(row, "id"), text_at(row, "name"), text_at(row, "type"),
                           row.contains("value")        ? without_controls(value_text(row["value"]))
                           : row.contains("unreadable") ? "not readable: " + text_at(row, "unreadable")
                                                        : "not received",
                           text_at(row, "min"), text_at(row, "max"), text_at(row, "text")});
            if (table.empty()) print(streams, client.device_words() + " has no parameters");
            else table.write(streams.out, "", streams.terminal ? streams.width : 0);
        }
        if (const std::string missing = text_at(answer, "incomplete"); !missing.empty()) throw Failure{missing};
        return fine;
    }

    // Writes NAME=VALUE, in the form that `set` accepts.
    static void write_assigned(const Json& row, std::ostream& out) {
        out << text_at(row, "name") << '=' << plain_at(row, "value") << '\n';
    }

    /// "name=A&name=B".
    static std::string names_query(const std::vector<std::string>& names) {
        std::string query;
        for (const std::string& name : names) query += (query.empty() ? "name=" : "&name=") + percent_encoded(name);
        return query;
    }

    int get(Streams& streams) const {
        if (words.empty()) throw UsageError{"missing NAME: anoctl param get NAME..., or --all"};
        DeviceClient client{options, streams};
        const Json answer = client.run("GET", client.target("/parameters?" + names_query(words)));
        const Json& rows = at(answer, "parameters");
        try {
            for (const std::string& name : words) (void)parameter_called(rows, name);
        } catch (const Failure&) {    // all names are needed to suggest the most similar one
            const Json described = descriptions(client);
            for (const std::string& name : words) (void)parameter_called(described, name);
            throw;
        }
        for (const std::string& name : words) {
            const Json& row = parameter_called(rows, name);
            if (row.contains("unreadable")) throw Failure{"not readable: " + names_not_readable(Json::array({row}))};
            if (!row.contains("value")) continue;
            if (options.json) streams.out << ano::json_text(row) << '\n';
            else write_assigned(row, streams.out);
        }
        if (const std::string missing = text_at(answer, "incomplete"); !missing.empty()) throw Failure{missing};
        return fine;
    }

    static std::vector<std::string> names_of(const std::vector<Assignment>& wanted) {
        std::vector<std::string> names(wanted.size());
        std::transform(wanted.begin(), wanted.end(), names.begin(), [](const Assignment& one) { return one.name; });
        return names;
    }
    /// The parameters without values.
    static Json descriptions(DeviceClient& client) {
        return at(client.run("GET", client.target("/parameters?values=0")), "parameters");
    }

    Json wanted_value(const std::string& value) const {
        Json body{{"value", value}};
        if (longer) body["longer"] = true;
        if (force) body["force"] = true;
        return body;
    }

    // Writes nothing until all values are checked.
    int set(Streams& streams) const {
        const std::vector<Assignment> wanted = assignments(words);
        DeviceClient client{options, streams};
        client.will_act();
        const Json described = checked_descriptions(client, wanted);
        if (described.empty()) {    // protocol V7 has no list: their values show whether the device has them
            check_by_values(client, wanted);
            for (const Assignment& one : wanted) set_one(client, one, streams);
            return fine;
        }
        if (wanted.size() > 1) return set_all(client, wanted, described, streams);
        set_one(client, wanted[0], streams);
        return fine;
    }
    static void check_by_values(DeviceClient& client, const std::vector<Assignment>& wanted) {
        const Json answer = client.run("GET", client.target("/parameters?" + names_query(names_of(wanted))));
        if (const std::string missing = text_at(answer, "incomplete"); !missing.empty()) throw Failure{missing};
        check(wanted, at(answer, "parameters"));
    }
    void set_one(DeviceClient& client, const Assignment& one, Streams& streams) const {
        show_set(client.run("PUT", client.target("/parameters/" + percent_encoded(one.name)), wanted_value(one.value).dump()),
                 streams);
    }
    static bool are_numbers(const std::vector<Assignment>& wanted) {
        return std::all_of(wanted.begin(), wanted.end(), [](const Assignment& one) {
            return !one.name.empty() && one.name.find_first_not_of("0123456789") == std::string::npos;
        });
    }
    /// The descriptions of the wanted ones as read before, also by an earlier run, if the values fit them; otherwise all, as the
    /// device describes them now: an unknown name is compared with all names.
    static Json checked_descriptions(DeviceClient& client, const std::vector<Assignment>& wanted) {
        const std::string these = are_numbers(wanted) ? "" : "&" + names_query(names_of(wanted));
        const Json known = client.run("GET", client.target("/parameters?values=0&known" + these));
        try {
            check(wanted, at(known, "parameters"));
            return at(known, "parameters");
        } catch (const Failure&) {}
        Json now = descriptions(client);
        if (!now.empty() || !are_numbers(wanted)) check(wanted, now);
        return now;
    }
    /// The key for /apply: its name, with its number if another parameter has that name or it has none.
    static std::string name_for_apply(const Json& row, const Json& described) {
        const std::string name = text_at(row, "name");
        const auto called_so = std::count_if(described.begin(), described.end(),
                                             [&](const Json& other) { return text_at(other, "name") == name; });
        return name.empty() || called_so > 1 ? name + "#" + text_at(row, "id") : name;
    }
    // One request for all: their old values are read together, and written values are read once more at the end.
    int set_all(DeviceClient& client, const std::vector<Assignment>& wanted, const Json& described, Streams& streams) const {
        Json order{{"parameters", Json::object()}, {"goes_on", false}, {"also_the_same", true}};
        if (longer) order["longer"] = true;
        if (force) order["force"] = true;
        for (const auto& [word, value] : wanted)
            order["parameters"][name_for_apply(parameter_called(described, word), described)] = value;
        Json came;
        std::string why, rest;
        try {
            came = client.run("POST", client.target("/apply"), order.dump());
        } catch (const JobFailure& e) {    // first prints the written values
            came = parse_answer(e.result);
            why = e.what();
        }
        auto next = wanted.begin();    // the rows are in the same order
        for (const Json& row : at(came, "parameters")) {
            if (next == wanted.end()) break;
            const std::string& word = (next++)->name;
            const std::string state = text_at(row, "state"), name = text_at(row, "name");
            if (state == "waiting") rest += (rest.empty() ? "" : ", ") + (name.empty() ? word : name);
            if (state != "written" && state != "clamped") continue;
            const Json& of = parameter_called(described, word);
            Json shown{{"id", of.value("id", Json{})}, {"name", name}, {"type", of.value("type", Json{})}};
            for (const char* key : {"was", "written", "stored", "clamped"})
                if (row.contains(key)) shown[key] = row[key];
            shown["acknowledged"] = !row.contains("acknowledged");
            show_set(shown, streams);
        }
        if (const std::string note = text_at(came, "note"); !note.empty()) print_note(streams, note);
        if (!why.empty()) throw Failure{why + (rest.empty() ? rest : "; not written: " + rest)};
        return fine;
    }
    void show_set(const Json& came, Streams& streams) const {
        if (options.json) {
            streams.out << ano::json_text(came) << '\n';
            return;
        }
        streams.out << text_at(came, "name") << '=' << plain_at(came, "stored");
        if (text_at(came, "clamped") == "true")
            streams.out << " (device limited the requested " << plain_at(came, "written") << ')';
        if (text_at(came, "acknowledged") == "false")
            streams.out << " (not acknowledged by the device; verified by reading it back)";
        streams.out << '\n' << std::flush;
        if (const std::string note = text_at(came, "note"); !note.empty()) print_note(streams, note);
    }

    int act(DeviceClient& client, const char* what, const std::string& success_text, Streams& streams) const {
        const Json came = client.run("POST", client.target(force ? "/actions?force" : "/actions"), Json{{"action", what}}.dump());
        if (options.json) streams.out << ano::json_text(came) << '\n';
        else print(streams, client.device_words() + ": " + success_text);
        if (const std::string note = text_at(came, "note"); !note.empty()) print_note(streams, note);
        return fine;
    }
    int save(Streams& streams) const {
        DeviceClient client{options, streams};
        client.will_act();
        return act(client, "save", "saved", streams);
    }
    int reset(Streams& streams) const {
        DeviceClient client{options, streams};
        client.will_act();
        client.must_be_able_to_ask("param reset");
        if (!client.may("All parameters of " + client.device_words() +
                        " are reset to factory defaults, including its calibration (CAL_...). To back them up first, use anoctl "
                        "param export. Continue?"))
            return declined(streams);
        return act(client, "restore_defaults", "reset to factory defaults", streams);
    }
    static int declined(Streams& streams) {
        print_note(streams, "nothing was changed");
        return failed;
    }

    int export_to(Streams& streams) const {
        const std::string path = words.empty() ? "-" : file();
        must_be_json(path);
        DeviceClient client{options, streams};
        if (!client.may_write(path)) {
            print_note(streams, "nothing was read");
            return failed;
        }
        const Json answer = client.run("GET", client.target("/parameters"));
        const Json made = parameter_file(answer);
        const std::string not_readable = names_not_readable(at(answer, "parameters"));
        if (!not_readable.empty()) print_note(streams, "not readable, omitted: " + not_readable);
        const int exit = not_readable.empty() ? fine : failed;
        if (const std::string names = names_without_value(made); !names.empty())
            print_note(streams, "inf and nan are stored as null, which import skips: " + names);
        const std::string text = ano::with_json_escapes(made.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
        if (path == "-") {
            streams.out << text;
            return exit;
        }
        write_file(path, text);
        const std::size_t number = made["parameters"].size();
        if (options.json) streams.out << ano::json_line(Json{{"file", path}, {"parameters", number}});
        else print(streams, plural(number, "parameter") + " of " + client.device_words() + " in " + path);
        return exit;
    }
    // A path with .params or .csv asks for a format that is not supported.
    static void must_be_json(const std::string& path) {
        const std::string extension = std::filesystem::path{path}.extension().string();
        const bool is_word = extension.size() > 1 && std::all_of(extension.begin() + 1, extension.end(),
                                                                 [](unsigned char c) { return std::isalpha(c) != 0; });
        if (is_word && extension != ".json")
            throw UsageError{path + ": " + ano::in_quotes(extension) + " is not a supported parameter file format; use .json"};
    }

    /// The changes that a file would make.
    struct Difference {
        Json values, answer;
        std::size_t left_out = 0, changes = 0;
        std::string without_value;
    };
    // Files of stored calibration values contain only calibration parameters.
    Difference difference(DeviceClient& client, const Json& given, bool compares, Streams& streams) const {
        Difference d;
        d.values = wanted_values(given, with_calibration || is_kept_by_calibration(words[0]), d.left_out);
        d.without_value = names_without_value(given);
        const Json order{
            {"parameters", d.values}, {"dry_run", true}, {"longer", compares || longer}, {"force", compares || force}};
        try {
            d.answer = client.run("POST", client.target("/apply"), order.dump());
        } catch (const JobFailure& e) {
            const Json answer = parse_answer(e.result);
            if (rows_with(answer, "failed") == 0) throw;
            throw Failure{show_misfits(client, given, answer, streams)};
        }
        if (!compares && std::any_of(at(d.answer, "parameters").begin(), at(d.answer, "parameters").end(), is_misfit))
            throw Failure{show_misfits(client, given, d.answer, streams)};
        d.changes = at(d.answer, "parameters").size() - rows_with(d.answer, "unchanged");
        return d;
    }
    /// Prints all parameters that do not fit this device; returns the error for them.
    std::string show_misfits(DeviceClient& client, const Json& given, const Json& answer, Streams& streams) const {
        if (const std::string other = of_another_device(given, client.known_device()); !other.empty()) print_note(streams, other);
        std::size_t wrong = 0;
        bool some_longer = false;
        for (const Json& row : at(answer, "parameters")) {
            if (!is_misfit(row)) continue;
            ++wrong;
            some_longer = some_longer || misfit_line(row).find("--longer") != std::string::npos;
            if (options.json) streams.out << ano::json_text(row) << '\n';
            else if (all || wrong <= max_misfits) print(streams, misfit_line(row));
        }
        if (!options.json && !all && wrong > max_misfits)
            print(streams, "and " + std::to_string(wrong - max_misfits) + " more that do not fit; to list them, add --all");
        return plural(wrong, "parameter") + " of " + words[0] + (wrong == 1 ? " does" : " do") + " not fit " +
               client.device_words() + ": nothing was written. To write the others, remove " + (wrong == 1 ? "it" : "them") +
               " from the file" + (some_longer ? ", or allow longer texts with --longer" : "");
    }
    static constexpr std::size_t max_misfits = 8;    // lines: with more, the file is probably of another device
    static bool is_misfit(const Json& row) { return text_at(row, "state") == "failed" || text_at(row, "encodable") == "false"; }
    static void show(const Difference& d, Streams& streams) {
        for (const std::string& line : difference_lines(d.answer)) print(streams, line);
        if (d.changes == 0) print(streams, "no differences");
        if (d.left_out > 0) print(streams, plural(d.left_out, "calibration parameter") + " omitted (see --with-calibration)");
        if (!d.without_value.empty()) print(streams, "no value in the file: " + d.without_value);
    }

    // Exit status like the command diff: 1: something differs; 2: the comparison failed.
    int diff(Streams& streams) const {
        try {
            return differs(streams) ? failed : fine;
        } catch (const Failure& e) {
            throw UsageError{e.what()};
        }
    }
    bool differs(Streams& streams) const {
        const Json given = parsed_parameter_file(read_input(file(), "parameters as JSON", streams), file());
        DeviceClient client{options, streams};
        const Difference d = difference(client, given, true, streams);
        if (!options.json) {
            if (const std::string other = of_another_device(given, client.known_device()); !other.empty())
                print_note(streams, other);
            show(d, streams);
        }
        for (const Json& row : at(d.answer, "parameters"))
            if (const bool is_same = text_at(row, "state") == "unchanged"; is_same ? all : options.json) show_row(row, streams);
        return d.changes > 0;
    }
    void show_row(const Json& row, Streams& streams) const {
        if (options.json) streams.out << ano::json_text(row) << '\n';
        else print(streams, text_at(row, "name") + ": " + value_text(row["written"]) + " (unchanged)");
    }

    int import_from(Streams& streams) const {
        const Json given = parsed_parameter_file(read_input(file(), "parameters as JSON", streams), file());
        DeviceClient client{options, streams};
        client.will_act();
        const Difference d = difference(client, given, false, streams);
        if (!options.json) show(d, streams);
        if (d.changes > 0) {
            client.must_be_able_to_ask("param import");
            const std::string other = of_another_device(given, client.known_device());
            if (!other.empty() && options.yes) print_note(streams, other);
            if (!other.empty() && !client.may(other + ". Continue anyway?")) return declined(streams);
            if (!client.may("Write " + plural(d.changes, "parameter") + " to " + client.device_words() + "?"))
                return declined(streams);
        }
        return apply(client, d, streams);
    }

    static Json without_the_written(const Json& answer) {
        Json rows = Json::array();
        for (const Json& row : at(answer, "parameters"))
            if (text_at(row, "state") != "written") rows.push_back(row);
        return {{"parameters", rows}};
    }

    int apply(DeviceClient& client, const Difference& d, Streams& streams) const {
        Json order{{"parameters", d.values}};
        if (rollback) order["rollback"] = true;
        if (longer) order["longer"] = true;
        if (force) order["force"] = true;
        Json came = d.answer;
        std::string why;
        try {
            if (d.changes > 0) came = client.run("POST", client.target("/apply"), order.dump());
        } catch (const JobFailure& e) {    // first prints the result of each
            came = parse_answer(e.result);
            why = e.what();
        }
        const std::size_t failures = rows_with(came, "failed"), untried = rows_with(came, "waiting");
        const std::size_t wrong = failures + rows_with(came, "undone") + rows_with(came, "not_undone");
        if (options.json) {
            for (const Json& row : at(came, "parameters")) streams.out << ano::json_text(row) << '\n';
        } else if (d.changes > 0) {
            const std::size_t written = rows_with(came, "written") + rows_with(came, "clamped");
            const std::size_t left = rows_with(came, "not_undone");
            const bool is_another = text_at(came, "another_device") == "true";
            print(streams, left > 0       ? plural(left, "parameter") + " could not be undone"
                           : written == 0 ? "no parameter was written"
                           : is_another   ? plural(written, "parameter") + " written to the device that was there before"
                                          : plural(written, "parameter") + " written; to save permanently: anoctl param save");
            for (const std::string& line : difference_lines(without_the_written(came))) print(streams, line);
        }
        if (const std::string note = text_at(came, "note"); !note.empty()) print_note(streams, note);
        if (!why.empty() && (rollback || failures == 0)) throw Failure{why};
        if (failures > 0)
            throw Failure{plural(failures, "parameter") + (failures == 1 ? " was" : " were") + " not written" +
                          (untried > 0 ? ", and " + std::to_string(untried) + " not attempted: " + why : "")};
        if (wrong == 0 && is_kept_by_calibration(words[0]) && is_file(words[0]))    // a gateway removes its own file itself
            print_note(streams, "the old calibration was restored; save it (anoctl param save), then remove " + words[0] +
                                    (is_in_state_folder(words[0])
                                         ? ". Until then, anoctl calibrate --link does not start another calibration"
                                         : ""));
        return wrong == 0 ? fine : failed;
    }
};

}    // namespace

Run add_param(Options& options) {
    const auto self = std::make_shared<Param>();
    options.push_back(
        {"action", &self->action, "list|get|set|save|reset|export|import|diff",
         "list; get NAME... or --all; set NAME VALUE or NAME=VALUE...; save: save permanently; reset: restore factory defaults; "
         "export [FILE]; import FILE: show the changes and write them after confirmation (exit status 1 if the device refused a "
         "value); diff FILE (exit status 1 if values differ, 2 if the comparison failed)",
         true});
    options.push_back({"words", &self->words, "[PARAMETER|FILE...]", "Arguments of the action"});
    options.push_back({"--all", &self->all, "",
                       "All parameters (get: read all; diff: list unchanged ones too; import: list all that do not fit)"});
    options.push_back({"--with-calibration", &self->with_calibration, "",
                       "Include CAL_... parameters, which are specific to one device (import, diff)"});
    options.push_back({"--longer", &self->longer, "", "Allow texts longer than the current ones (set, import)"});
    options.push_back({"--force", &self->force, "",
                       "Allow values outside the range stated by the device (set, import), or a reset in flight (reset)"});
    options.push_back({"--rollback", &self->rollback, "",
                       "Restore all old values if one value is refused (import); without it the other values are still written"});
    DeviceOptions::add(options, self->options, "param");
    DeviceOptions::add_yes(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
