// The doors of the control interface: its Unix socket, and TCP where that is asked for.
#pragma once
#include <daemon/network_door.hpp>
#include <daemon/ticker.hpp>
#include <gateway/settings.hpp>
#include <http/server.hpp>

#include <sys/types.h>

#include <string>

namespace anogate {

/// Whether a client of TCP at `address` needs a token: no where `user` started the gateway for himself and nobody comes from elsewhere.
bool network_needs_token(const std::string& address, uid_t user);

/// What can't be had now is tried again: a path or a port that another program has, an address that is not there yet.
class ControlDoor {
public:
    ControlDoor(asio::io_context& io, ControlSettings settings);

    http::Routes& routes() noexcept { return server_.routes(); }
    void add_login_route();
    /// Reads tokens and certificate. False: there can be no socket at the path that was asked for, which was told; of TCP it is
    /// told, and that door stays shut.
    bool open();
    /// Nobody is heard any more; what is being answered is answered to its end, or for `patience`.
    void finish(Duration patience);
    /// At once.
    void close();

    /// How it is with that of TCP just now.
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

    const ControlSettings settings_;    // of the start: what is changed later counts from the next start on
    http::Server server_;
    Ticker again_;
    std::string socket_;
    bool awaits_local_ = false, awaits_network_ = false;
    http::Server::Network network_;
    NetworkDoor network_door_;
};

}    // namespace anogate
