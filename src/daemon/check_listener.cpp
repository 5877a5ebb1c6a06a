#include <config/link_kind.hpp>
#include <control/control_listeners.hpp>
#include <daemon/check_listener.hpp>
#include <http/listeners/token_file.hpp>
#include <http/tls.hpp>
#include <link/tcp/tcp_keys.hpp>
#include <link/tcp/tls_context.hpp>
#include <sys/files/state_folder.hpp>

#include <cerrno>
#include <filesystem>

#include <unistd.h>

namespace anogate {
namespace {

namespace fs = std::filesystem;

/// The absolute path for the service, whose working folder is /.
std::string seen_by(bool service, const std::string& path) { return service ? (fs::path{"/"} / path).string() : path; }

bool is_hidden(const std::string& path) { return ::access(path.c_str(), R_OK) != 0 && errno == EACCES; }

void warn_of_tls(Draft& draft, bool service) {
    const TlsFiles& files = draft.settings.control.tls;
    if (files.key.empty()) return;
    const std::string certificate = seen_by(service, files.certificate), key = seen_by(service, files.key);
    if (service && (is_hidden(certificate) || is_hidden(key))) return;
    const auto tls = http::Tls::load(certificate, key);
    if (!tls) draft.warnings.push_back({draft.control.key("tls"), "warning: control.http stays off: " + tls.error()});
    else if (const std::string advice = (*tls)->advice(); !advice.empty())
        draft.warnings.push_back({draft.control.key("tls"), "warning: " + key + ": " + advice});
}

void warn_of_link(Draft& draft, std::size_t at, bool service) {
    const LinkSettings& link = draft.settings.links[at];
    if (!link.kind->encrypts) return;
    LinkCertificates files = link.kind->listens ? link.as<TcpListenSettings>().tls : link.as<TcpSettings>().tls;
    for (std::string* file : {&files.certificate, &files.key, &files.ca}) {
        if (file->empty()) continue;
        *file = seen_by(service, *file);
        if (service && is_hidden(*file)) return;
    }
    const auto tls = TlsContext::read(files, TlsContext::Side::connects);
    if (const std::string fault = tls ? expiry_trouble((*tls)->days_left()).text : tls.error().text; !fault.empty())
        draft.warnings.push_back({draft.links[at].key("certificate"), "warning: " + fault});
}

void warn_of_tokens(Draft& draft, bool service) {
    const ControlSettings& control = draft.settings.control;
    if (control.token_file.empty() && (service || !network_needs_token(control.http->address.text(), ::geteuid()))) return;
    const std::string folder = state_folder();
    if (control.token_file.empty() && folder.empty()) return;
    const std::string file = control.token_file.empty() ? folder + "/token" : seen_by(service, control.token_file);
    if (service && is_hidden(file)) return;
    if (const auto usable = http::check_tokens(file); !usable)
        draft.warnings.push_back({draft.control.key("token_file"), "warning: control.http stays off: " + usable.error()});
}

}    // namespace

void warn_of_listener(Draft& draft, bool is_for_service) {
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i) warn_of_link(draft, i, is_for_service);
    if (!draft.settings.control.http) return;
    warn_of_tls(draft, is_for_service);
    warn_of_tokens(draft, is_for_service);
}

}    // namespace anogate
