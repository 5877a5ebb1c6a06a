// Requests to a running gateway, several at a time.
#pragma once
#include <http/answer.hpp>
#include <http/client/client.hpp>
#include <sys/asio_fwd.hpp>

#include <array>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <string>

namespace anogate {

class GatewayRequests {
public:
    using Done = std::function<void(const http::Outcome&)>;
    static constexpr std::size_t max_running = 8, max_waiting = 64;

    /// `control`: as for GatewaySocket. `program` is shown by the gateway as the client of jobs.
    GatewayRequests(asio::io_context& io, std::string control, std::string program);

    /// Calls `done` from the loop with the response, or with the reason why there is none. False: too many requests wait, and `done`
    /// is not called. `body`: JSON; empty: none. `patience`: until the response is complete; a request that starts a job is
    /// answered at its end.
    bool ask(std::string method, std::string target, std::string body, ano::Duration patience, Done done);

private:
    struct Waiting {
        http::Request request;
        ano::Duration patience;
        Done done;
    };
    void run();

    asio::io_context& io_;
    std::string control_, program_;
    std::deque<Waiting> waiting_;
    std::array<std::unique_ptr<http::Client>, max_running> clients_;    // nullptr: free
};

}    // namespace anogate
