// anoctl metrics: the counters in the Prometheus text format.
#include <anoctl/text/prometheus_text.hpp>
#include "anoctl.hpp"
#include "gateway.hpp"

#include <ano_json/escapes.hpp>
#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>

namespace anoctl {
namespace {

struct Metrics {
    GatewayOptions gateway;
    bool openmetrics = false, json = false;

    int run(Streams& streams) const {
        const std::string text = gateway.ask("GET", "/metrics",
                                             openmetrics ? "application/openmetrics-text; version=1.0.0" : "text/plain");
        if (!json) streams.out << text;
        else
            for (const ano::Json& sample : samples_of(text)) streams.out << ano::json_text(sample) << '\n';
        return fine;
    }
};

}    // namespace

Run add_metrics(Options& options) {
    const auto self = std::make_shared<Metrics>();
    GatewayOptions::add(options, self->gateway);
    options.push_back({"--openmetrics", &self->openmetrics, "", "Use the OpenMetrics 1.0.0 format", false, {}});
    options.push_back({"--json", &self->json, "", "Print one JSON object per metric and line: name, labels, value"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
