// Accepted connections of the network whose client has sent nothing yet. Many may wait here and cost little; only who has sent something
// gets a place at the server.
#pragma once
#include <ano/time.hpp>
#include <http/asio.hpp>
#include <http/stream.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

namespace anogate::http {

/// Clients that waited, and were closed for others.
struct GaveWay {
    std::uint64_t count = 0;
    ano::TimePoint last{};
};

class Lobby {
public:
    static constexpr std::size_t places = 256;
    using HasPlace = std::function<bool()>;
    using Admit = std::function<void(Socket socket)>;

    /// `admit` is called for a client that has sent something, when `has_place` returns true; it may throw std::bad_alloc: the connection is
    /// closed then. Whoever sends nothing for `patience` is closed. `gave_way` is counted in.
    Lobby(asio::io_context& io, bool is_encrypted, ano::Duration patience, GaveWay& gave_way, HasPlace has_place, Admit admit);
    ~Lobby();
    Lobby(const Lobby&) = delete;
    Lobby& operator=(const Lobby&) = delete;

    /// `party`: see WaitingConnection. If there are too many, or too few descriptors, one of the party with most of them gives way.
    void add(Socket socket, std::uint64_t party, bool goes_first);
    /// Closes one, so that there is a descriptor. False: nobody is here.
    bool give_way();

private:
    struct State;
    std::shared_ptr<State> state_;
};

/// The client has closed the connection, and left no request. One of TLS that sends nothing more gets no answer in any case.
bool is_gone(Socket& socket, bool is_encrypted = false) noexcept;

}    // namespace anogate::http
