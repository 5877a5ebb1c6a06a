#include <daemon/body_file.hpp>
#include <daemon/control_door.hpp>
#include <daemon/foxglove_messages.hpp>
#include <daemon/log_line.hpp>
#include <daemon/login_route.hpp>
#include <daemon/rooms.hpp>
#include <daemon/state_folder.hpp>
#include <http/socket_path.hpp>
#include <http/tcp_door.hpp>
#include <http/token_file.hpp>
#include <link/device_permission.hpp>

#include <climits>
#include <filesystem>
#include <memory>
#include <utility>

#include <unistd.h>

namespace anogate {
namespace {

constexpr Duration retry = std::chrono::milliseconds{500};
constexpr std::size_t request_memory = 384 * 1024;    // bytes for a request with its response: no request is begun without them

std::string host_name() {
    char name[HOST_NAME_MAX + 1] = {};
    return ::gethostname(name, sizeof name - 1) == 0 ? name : "";
}

/// The absolute path, for programs that run in another folder.
std::string whole_path(const std::string& path) {
    std::error_code ec;
    const std::filesystem::path whole = std::filesystem::absolute(path, ec);
    return ec ? path : whole.lexically_normal().string();
}

}    // namespace

bool network_needs_token(const std::string& address, uid_t user) { return is_service_user(user) || !http::is_loopback(address); }

ControlDoor::ControlDoor(asio::io_context& io, ControlSettings settings)
    : settings_{std::move(settings)}, server_{io, {}, [] { return memory_is_left(request_memory); }}, again_{io, [this] {
                                                                                                                 try_again();
                                                                                                             }} {
    server_.keep_large_bodies([&io] { return std::make_unique<FileKeeper>(io); });
}

void ControlDoor::add_login_route() {
    routes().add({"POST", "/login", http::Access::open, "takes a token as {\"token\": ...}, and gives a browser a cookie for it",
                  [this](const http::Request& request) { return login(server_.admission(), request, ano::Clock::now()); }});
}

bool ControlDoor::open() {
    if (!open_local()) return false;
    if (settings_.http) open_network();
    if (awaits_local_ || awaits_network_) again_.start(retry);
    return true;
}

void ControlDoor::finish(Duration patience) {
    again_.stop();
    server_.finish(patience);
}

void ControlDoor::close() {
    again_.stop();
    server_.stop();
}

bool ControlDoor::open_local() {
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

void ControlDoor::open_network() {
    if (!prepare_network()) return;
    awaits_network_ = true;
    try_network();
}

// Without tokens or certificate it stays closed: access without protection would be worse than no access.
bool ControlDoor::shut(std::string why) {
    log_error("control.http stays shut: {}", why);
    network_door_.state = NetworkDoor::State::shut;
    network_door_.error = std::move(why);
    return false;
}

bool ControlDoor::prepare_network() {
    network_ = {settings_.http->address.text(), settings_.http->port};
    if (!settings_.http->interface.empty()) network_.address += "%" + settings_.http->interface;
    network_.needs_token = network_needs_token(network_.address, ::geteuid());
    network_door_.address = network_.address;
    network_door_.port = network_.port;
    network_door_.needs_token = network_.needs_token;
    network_door_.hosts = settings_.hosts;
    http::AdmissionRules rules{{},
                               host_name(),
                               settings_.hosts,
                               settings_.origins,
                               {"/", "/foxglove"},
                               {foxglove::subprotocols.begin(), foxglove::subprotocols.end()}};
    if ((network_.needs_token || !settings_.token_file.empty()) && !prepare_tokens(rules)) return false;
    server_.admission().set(std::move(rules));
    if (settings_.tls.key.empty()) return true;
    auto tls = http::Tls::load(settings_.tls.certificate, settings_.tls.key);
    if (!tls) return shut("control.tls: " + tls.error());
    network_.tls = std::move(*tls);
    network_door_.is_encrypted = true;
    network_door_.certificate = whole_path(settings_.tls.certificate);
    return true;
}

bool ControlDoor::prepare_tokens(http::AdmissionRules& rules) {
    const std::string folder = state_folder();
    if (settings_.token_file.empty() && folder.empty()) return shut("no folder for the tokens; give control.token_file");
    const std::string file = settings_.token_file.empty() ? folder + "/token" : settings_.token_file;
    auto tokens = http::read_or_make_tokens(file);
    if (!tokens) return shut("control.token_file: " + tokens.error());
    rules.tokens = std::move(*tokens);
    network_door_.token_file = whole_path(file);
    log_info("control.http: the tokens are in {}", file);
    return true;
}

void ControlDoor::try_again() {
    if (awaits_local_) try_local();
    if (awaits_network_) try_network();
    if (!awaits_local_ && !awaits_network_) again_.stop();
}

// The program that has the socket may end; then this one takes its place.
void ControlDoor::try_local() {
    const http::Server::Outcome outcome = server_.start(socket_);
    if (!outcome.error.empty()) return;
    awaits_local_ = false;
    if (!outcome.notice.empty()) log_info("{}", outcome.notice);
    log_info("{}: up", socket_);
}

void ControlDoor::try_network() {
    const auto port = server_.start(network_);
    if (!port) {
        if (port.error() != network_door_.error) log_warning("control.http: {}; waiting for it", port.error());
        network_door_.state = NetworkDoor::State::waiting;
        network_door_.error = port.error();
        return;
    }
    awaits_network_ = false;
    network_door_.state = NetworkDoor::State::up;
    network_door_.error.clear();
    network_door_.port = *port;
    Endpoint where = *settings_.http;
    where.port = *port;
    log_info("{}{}: up", network_.tls ? "https://" : "http://", where.text());
}

}    // namespace anogate
