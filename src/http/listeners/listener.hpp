// Accepts connections of one listening socket.
#pragma once
#include <http/asio.hpp>
#include <http/stream.hpp>
#include <sys/unique_fd.hpp>

#include <functional>
#include <memory>

namespace anogate::http {

/// Accepts connections until it is destroyed, for at most 0.5 ms per turn of the loop. Clients that are gone already are not admitted.
class Listener {
public:
    using HasPlace = std::function<bool()>;
    using Admit = std::function<void(Socket socket)>;

    /// `fd` must listen; `family`: AF_UNIX, AF_INET or AF_INET6. While `has_place` returns false, clients wait in the kernel's
    /// queue. If `admit` throws std::bad_alloc, the connection is closed. `admitted_per_turn`: the maximum per turn of the loop.
    Listener(asio::io_context& io, UniqueFd fd, int family, int admitted_per_turn, HasPlace has_place, Admit admit);
    ~Listener();
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

private:
    struct State;
    std::shared_ptr<State> state_;
};

}    // namespace anogate::http
