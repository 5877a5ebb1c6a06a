// Endless answers of lines: NDJSON if the client accepts it, or a WebSocket with one message per line. A line is made only when
// its client can receive it, so that a slow client needs no memory and delays no other client.
#pragma once
#include <http/request.hpp>
#include <http/response.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace anogate {

/// The clients of one stream.
class LineClients {
public:
    bool empty() const noexcept { return wakes_.empty(); }
    /// There may be new lines.
    void wake() const;

private:
    friend class LineClient;
    std::vector<const std::function<void()>*> wakes_;
};

/// The next line of one client, JSON without a line end; empty: none yet.
using NextLine = std::function<std::string()>;

/// Whether the request is for an endless answer.
bool requests_lines(const http::Request& request);
/// `clients` must outlive the answer.
http::Response line_stream(LineClients& clients, NextLine next, const http::Request& request);

}    // namespace anogate
