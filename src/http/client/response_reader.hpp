// Parses an HTTP response from bytes as they arrive.
#pragma once
#include <http/request.hpp>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

/// One response. Flow: put() the received bytes, then the bytes that it did not consume together with more, and end() at the end
/// of the connection, until is_done() or fault(). The body is taken in parts as they arrive; the caller limits its size.
class ResponseReader {
public:
    /// `max_header`: bytes, including the status line. It also limits the bytes between two chunks of a body.
    explicit ResponseReader(std::uint32_t max_header = 16 * 1024);
    ResponseReader(ResponseReader&&) noexcept;
    ResponseReader& operator=(ResponseReader&&) noexcept;
    ~ResponseReader();

    /// Consumes bytes from the front of `bytes` and returns their number; the caller passes the rest again.
    std::size_t put(std::string_view bytes);
    /// To be called when the connection has ended: completes a body without a length.
    void end();

    bool has_head() const;
    bool is_done() const;
    /// Why this is not a valid response; empty: no error.
    const std::string& fault() const noexcept { return fault_; }

    /// Valid once has_head().
    unsigned status() const;
    std::vector<Field> headers() const;
    /// The part of the body that was received since the last call.
    std::string pop_body();

private:
    struct Parser;
    std::uint32_t max_header_;
    std::unique_ptr<Parser> parser_;
    std::string fault_;
};

}    // namespace anogate::http
