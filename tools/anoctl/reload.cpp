// anoctl reload: the gateway reads its configuration again.
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
#include <string_view>

namespace anoctl {
namespace {

using ano::Json;

constexpr unsigned faulty = 422;

void write_lines(const Json& lines, std::ostream& out) {
    for (const Json& line : lines)
        if (line.is_string()) out << "    " << without_controls(line.get<std::string>()) << '\n';
}

void write_difference(const Json& answer, std::ostream& out) {
    std::size_t same = 0;
    for (const Json& link : at(answer, "links")) {
        if (text_at(link, "change") == "same") {
            ++same;
            continue;
        }
        out << text_at(link, "name") << ": " << text_at(link, "change") << '\n';
        write_lines(at(link, "differences"), out);
    }
    for (const Json& file : at(answer, "files"))
        if (file.is_string()) out << "read again: " << without_controls(file.get<std::string>()) << '\n';
    if (!at(answer, "gateway").empty()) out << "gateway: changed\n";
    write_lines(at(answer, "gateway"), out);
    if (same > 0) out << same << (same == 1 ? " link unchanged\n" : " links unchanged\n");
}

struct Reload {
    GatewayOptions gateway;
    bool dry_run = false, confirm = false, json = false;
    std::optional<std::string> confirm_within;

    int run(Streams& streams) const {
        if (confirm) return confirm_it(streams);
        std::string target = "/reload";
        if (dry_run) target += "?dry_run";
        if (confirm_within) target += (dry_run ? "&" : "?") + ("confirm_within=" + percent_encoded(*confirm_within));
        const anogate::http::Answer answer = gateway.answer("POST", target);
        if (answer.status == faulty) return refused(answer, streams);
        if (answer.status / 100 != 2) throw_failure(answer);
        const Json came = parse_answer(answer.body);
        if (json) streams.out << ano::json_text(came) << '\n';
        else print_result(came, streams.out);
        return fine;
    }

private:
    int confirm_it(Streams& streams) const {
        const std::string body = gateway.ask("POST", "/reload/confirm");
        if (json) streams.out << ano::json_text(parse_answer(body)) << '\n';
        else streams.out << "the new configuration is confirmed\n";
        return fine;
    }

    // Replaces the name of the query parameter in the gateway's error text by that of the option.
    [[noreturn]] static void throw_failure(const anogate::http::Answer& answer) {
        const std::string words = format_failure(answer);
        constexpr std::string_view query_word = "'confirm_within'";
        if (words.starts_with(query_word)) throw UsageError{"--confirm-within" + words.substr(query_word.size())};
        throw Failure{words};
    }

    // Prints the faults of the configuration, which the response lists.
    int refused(const anogate::http::Answer& answer, Streams& streams) const {
        const Json came = parse_answer(answer.body);
        if (json) streams.out << ano::json_text(came) << '\n';
        else
            for (const Json& fault : at(came, "faults"))
                if (fault.is_string()) streams.err << "anoctl: " << without_controls(fault.get<std::string>()) << '\n';
        throw Failure{format_failure(answer)};
    }

    void print_result(const Json& came, std::ostream& out) const {
        const bool changed = text_at(came, "changed") == "true";
        const std::string fault = text_at(came, "http_error");
        if (!fault.empty()) out << "HTTP interface off: " << without_controls(fault) << '\n';
        if (changed) write_difference(came, out);
        if (const Json& later = at(came, "needs_restart"); !later.empty()) {
            out << "at the next start:\n";
            write_lines(later, out);
        } else if (!changed && fault.empty()) {
            out << "no changes\n";
        }
        if (!changed) return;
        if (dry_run) out << "nothing was changed (--dry-run)\n";
        else if (number_at(came, "confirm_within_s") > 0)
            out << "the previous configuration is restored in " << time_text(number_at(came, "confirm_within_s"))
                << " unless you confirm: anoctl reload --confirm\n";
    }
};

}    // namespace

Run add_reload(Options& options) {
    const auto self = std::make_shared<Reload>();
    options.push_back({"--dry-run", &self->dry_run, "", "Show what would change, and change nothing"});
    options.push_back({"--confirm-within", &self->confirm_within, "TIME",
                       "Restore the previous configuration after TIME (such as 30s) unless you run reload --confirm before"});
    options.push_back({"--confirm", &self->confirm, "", "Keep the new configuration", false, {"--dry-run", "--confirm-within"}});
    GatewayOptions::add(options, self->gateway);
    options.push_back({"--json", &self->json, "", "Print the response of the gateway as one JSON object"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
