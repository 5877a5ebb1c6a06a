#include "gateway_layouts.hpp"
#include <anoctl/text/gateway_json.hpp>
#include "anoctl.hpp"

#include <ano_json/flexible_json.hpp>

#include <nlohmann/json.hpp>

namespace anoctl {

std::vector<ano::FlexibleSpec> layouts_of_gateway(const GatewayOptions& gateway) {
    std::vector<ano::FlexibleSpec> specs;
    const anogate::http::Answer answer = gateway.answer("GET", "/flexible");
    constexpr unsigned not_found = 404;    // response of an older gateway
    if (answer.status == not_found) return specs;
    if (answer.status / 100 != 2) throw Failure{format_failure(answer)};
    ano::read_flexible(nlohmann::json::parse(at(parse_answer(answer.body), "flexible").dump()), "/flexible", specs);
    return specs;
}

}    // namespace anoctl
