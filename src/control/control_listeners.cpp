#include <control/control_listeners.hpp>
#include <control/login_route.hpp>
#include <foxglove/foxglove_messages.hpp>
#include <http/body_file.hpp>
#include <http/listeners/tcp_listener.hpp>
#include <http/listeners/token_file.hpp>
#include <http/socket_path.hpp>
#include <log/log_line.hpp>
#include <sys/descriptors_left.hpp>
#include <sys/device_permission.hpp>
#include <sys/files/read_file.hpp>
#include <sys/files/state_folder.hpp>
#include <sys/lazy_memory.hpp>

#include <climits>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <utility>

#include <unistd.h>

namespace anogate {
namespace {

constexpr Duration retry = std::chrono::milliseconds{500};
const std::string not_read = "tokens and certificate were not reloaded, the previous ones stay in use: ";
constexpr std::size_t request_memory = 384 * 1024;    // bytes for a request and its response; without them no request is accepted

std::string host_name() {
    char name[HOST_NAME_MAX + 1] = {};
    return ::gethostname(name, sizeof name - 1) == 0 ? name : "";
}

/// The file with the tokens; empty: none are needed, or there is no folder for it.
std::string token_file_of(const ControlSettings& settings, bool needs_token) {
    if (!settings.token_file.empty() || !needs_token) return settings.token_file;
    const std::string folder = state_folder();
    return folder.empty() ? folder : folder + "/token";
}

/// The absolute path, for programs in other working folders.
std::string whole_path(const std::string& path) {
    std::error_code ec;
    const std::filesystem::path whole = std::filesystem::absolute(path, ec);
    return ec ? path : whole.lexically_normal().string();
}

/// By path, a number that differs after a change of the content. May block.
std::map<std::string, std::size_t> contents_of(std::initializer_list<std::string> files) {
    std::map<std::string, std::size_t> contents;
    for (const std::string& file : files) {
        if (file.empty()) continue;
        std::error_code error;
        contents[whole_path(file)] = std::hash<std::string>{}(read_file(file, max_config_size, error));
    }
    return contents;
}

void log_guessing(const std::string& peer, const http::Attempts::News& news) {
    if (news.unlogged > 0)
        log_warning("control.http: before that, {} more addresses with wrong tokens were slowed down", news.unlogged);
    log_warning(
        "control.http: ten wrong tokens from {} within a minute; further ones are delayed and counted (http.wrong_tokens "
        "in the status){}",
        peer,
        news.is_last ? "; too many addresses do this, so others are only counted in this minute (http.guessing_clients)" : "");
}

}    // namespace

bool network_needs_token(const std::string& address, uid_t user) { return is_service_user(user) || !http::is_loopback(address); }

ControlListeners::ControlListeners(asio::io_context& io, ControlSettings settings)
    : settings_{std::move(settings)},
      server_{io, {}, [] { return memory_is_left(request_memory); }},
      again_{io, [this] { try_again(); }},
      background_task_{io} {
    server_.admission().on_guessing(log_guessing);
    server_.keep_large_bodies([&io] { return std::make_unique<FileKeeper>(io); });
}

void ControlListeners::add_login_routes() {
    routes().add(
        {"POST", "/login", http::Access::open,
         "accepts a token as {\"token\": ...} or a one-time code as {\"code\": ...}, and sets a session cookie for the browser",
         [this](const http::Request& request) { return login(server_.admission(), codes_, request, ano::Clock::now()); }});
    routes().add(
        {"POST", "/login/code", http::Access::control,
         "creates a one-time code for /login, valid for five minutes: for a link, or with {\"form\": \"digits\"} six digits; "
         "with {\"access\": \"view\"} read-only",
         [this](const http::Request& request) { return make_code(server_.admission(), codes_, request, ano::Clock::now()); }});
    routes().add_without_body({"POST", "/logout", http::Access::open, "clears the cookie",
                               [this](const http::Request& request) { return logout(server_.admission(), request); }});
}

bool ControlListeners::open() {
    if (!open_local()) return false;
    if (settings_.http) open_network();
    if (awaits_local_ || awaits_network_) again_.start(retry);
    return true;
}

void ControlListeners::finish(Duration patience) {
    again_.stop();
    background_task_.stop();
    server_.finish(patience);
}

void ControlListeners::close() {
    again_.stop();
    background_task_.stop();
    server_.stop();
}

bool ControlListeners::open_local() {
    const auto socket = http::control_socket(settings_.socket, http::this_runner());
    if (!socket) return true;
    socket_ = *socket;
    const http::Server::Outcome outcome = server_.start(socket_);
    if (!outcome.notice.empty()) log_info("{}", outcome.notice);
    if (outcome.error.empty()) return true;
    if (!outcome.in_use && !settings_.socket.empty()) {
        log_error("--control: {}", outcome.error);
        return false;
    }
    log_warning("no control interface: {}{}", outcome.error, outcome.in_use ? "; waiting for it" : "");
    awaits_local_ = outcome.in_use;
    return true;
}

/// The content of the files for TCP access.
struct ControlListeners::Files {
    std::string fault{};          // empty: none
    bool may_be_valid = false;    // with a fault: none of the files, but of the system, which has no descriptor or memory left
    std::string token_file{}, token_file_id{};
    std::vector<http::Token> tokens{};
    std::shared_ptr<http::Tls> tls{};
    std::map<std::string, std::size_t> contents{};
};

// May block.
ControlListeners::Files ControlListeners::read_files(const ControlSettings& settings, bool needs_token) {
    Files files;
    files.token_file = token_file_of(settings, needs_token);
    if (needs_token && files.token_file.empty()) return {"no folder for the tokens; set control.token_file"};
    if (!files.token_file.empty()) {
        auto tokens = http::read_or_make_tokens(files.token_file);
        if (!tokens) return {"control.token_file: " + tokens.error()};
        files.tokens = std::move(*tokens);
        files.token_file_id = http::id_of_token_file(files.token_file);
    }
    files.contents = contents_of({files.token_file, settings.tls.certificate, settings.tls.key});
    if (settings.tls.key.empty()) return files;
    auto tls = http::Tls::load(settings.tls.certificate, settings.tls.key);
    if (!tls) return {"control.tls: " + tls.error()};
    files.tls = std::move(*tls);
    return files;
}

void ControlListeners::open_network() {
    name_network();
    if (!use(read_files(settings_, network_.needs_token))) return;
    awaits_network_ = true;
    try_network();
}

void ControlListeners::renew(bool dry_run, const Renewed& done) {
    if (!settings_.http) return done({}, {});
    const auto files = std::make_shared<Files>();
    const bool goes = background_task_.run(
        [files, dry_run, settings = settings_, needs = network_.needs_token] {
            if (!dry_run) *files = read_files(settings, needs);
            else files->contents = contents_of({token_file_of(settings, needs), settings.tls.certificate, settings.tls.key});
            files->may_be_valid = !can_open_descriptors();
        },
        [this, files, dry_run, done](std::string thrown) {
            if (!thrown.empty()) files->fault = std::move(thrown), files->may_be_valid = true;
            if (!files->fault.empty() && files->may_be_valid) return done(not_read + files->fault, {});
            std::vector<std::string> changed = changed_files(files->contents);
            if (dry_run) return done({}, std::move(changed));
            const bool was_shut = listener_info_.state == ListenerInfo::State::shut;
            if (use(std::move(*files)) && was_shut) {
                awaits_network_ = true;
                try_network();
                if (awaits_network_) again_.start(retry);
            }
            if (listener_info_.state == ListenerInfo::State::shut) return done(listener_info_.error, {});
            done({}, std::move(changed));
        });
    if (!goes) done(not_read + std::string{background_task_.why_not()}, {});
}

std::vector<std::string> ControlListeners::changed_files(const std::map<std::string, std::size_t>& contents) const {
    std::vector<std::string> changed;
    for (const auto& [path, content] : contents)
        if (const auto known = contents_.find(path); known == contents_.end() || known->second != content)
            changed.push_back(path);
    return changed;
}

// Without tokens or certificate, TCP stays closed: access without protection would be worse than no access.
bool ControlListeners::shut(std::string why) {
    log_error("control.http stays off: {}", why);
    awaits_network_ = false;
    network_.tls.reset();
    contents_.clear();
    server_.set_rules({});
    server_.stop_network();
    listener_info_.state = ListenerInfo::State::shut;
    listener_info_.error = std::move(why);
    return false;
}

void ControlListeners::name_network() {
    network_ = {settings_.http->address.text(), settings_.http->port};
    if (!settings_.http->interface.empty()) network_.address += "%" + settings_.http->interface;
    network_.needs_token = network_needs_token(network_.address, ::geteuid());
    listener_info_.address = network_.address;
    listener_info_.port = network_.port;
    listener_info_.needs_token = network_.needs_token;
    listener_info_.hosts = settings_.hosts;
}

// One-time codes become invalid with the tokens for which they were made. The name of the cookie stays the same while the program
// runs: a browser whose token is still valid stays signed in.
bool ControlListeners::use(Files files) {
    codes_ = {};
    if (!files.fault.empty()) return shut(std::move(files.fault));
    if (!files.token_file.empty() && listener_info_.token_file.empty())
        log_info("control.http: the tokens are in {}", files.token_file);
    if (token_file_id_.empty()) token_file_id_ = files.token_file_id;
    if (!files.token_file.empty()) listener_info_.token_file = whole_path(files.token_file);
    server_.set_rules({std::move(files.tokens),
                       host_name(),
                       settings_.hosts,
                       settings_.origins,
                       {"/", "/foxglove"},
                       {foxglove::subprotocols.begin(), foxglove::subprotocols.end()},
                       token_file_id_});
    contents_ = std::move(files.contents);
    network_.tls = std::move(files.tls);
    const std::string advice = network_.tls ? network_.tls->advice() : std::string{};
    if (!advice.empty()) log_warning("control.tls: {}: {}", settings_.tls.key, advice);
    logged_validity_.clear();
    log_validity();
    server_.set_tls(network_.tls);
    listener_info_.is_encrypted = network_.tls != nullptr;
    listener_info_.certificate = network_.tls ? whole_path(settings_.tls.certificate) : std::string{};
    return true;
}

void ControlListeners::log_validity() {
    std::string warning = network_.tls ? network_.tls->validity().warning("the certificate") : std::string{};
    if (warning == logged_validity_) return;
    logged_validity_ = std::move(warning);
    if (!logged_validity_.empty()) log_warning("control.tls: {}: {}", settings_.tls.certificate, logged_validity_);
}

void ControlListeners::try_again() {
    if (awaits_local_) try_local();
    if (awaits_network_) try_network();
    if (!awaits_local_ && !awaits_network_) again_.stop();
}

// Retries, because the program that uses the socket may stop.
void ControlListeners::try_local() {
    const http::Server::Outcome outcome = server_.start(socket_);
    if (!outcome.error.empty()) return;
    awaits_local_ = false;
    if (!outcome.notice.empty()) log_info("{}", outcome.notice);
    log_info("{}: up", socket_);
}

void ControlListeners::try_network() {
    const auto port = server_.start(network_);
    if (!port) {
        if (port.error() != listener_info_.error) log_warning("control.http: {}; waiting for it", port.error());
        listener_info_.state = ListenerInfo::State::waiting;
        listener_info_.error = port.error();
        return;
    }
    awaits_network_ = false;
    listener_info_.state = ListenerInfo::State::up;
    listener_info_.error.clear();
    listener_info_.port = *port;
    Endpoint where = *settings_.http;
    where.port = *port;
    log_info("{}{}: up", network_.tls ? "https://" : "http://", where.text());
}

}    // namespace anogate
