// The listening sockets of the control interface: its Unix socket, and TCP when that is configured.
#pragma once
#include <daemon/network_door.hpp>
#include <daemon/ticker.hpp>
#include <gateway/settings.hpp>
#include <http/server.hpp>

#include <sys/types.h>

#include <string>

namespace anogate {

/// Whether a TCP client at `address` needs a token. Not when an ordinary `user` started the gateway and only this machine can connect.
bool network_needs_token(const std::string& address, uid_t user);

/// Tries again when a path or port is in use by another program, or an address is not available yet.
class ControlDoor {
public:
    ControlDoor(asio::io_context& io, ControlSettings settings);

    http::Routes& routes() noexcept { return server_.routes(); }
    void add_login_route();
    /// Reads tokens and certificate. False: the Unix socket can't be made at the configured path; the reason was logged. Faults of TCP are
    /// logged only, and TCP stays closed.
    bool open();
    /// Accepts no more requests. Answers that are being sent are completed, for at most `patience`; those that are not made yet are waited
    /// for until no_more_answers().
    void finish(Duration patience);
    void no_more_answers() { server_.no_more_answers(); }
    /// Closes everything at once.
    void close();

    /// The present state of the TCP access.
    const NetworkDoor& network_door() const noexcept { return network_door_; }

private:
    bool open_local();
    void open_network();
    bool prepare_network();
    bool prepare_tokens(http::AdmissionRules& rules);
    bool shut(std::string why);
    void try_again();
    void try_local();
    void try_network();

    const ControlSettings settings_;    // as of the start: later changes take effect at the next start
    http::Server server_;
    Ticker again_;
    std::string socket_;
    bool awaits_local_ = false, awaits_network_ = false;
    http::Server::Network network_;
    NetworkDoor network_door_;
};

}    // namespace anogate
