// anoctl waypoint: the waypoints of a device, to a file and back.
#include "device_client.hpp"
#include "file_text.hpp"
#include "waypoint_form.hpp"

#include <ano_json/syntax_fault.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/gateway_json.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>

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
        throw UsageError{"waypoint " + ano::in_quotes(action) + " is nothing to do; get [FILE] and put FILE are"};
    }

private:
    static std::string query(const std::string& form) { return form == "json" ? "" : "?format=" + form; }

    int get(Streams& streams) const {
        DeviceClient client{options, streams};
        const std::string form = format.empty() ? form_of_name(file) : format;
        const Json answer = client.run("GET", client.target("/waypoints" + query(form)));
        if (file == "-") {
            streams.out << (options.json ? answer.dump() : answer.dump(2)) << '\n';
            return fine;
        }
        write_file(file, answer.dump(2) + "\n");
        streams.err << "anoctl: the waypoints of " << client.device_words() << " are in " << file << '\n';
        return fine;
    }

    int put(Streams& streams) const {
        Json given;
        const std::string text = text_of_file(file);
        try {
            given = Json::parse(text);
        } catch (const Json::exception& e) {
            throw UsageError{file + ": it is not JSON: " + ano::syntax_fault(text, e)};
        }
        DeviceClient client{options, streams};
        const std::string form = format.empty() ? form_of_content(given) : format;
        const Json came = client.run("PUT", client.target("/waypoints" + query(form)), given.dump());
        if (options.json) streams.out << came.dump() << '\n';
        else streams.out << client.device_words() << ": " << text_at(came, "written") << " waypoints written\n";
        return fine;
    }
};

}    // namespace

Run add_waypoint(Options& options) {
    const auto self = std::make_shared<Waypoint>();
    const auto read_format = [self](const std::string& word) -> std::string {
        if (word != "json" && word != "geojson" && word != "qgc")
            return ano::in_quotes(word) + " is neither json, geojson nor qgc";
        self->format = word;
        return {};
    };
    options.push_back(
        {"action", &self->action, "get|put", "get [FILE] reads them out of the device, put FILE writes them into it", true});
    options.push_back(
        {"file", &self->file, "[FILE]", "Where they are written to or come from (default: -, standard input and output)"});
    options.push_back({"--format", Option::Read{read_format}, "json|geojson|qgc",
                       "Of the file (default: put looks, get goes by its name: .geojson, .plan of QGroundControl, else json)"});
    DeviceOptions::add(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
