// The listening sockets of the control interface: its Unix socket, and TCP if configured.
#pragma once
#include <control/sign_in_codes.hpp>
#include <gateway/settings.hpp>
#include <http/server.hpp>
#include <status/listener_info.hpp>
#include <sys/background_task.hpp>
#include <sys/ticker.hpp>

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace anogate {

/// Whether TCP clients need a token if the gateway listens on `address`. No token is needed if an ordinary `user` started the
/// gateway and only this machine can connect.
bool network_needs_token(const std::string& address, uid_t user);

/// Retries while a path or port is in use by another program, or an address is not available yet.
class ControlListeners {
public:
    ControlListeners(asio::io_context& io, ControlSettings settings);

    http::Routes& routes() noexcept { return server_.routes(); }
    void add_login_routes();
    /// Reads tokens and certificate. False: the Unix socket can't be created at the configured path; the reason was logged.
    /// Faults of TCP are only logged, and TCP stays closed.
    bool open();
    /// Accepts no more requests. Completes responses that are being sent, for at most `patience`; waits for responses that are
    /// not ready yet until no_more_answers().
    void finish(Duration patience);
    void no_more_answers() { server_.no_more_answers(); }
    /// Closes everything at once.
    void close();

    /// Receives a fault of the files, or empty, and the files whose content has changed since they were used.
    using Renewed = std::function<void(std::string fault, std::vector<std::string> changed)>;
    /// Reads tokens and certificate again, in a thread, and uses them from then on. If they have a fault, TCP is closed, as at
    /// the start, until they are read again. If the system has no descriptor or memory to read them, the previous ones stay in use.
    /// A dry run only compares them.
    void renew(bool dry_run, const Renewed& done);

    /// Logs once that the certificate is not valid, or not for long. To be called now and then.
    void log_validity();

    /// The present state of the TCP access.
    ListenerInfo listener_info() const {
        ListenerInfo listener = listener_info_;
        listener.wrong_tokens = server_.admission().wrong_tokens();
        if (network_.tls) listener.validity = network_.tls->validity();
        listener.evicted = server_.evicted().count;
        listener.evicted_lately = listener.evicted > 0 && ano::Clock::now() - server_.evicted().last < ListenerInfo::lately;
        listener.guessing_clients = server_.admission().guessing_clients();
        listener.link_code = text(codes_.state(SignInCodes::Form::link, ano::Clock::now()));
        listener.digits_code = text(codes_.state(SignInCodes::Form::digits, ano::Clock::now()));
        return listener;
    }

private:
    bool open_local();
    void open_network();
    struct Files;
    static Files read_files(const ControlSettings& settings, bool needs_token);
    std::vector<std::string> changed_files(const std::map<std::string, std::size_t>& contents) const;
    void name_network();
    bool use(Files files);
    bool shut(std::string why);
    void try_again();
    void try_local();
    void try_network();

    const ControlSettings
        settings_;    // as of the start; only changes in the content of the files take effect before the next start
    http::Server server_;
    Ticker again_;
    BackgroundTask background_task_;
    std::string socket_;
    bool awaits_local_ = false, awaits_network_ = false;
    http::Server::Network network_;
    ListenerInfo listener_info_;
    std::string logged_validity_;    // the last warning; empty: there is none
    std::string token_file_id_{};
    std::map<std::string, std::size_t> contents_;    // of the files in use, by path: a number that differs after a change
    SignInCodes codes_{};
};

}    // namespace anogate
