#include <config/link_kind.hpp>
#include <control/control_listeners.hpp>
#include <daemon/check_listener.hpp>
#include <http/listeners/token_file.hpp>
#include <http/tls.hpp>
#include <link/tcp/tcp_keys.hpp>
#include <link/tcp/tls_context.hpp>
#include <sys/files/state_folder.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>

#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

namespace anogate {
namespace {

namespace fs = std::filesystem;

/// The absolute path for the service, whose working folder is /.
std::string seen_by(bool service, const std::string& path) { return service ? (fs::path{"/"} / path).string() : path; }

bool is_hidden(const std::string& path) { return ::access(path.c_str(), R_OK) != 0 && errno == EACCES; }

/// Whether the file exists and the user of the service can't read it.
bool is_closed_to_service(const std::string& path) {
    const passwd* const user = ::getpwnam("anogate");
    struct stat facts {};
    if (!user || ::stat(path.c_str(), &facts) != 0) return false;
    std::array<gid_t, 64> groups{};
    int count = groups.size();
    if (::getgrouplist(user->pw_name, user->pw_gid, groups.data(), &count) < 0) return false;
    const auto end = groups.begin() + count;
    const bool is_member = std::find(groups.begin(), end, facts.st_gid) != end;
    const mode_t may_read = facts.st_uid == user->pw_uid ? S_IRUSR : is_member ? S_IRGRP : S_IROTH;
    return (facts.st_mode & may_read) == 0;
}

template <typename Place>
void warn_of_key(Draft& draft, const Place& place, const std::string& key) {
    if (is_closed_to_service(key))
        draft.warnings.push_back(
            {place, "warning: the service, user anogate, can't read " + key + "; run sudo chown anogate: " + key});
}

void warn_of_tls(Draft& draft, bool service) {
    const TlsFiles& files = draft.settings.control.tls;
    if (files.key.empty()) return;
    const std::string certificate = seen_by(service, files.certificate), key = seen_by(service, files.key);
    if (service) warn_of_key(draft, draft.control.key("tls"), key);
    if (service && (is_hidden(certificate) || is_hidden(key))) return;
    const auto tls = http::Tls::load(certificate, key);
    const auto warn = [&](const std::string& what) { draft.warnings.push_back({draft.control.key("tls"), "warning: " + what}); };
    if (!tls) return warn("control.http stays off: " + tls.error());
    if (const std::string advice = (*tls)->advice(); !advice.empty()) warn(key + ": " + advice);
    if (const std::string warning = (*tls)->validity().warning("the certificate"); !warning.empty())
        warn(certificate + ": " + warning);
}

void warn_of_link(Draft& draft, std::size_t at, bool service) {
    const LinkSettings& link = draft.settings.links[at];
    if (!link.kind->encrypts) return;
    LinkCertificates files = link.kind->listens ? link.as<TcpListenSettings>().tls : link.as<TcpSettings>().tls;
    if (service && !files.key.empty()) warn_of_key(draft, draft.links[at].key("key"), seen_by(service, files.key));
    for (std::string* file : {&files.certificate, &files.key, &files.ca}) {
        if (file->empty()) continue;
        *file = seen_by(service, *file);
        if (service && is_hidden(*file)) return;
    }
    const auto tls = TlsContext::read(files, TlsContext::Side::connects);
    if (const std::string fault = tls ? validity_trouble(**tls).text : tls.error().text; !fault.empty())
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
