// anoctl waypoint: reads the waypoints of a device into a file, and writes a file to a device.
#include "device_client.hpp"
#include "file_text.hpp"
#include "waypoint_form.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/syntax_fault.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/json_file.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include <devices/waypoint_forms.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using ano::Json;

struct Waypoint {
    DeviceOptions options;
    std::string action, file = "-";
    std::string format;

    int run(Streams& streams) const {
        if (action == "get") return get(streams);
        if (action == "put") return put(streams);
        throw UsageError{"waypoint " + ano::in_quotes(action) + " is not an action; actions: get [FILE], put FILE"};
    }

private:
    static std::string query(const std::string& form) { return form == "json" ? "" : "?format=" + form; }

    int get(Streams& streams) const {
        const std::string form = format.empty() ? form_of_name(file) : format;
        DeviceClient client{options, streams};
        if (!client.may_write(file)) {
            print_note(streams, "nothing was read");
            return failed;
        }
        const Json answer = client.run("GET", client.target("/waypoints" + query(form)));
        const std::string whole = ano::with_json_escapes(answer.dump(2, ' ', false, Json::error_handler_t::replace)) + "\n";
        if (file == "-") {
            streams.out << (options.json ? ano::json_text(answer) + '\n' : whole);
            return fine;
        }
        write_file(file, whole);
        print_note(streams, "waypoints of " + client.device_words() + " saved to " + file);
        return fine;
    }

    Json given(Streams& streams) const { return json_in_text(read_input(file, "waypoints as JSON", streams), file); }

    /// Parsed as the gateway parses it, so that errors in the file are reported before the user is asked.
    std::vector<ano::host::Waypoint> waypoints_of(const Json& json, const std::string& form) const {
        auto read = anogate::waypoints_in(json, anogate::waypoint_form(form).value_or(anogate::WaypointForm::plain));
        if (const auto* wrong = std::get_if<std::string>(&read)) throw UsageError{file + ": " + *wrong};
        return std::get<std::vector<ano::host::Waypoint>>(std::move(read));
    }

    int put(Streams& streams) const {
        const Json json = given(streams);
        const std::string form = format.empty() ? form_of_content(json, file) : format;
        const auto waypoints = waypoints_of(json, form);
        if (waypoints.empty()) throw UsageError{file + ": the file contains no waypoints"};
        DeviceClient client{options, streams};
        client.will_act();
        client.must_be_able_to_ask("waypoint put");
        const std::size_t had = at(client.run("GET", client.target("/waypoints")), "waypoints").size();
        const std::string before = overwriting_text(waypoints, had) + speedless_text(json, form, waypoints);
        if (options.yes && !before.empty())
            print_note(streams, client.device_words() + ": " + before.substr(0, before.size() - 1));
        if (!client.may(before + "Write " + plural(waypoints.size(), "waypoint") + " to " + client.device_words() + "?")) {
            print_note(streams, "nothing was written");
            return failed;
        }
        const Json came = client.run("PUT", client.target("/waypoints" + query(form)), json.dump());
        if (options.json) {
            streams.out << ano::json_text(came) << '\n';
            return fine;
        }
        const std::string note = text_at(came, "note");
        print(streams, client.device_words() + ": " + plural(waypoints.size(), "waypoint") + " written" +
                           (note.empty() ? "" : "; " + note));
        return fine;
    }
};

}    // namespace

Run add_waypoint(Options& options) {
    const auto self = std::make_shared<Waypoint>();
    const auto read_format = [self](const std::string& word) -> std::string {
        if (word != "json" && word != "geojson" && word != "qgc") return ano::in_quotes(word) + " is not json, geojson or qgc";
        self->format = word;
        return {};
    };
    options.push_back({"action", &self->action, "get|put",
                       "get [FILE]: read the waypoints of the device; put FILE: write them to the device, after confirmation. "
                       "Waypoints are numbered from 0",
                       true});
    options.push_back({"file", &self->file, "[FILE]", "File to write or read (default: -, standard input or output)"});
    options.push_back(
        {"--format", Option::Read{read_format}, "json|geojson|qgc",
         "File format (default: get uses the name: .geojson, .plan for QGroundControl, otherwise json; put uses the content)"});
    DeviceOptions::add(options, self->options, "waypoint");
    DeviceOptions::add_yes(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
