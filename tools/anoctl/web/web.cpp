// anoctl web: how to access the gateway from a browser or another program.
#include <anoctl/anoctl.hpp>
#include <anoctl/gateway.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include "browser.hpp"
#include "qr_text.hpp"
#include "sign_in.hpp"
#include "web_certificate.hpp"
#include "web_names.hpp"

#include <http/client/certificate.hpp>
#include <link/udp/ip_socket.hpp>

#include <ano_json/escapes.hpp>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <system_error>

namespace anoctl {
namespace {

using ano::Json;

bool is_set(const Json& object, const char* key) { return text_at(object, key) == "true"; }

WebAddress web_address_of(const Json& http) {
    WebAddress web_address;
    const std::string written = text_at(http, "address");
    const bool is_v6 = written.find(':') != written.npos;
    const std::string where = (is_v6 ? "[" + written + "]" : written) + ":" + text_at(http, "port");
    if (const auto endpoint = anogate::EndpointSpec::parse(where)) static_cast<anogate::Endpoint&>(web_address) = *endpoint;
    web_address.is_encrypted = is_set(http, "tls");
    for (const Json& host : at(http, "hosts"))
        if (host.is_string()) web_address.hosts.push_back(without_controls(host.get<std::string>()));
    return web_address;
}

/// The reason why HTTP is not available, and what to do.
std::string why_not(const Json& http, const std::string& file) {
    const std::string state = text_at(http, "state"), error = text_at(http, "error");
    if (state == "waiting") return "no HTTP yet: " + error + "; the gateway is waiting for it";
    if (state == "shut") return "no HTTP: " + error + "; correct this, then: anoctl reload";
    if (state != "off") return "the gateway does not report whether it serves HTTP: its version differs from that of anoctl";
    return "the HTTP interface is off; add \"control\": {\"http\": \"0.0.0.0:8088\"} to " +
           (file.empty() ? "its configuration" : file) +
           ", or start anogated with --http 0.0.0.0:8088, and restart it; 127.0.0.1:8088 limits access to this computer";
}

void print_addresses(const Json& http, const WebAddress& web_address, const Computer& computer, std::ostream& out) {
    for (const std::string& url : urls_of(web_address, computer)) out << url << '\n';
    if (web_address.address.is_loopback()) {
        const std::string port = std::to_string(web_address.port);
        out << "accessible from this computer only; from another one, use: ssh -L " << port << ':' << text_at(http, "address")
            << ':' << port << ' ' << (computer.name.empty() ? "HOST" : computer.name) << '\n';
    }
    const std::string tokens = text_at(http, "token_file"), certificate = text_at(http, "certificate");
    if (!is_set(http, "token_needed")) out << "no token required\n";
    else
        out << "token required: see lines 'view' and 'control' in " << tokens
            << "; programs send it as \"Authorization: Bearer TOKEN\"\nto sign in to a browser without typing it: --open on this "
               "computer, --qr on a "
               "phone, --pair with a six-digit code\n";
    if (certificate.empty()) return;
    const std::filesystem::path authority = std::filesystem::path{certificate}.replace_filename("ca.pem");
    std::error_code ec;
    out << "encrypted; programs verify it with " << (std::filesystem::exists(authority, ec) ? authority.string() : certificate)
        << " (curl --cacert)\n";
    if (const auto known_by = anogate::http::fingerprint(certificate)) out << "SHA-256 fingerprint " << *known_by << '\n';
}

struct Web {
    GatewayOptions gateway;
    bool json = false, open = false, qr = false, pair = false, view = false;

    int run(Streams& streams) const {
        if (view && !open && !qr && !pair) throw UsageError{"--view requires --open, --qr or --pair"};
        return show(streams);
    }

private:
    int show(Streams& streams) const {
        const Json status = parse_answer(gateway.ask("GET", "/status"));
        const Json& http = at(status, "http");
        const bool is_up = text_at(http, "state") == "up";
        const WebAddress web_address = web_address_of(http);
        const Computer computer = this_computer();
        if (is_up && qr) return show_qr(http, web_address, streams);
        if (is_up && pair) return show_digits(http, web_address, streams);
        if (json) {
            Json result{{"urls", Json::array()}};
            if (is_up) result["urls"] = urls_of(web_address, computer);
            if (http.is_object()) result.update(http);
            streams.out << ano::json_text(result) << '\n';
        }
        if (!is_up) throw Failure{why_not(http, text_at(at(at(status, "gateway"), "config"), "file"))};
        if (!json) print_addresses(http, web_address, computer, streams.out);
        if (!open) return fine;
        streams.out.flush();
        open_page(http, url_here(web_address));
        return fine;
    }

    void open_page(const Json& http, const std::string& page) const {
        if (is_set(http, "token_needed")) return SignIn{gateway, view}.open(page);
        try {
            open_in_browser(page);
        } catch (const Failure& failure) {
            throw Failure{failure.what() + ("; open it yourself: " + page)};
        }
    }

    const char* allowed() const { return view ? "read-only access" : "full control"; }

    int show_qr(const Json& http, const WebAddress& web_address, Streams& streams) const {
        if (web_address.address.is_loopback())
            throw Failure{"a phone cannot reach the page: control.http listens only on " + web_address.address.text() +
                          "; configure \"http\": \"0.0.0.0:" + std::to_string(web_address.port) + "\" and restart the gateway"};
        const bool needs_code = is_set(http, "token_needed");
        const std::string page = url_for_phones(web_address, this_computer()),
                          link = needs_code ? SignIn{gateway, view}.link(page) : page;
        if (json) {
            streams.out << Json{{"link", link}} << '\n';
            return fine;
        }
        streams.out << qr_text(link, streams.color) << link << '\n';
        if (needs_code) streams.out << "It allows " << allowed() << "; valid once, for 5 minutes.\n";
        return fine;
    }

    int show_digits(const Json& http, const WebAddress& web_address, Streams& streams) const {
        const std::string page = urls_of(web_address, this_computer()).front();
        if (!is_set(http, "token_needed")) throw Failure{"no token required; open " + page};
        const Json code = SignIn{gateway, view}.code(SignIn::Form::digits);
        if (json) {
            streams.out << Json{{"digits", code.at("code")}, {"page", page}, {"expires_s", code.at("expires_s")}} << '\n';
            return fine;
        }
        streams.out << text_at(code, "code") << "\nType these digits instead of the token at " << page << "\nThey allow "
                    << allowed() << "; valid once, for 5 minutes. Three wrong attempts cancel them.\n";
        return fine;
    }
};

}    // namespace

Run add_web(Options& options) {
    const auto self = std::make_shared<Web>();
    options.push_back({"--open", &self->open, "", "Open the page in a browser on this computer (xdg-open), signed in"});
    options.push_back({"--qr",
                       &self->qr,
                       "",
                       "Show a QR code and its link that sign in a phone; valid once, for 5 minutes",
                       false,
                       {"--open"}});
    options.push_back(
        {"--pair",
         &self->pair,
         "",
         "Show six digits to type instead of the token, valid once, within 5 minutes; three wrong attempts cancel them",
         false,
         {"--open", "--qr"}});
    options.push_back({"--view", &self->view, "", "With --open, --qr or --pair: sign in with the read-only token"});
    GatewayOptions::add(options, self->gateway);
    options.push_back({"--json", &self->json, "", "Print one JSON object"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
