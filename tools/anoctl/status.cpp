// anoctl status: the state of the gateway.
#include "anoctl.hpp"
#include "gateway.hpp"
#include "gateway_json.hpp"
#include "table.hpp"

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>

namespace anoctl {
namespace {

using ano::Json;

std::string first_line(const Json& gateway) {
    std::string line = text_at(gateway, "name") + ", anogate " + text_at(gateway, "version");
    if (const std::string id = text_at(gateway, "id"); !id.empty()) line += ", id " + id;
    line += ", up for " + time_text(number_at(gateway, "uptime_s"));
    if (const std::string stood = text_at(gateway, "standstills"); !stood.empty() && stood != "0")
        line += "; stood still " + stood + " times, for " + time_text(number_at(gateway, "longest_standstill_s")) + " at most";
    return line;
}

std::string sum_of(const Json& link, const std::vector<std::string>& names) {
    double sum = 0;
    for (const std::string& name : names) sum += number_at(link, name);
    return Json(static_cast<std::uint64_t>(sum)).dump();
}

void write_links(const Json& links, std::ostream& out) {
    Table table{{"LINK", "KIND", "STATE", "SINCE", " IN", " OUT", " DROPPED"}};
    for (const Json& link : links) {
        table.row({text_at(link, "name"), text_at(link, "kind"), text_at(link, "state"), time_text(number_at(link, "since_s")),
                   text_at(link, "frames_in"), text_at(link, "frames_out"), sum_of(link, drop_causes())});
        if (const std::string place = listening_place(link); !place.empty()) table.note("    at " + place);
        for (const char* key : {"error", "hint"})
            if (const std::string words = text_at(link, key); !words.empty()) table.note("    " + words);
    }
    if (table.empty()) out << "no links are configured\n";
    else table.write(out);
}

void write_conflicts(const Json& conflicts, std::ostream& out) {
    for (const Json& conflict : conflicts)
        out << "conflict: " << text_at(conflict, "address") << " speaks on " << names_at(conflict, "links") << ", "
            << text_at(conflict, "count") << " times\n";
}

void write_tunnel(const Json& tunnel, std::ostream& out) {
    std::vector<std::string> names;
    for (const auto& [name, value] : tunnel.items()) names.push_back(name);
    if (!names.empty()) out << list_text("tunnel: ", not_zero(tunnel, names)) << '\n';
}

void write_gpio(const Json& lines, std::ostream& out) {
    for (const Json& line : lines) {
        out << "gpio: " << text_at(line, "use") << ", " << text_at(line, "chip") << " line " << text_at(line, "line") << ": ";
        const std::string error = text_at(line, "error"), value = text_at(line, "value");
        out << text_at(line, "state") << (error.empty() ? "" : ", " + error)
            << (value.empty()     ? ""
                : value == "true" ? ", active"
                                  : ", inactive")
            << '\n';
    }
}

struct StatusView {
    GatewayOptions gateway;
    bool json = false;

    int run(Streams& streams) const {
        const std::string body = gateway.ask("GET", "/status");
        const Json status = parse_answer(body);
        if (json) {
            streams.out << status.dump() << '\n';
            return fine;
        }
        streams.out << first_line(at(status, "gateway")) << '\n';
        write_links(at(status, "links"), streams.out);
        write_conflicts(at(status, "conflicts"), streams.out);
        write_tunnel(at(status, "tunnel"), streams.out);
        write_gpio(at(status, "gpio"), streams.out);
        for (const std::string& line : recording_lines(at(status, "recording"))) streams.out << line << '\n';
        return fine;
    }
};

}    // namespace

Run add_status(Options& options) {
    const auto self = std::make_shared<StatusView>();
    GatewayOptions::add(options, self->gateway);
    options.push_back({"--json", &self->json, "", "As the gateway says it: one JSON object"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
