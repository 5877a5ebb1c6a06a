// anoctl flexible: the layouts of flexible messages in a running gateway.
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include "anoctl.hpp"
#include "gateway.hpp"
#include "json_file.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/flexible_json.hpp>
#include <ano_json/text.hpp>
#include <http/client/client.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>
#include <utility>

namespace anoctl {
namespace {

namespace http = anogate::http;
using ano::Json;

constexpr unsigned faulty_layouts = 422;

/// "temp i16[4] × 0.1 °C, …"
std::string fields_text(const Json& fields) {
    std::string text;
    for (const Json& field : fields) {
        text += (text.empty() ? "" : ", ") + text_at(field, "name") + " " + text_at(field, "type");
        if (field.contains("count")) text += "[" + text_at(field, "count") + "]";
        if (field.contains("scale")) text += " × " + ano::number_text(number_at(field, "scale"));
        if (field.contains("unit")) text += " " + text_at(field, "unit");
    }
    return text;
}

struct Flexible {
    std::string what = "list", file;
    bool json = false;
    GatewayOptions gateway;

    int run(Streams& streams) const {
        if (what == "set") return set(streams);
        if (!file.empty()) throw UsageError{"unexpected argument " + ano::in_quotes(file)};
        return show(gateway.ask("GET", "/flexible"), streams);
    }

private:
    int set(Streams& streams) const {
        if (file.empty()) throw UsageError{"missing FILE: a configuration or a list of layouts; - reads standard input"};
        const nlohmann::json whole = json_in_file(file, streams);
        if (!whole.is_array() && !(whole.is_object() && whole.contains("flexible")))
            throw UsageError{file + ": neither a list of layouts nor an object with the key 'flexible'"};
        http::Request request;
        request.method = "PUT";
        request.target = "/flexible";
        request.headers.push_back({"Content-Type", "application/json"});
        request.body = nlohmann::json{{"flexible", whole.is_array() ? whole : whole["flexible"]}}.dump();
        const http::Outcome outcome = http::ask(gateway.socket(), std::move(request));
        if (!outcome.fault.empty()) throw Failure{outcome.fault};
        if (outcome.answer.status == faulty_layouts) {
            const Json answer = parse_answer(outcome.answer.body);
            for (const Json& fault : at(answer, "faults"))
                if (fault.is_string()) streams.err << "anoctl: " << without_controls(fault.get<std::string>()) << '\n';
        }
        if (outcome.answer.status / 100 != 2) throw Failure{format_failure(outcome.answer)};
        return show(outcome.answer.body, streams);
    }

    int show(const std::string& body, Streams& streams) const {
        const Json answer = parse_answer(body);
        if (json) {
            streams.out << ano::json_text(answer) << '\n';
            return fine;
        }
        Table table{{"ID", "FROM", "WHEN", "ENDIAN", "FIELDS"}};
        for (const Json& layout : at(answer, "flexible"))
            table.row({text_at(layout, "id"), layout.contains("source") ? text_at(layout, "source") : "all",
                       layout.contains("when") ? text_at(layout, "when") : "-",
                       layout.contains("endian") ? text_at(layout, "endian") : "little", fields_text(at(layout, "fields"))});
        if (table.empty()) streams.out << "no layouts\n";
        else table.write(streams.out, {}, streams.terminal ? streams.width : 0);
        if (text_at(answer, "kept") == "false")
            streams.err << "anoctl: not saved permanently: " << text_at(answer, "why") << '\n';
        return fine;
    }
};

}    // namespace

Run add_flexible(Options& options) {
    const auto self = std::make_shared<Flexible>();
    const auto read_what = [self](const std::string& word) -> std::string {
        if (word != "list" && word != "set") return ano::in_quotes(word) + " is neither list nor set";
        self->what = word;
        return {};
    };
    options.push_back({"what", Option::Read{read_what}, "list|set",
                       "list (default): show the layouts in use; set FILE: replace them until the configuration changes them"});
    options.push_back(
        {"file", &self->file, "FILE", "A configuration with the key flexible, or only its list (set); - reads standard input"});
    options.push_back({"--json", &self->json, "", "Print the response of the gateway as one JSON object"});
    GatewayOptions::add(options, self->gateway);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
