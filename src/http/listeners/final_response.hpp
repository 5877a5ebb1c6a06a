// Ends a connection with a last response that contains the reason.
#pragma once
#include <ano/time.hpp>
#include <http/stream.hpp>

#include <memory>
#include <string>

namespace anogate::http {

/// Sends the last response, then reads and discards data of the client: if the connection were closed with unread data, the
/// client would get a reset instead of the response. Closes after the `moment` of say(), after 1 MiB, or when the client closes.
/// Lives until then.
class FinalResponse : public std::enable_shared_from_this<FinalResponse> {
public:
    FinalResponse(asio::io_context& io, std::unique_ptr<Stream> stream, std::string words)
        : stream_{std::move(stream)}, words_{std::move(words)}, timer_{io} {}

    void send(ano::Duration moment);
    void close();

private:
    void write();
    void written(error_code ec, std::size_t size);
    void read();
    void heard(error_code ec, std::size_t size);

    std::unique_ptr<Stream> stream_;    // nullptr: closed
    std::string words_;
    asio::steady_timer timer_;
    std::size_t sent_ = 0;
    std::size_t heard_ = 0;
};

}    // namespace anogate::http
