// anoctl links: the links of a gateway, with all counters.
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include "anoctl.hpp"
#include "gateway.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/nearest.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {
namespace {

using ano::Json;

std::string heard(const Json& channel) {
    return text_at(channel, "heard_s").empty() ? "" : time_text(number_at(channel, "heard_s"));
}

// The time since the last frame on any channel of the link.
std::string last_heard(const Json& link) {
    const Json* latest = nullptr;
    for (const Json& channel : at(link, "channels"))
        if (channel.contains("heard_s") && (!latest || number_at(channel, "heard_s") < number_at(*latest, "heard_s")))
            latest = &channel;
    return latest ? heard(*latest) : "";
}

void add_counters(Table& table, const Json& counted) {
    const auto add = [&](const char* head, const std::vector<std::string>& items) {
        if (!items.empty()) table.note(list_text(head, items));
    };
    add("      in: ", not_zero(counted, causes_in()));
    add("      out: ", not_zero(counted, causes_out()));
    add("      also: ", not_zero(counted, counts_of_kinds()));
}

void add_link(Table& table, const Json& link, PrintedHints& printed) {
    table.row({text_at(link, "name"), text_at(link, "state"), time_text(number_at(link, "since_s")), last_heard(link),
               text_at(link, "frames_in"), text_at(link, "frames_out"), text_at(link, "waiting")});
    if (const std::string place = listening_place(link); !place.empty()) table.note("    at " + place);
    for (const char* key : {"error", "hint"})
        if (const std::string words = printed.once(key, text_at(link, key)); !words.empty()) table.note("    " + words);
    add_counters(table, link);
    for (const Json& channel : at(link, "channels")) {
        const std::string peer = text_at(channel, "peer");
        if (peer.empty()) continue;
        table.row({"  " + peer, "", time_text(number_at(channel, "since_s")), heard(channel), text_at(channel, "frames_in"),
                   text_at(channel, "frames_out"), text_at(channel, "waiting")});
        if (channel.contains("listening_since_s"))
            table.note("    listening since " + time_text(number_at(channel, "listening_since_s")) + " ago");
    }
}

struct Links {
    GatewayOptions gateway;
    std::vector<std::string> names;
    bool json = false;

    int run(Streams& streams) const {
        const Json all = parse_answer(gateway.ask("GET", "/links"));
        const std::vector<Json> links = chosen(all);
        Table table{{"LINK", "STATE", "SINCE", "HEARD", " IN", " OUT", " WAITING"}};
        PrintedHints printed;
        for (const Json& link : links) {
            if (json) streams.out << ano::json_text(link) << '\n';
            else add_link(table, link, printed);
        }
        if (json) return fine;
        if (table.empty()) streams.out << "no links are configured\n";
        else table.write(streams.out);
        return fine;
    }

private:
    std::vector<Json> chosen(const Json& all) const {
        if (names.empty()) return {all.begin(), all.end()};
        std::vector<Json> links;
        for (const std::string& name : names) {
            const auto found = std::find_if(all.begin(), all.end(),
                                            [&](const Json& link) { return text_at(link, "name") == name; });
            if (found == all.end()) throw Failure{"unknown link " + ano::in_quotes(name) + nearest(name, all)};
            links.push_back(*found);
        }
        return links;
    }
    static std::string nearest(const std::string& name, const Json& all) {
        std::vector<std::string> known;
        for (const Json& link : all) known.push_back(text_at(link, "name"));
        std::string words = ano::did_you_mean(name, std::vector<std::string_view>{known.begin(), known.end()});
        for (std::size_t i = 0; i < known.size(); ++i) words.append(i == 0 ? "; links: " : ", ").append(known[i]);
        return words;
    }
};

}    // namespace

Run add_links(Options& options) {
    const auto self = std::make_shared<Links>();
    options.push_back({"names", &self->names, "[LINK...]", "Show only these links"});
    GatewayOptions::add(options, self->gateway);
    options.push_back({"--json", &self->json, "", "Print one JSON object per link and line"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
