// The end of a connection whose client is told why.
#pragma once
#include <ano/time.hpp>
#include <http/stream.hpp>

#include <memory>
#include <string>

namespace anogate::http {

/// Says its last words. What the client still says is read for a moment and forgotten: were the connection closed before that is read,
/// the client would learn of its end alone. It lives as long as that takes.
class Farewell : public std::enable_shared_from_this<Farewell> {
public:
    Farewell(asio::io_context& io, std::unique_ptr<Stream> stream, std::string words)
        : stream_{std::move(stream)}, words_{std::move(words)}, timer_{io} {}

    void say(ano::Duration moment);
    void close();

private:
    void write();
    void written(error_code ec, std::size_t size);
    void read();
    void heard(error_code ec, std::size_t size);

    std::unique_ptr<Stream> stream_;    // none: closed
    std::string words_;
    asio::steady_timer timer_;
    std::size_t said_ = 0;
    std::size_t heard_ = 0;
};

}    // namespace anogate::http
