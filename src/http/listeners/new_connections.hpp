// Accepted network connections whose client has sent nothing yet. They need little memory, so many can wait here. A connection
// gets one of the server's places only after its client has sent something.
#pragma once
#include <ano/time.hpp>
#include <http/asio.hpp>
#include <http/stream.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>

namespace anogate::http {

/// Counts waiting connections that were closed to make room for others.
struct EvictionCounter {
    std::uint64_t count = 0;
    ano::TimePoint last{};
};

class NewConnections {
public:
    static constexpr std::size_t places = 256;
    using HasPlace = std::function<bool()>;
    using Admit = std::function<void(Socket socket)>;

    /// Calls `admit` for a connection whose client has sent something, when `has_place` returns true. If `admit` throws
    /// std::bad_alloc, the connection is closed. A connection that is silent for `patience` is closed. Counts in `evicted`.
    NewConnections(asio::io_context& io, bool is_encrypted, ano::Duration patience, EvictionCounter& evicted, HasPlace has_place,
                   Admit admit);
    ~NewConnections();
    NewConnections(const NewConnections&) = delete;
    NewConnections& operator=(const NewConnections&) = delete;

    /// `client_id`: see WaitingConnection. If too many wait, or too few descriptors are left, one of the party with most of them is closed.
    void add(Socket socket, std::uint64_t client_id, bool has_priority);
    /// Closes one connection, to free a descriptor. False: none waits.
    bool evict_one();

private:
    struct State;
    std::shared_ptr<State> state_;
};

}    // namespace anogate::http
