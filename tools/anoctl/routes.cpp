// anoctl routes: the route of each address.
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include "anoctl.hpp"
#include "gateway.hpp"

#include <ano_json/escapes.hpp>
#include <nlohmann/json.hpp>

#include <memory>
#include <optional>
#include <ostream>
#include <string>

namespace anoctl {
namespace {

using ano::Json;

struct Routes {
    GatewayOptions gateway;
    std::optional<std::string> forget;
    bool json = false;

    int run(Streams& streams) const {
        if (forget) return forget_one(streams);
        const Json routes = parse_answer(gateway.ask("GET", "/routes"));
        Table table{{"ADDRESS", "WHO", "LINKS", "VIA", " HEARD"}};
        for (const Json& route : routes) {
            if (json) streams.out << ano::json_text(route) << '\n';
            else table.row(cells(route));
        }
        if (json) return fine;
        if (table.empty()) streams.out << "no routes yet\n";
        else table.write(streams.out);
        return fine;
    }

private:
    static Table::Line cells(const Json& route) {
        const bool was_heard = !text_at(route, "age_s").empty();
        return {text_at(route, "address"), text_at(route, "who"), names_at(route, "links"), text_at(route, "via"),
                was_heard ? time_text(number_at(route, "age_s")) : ""};
    }

    int forget_one(Streams& streams) const {
        const std::string body = gateway.ask("DELETE", "/routes/" + percent_encoded(*forget));
        const Json answer = parse_answer(body);
        if (json) streams.out << ano::json_text(answer) << '\n';
        else streams.out << text_at(answer, "address") << ": route removed\n";
        return fine;
    }
};

}    // namespace

Run add_routes(Options& options) {
    const auto self = std::make_shared<Routes>();
    options.push_back({"--forget", &self->forget, "ADDRESS", "Remove the learned route of this address"});
    GatewayOptions::add(options, self->gateway);
    options.push_back({"--json", &self->json, "", "Print one JSON object per address and line"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
