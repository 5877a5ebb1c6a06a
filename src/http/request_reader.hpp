// Parses HTTP requests from bytes as they arrive.
#pragma once
#include <http/request.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace anogate::http {

struct RequestLimits {
    std::uint32_t header = 8 * 1024;    // bytes, including the request line
    std::uint64_t body = 64 * 1024;
};

/// One request. Flow: put() the received bytes, then the bytes that it did not consume together with more, until is_done() or
/// fault().
class RequestReader {
public:
    /// Called with the head of a request. Returns the maximum size of its body, instead of RequestLimits::body. std::nullopt: the
    /// body is not read; the caller must send a response with the reason. Fields that it sets in the head are in the result of
    /// take().
    using BodyLimit = std::function<std::optional<std::uint64_t>(Request& head)>;

    explicit RequestReader(const RequestLimits& limits, BodyLimit body_limit = {});
    RequestReader(RequestReader&&) noexcept;
    RequestReader& operator=(RequestReader&&) noexcept;
    ~RequestReader();

    /// Consumes bytes from the front of `bytes` and returns their number; the caller passes the rest again.
    std::size_t put(std::string_view bytes);
    bool is_done() const;
    /// Bytes of the body that were received and not yet returned by pop_body(); a large body is taken in parts.
    std::size_t body_size() const;
    std::string pop_body();

    /// Why this is not a valid request.
    struct Fault {
        unsigned status;
        std::string words;
    };
    const std::optional<Fault>& fault() const noexcept { return fault_; }

    /// The request, once is_done(), with the part of its body that was not taken.
    Request pop_request();

private:
    struct Parser;
    std::size_t feed_header(std::string_view bytes);
    Request read_head() const;

    RequestLimits limits_;
    BodyLimit body_limit_;
    std::unique_ptr<Parser> parser_;
    Request head_;    // once it was received
    std::optional<Fault> fault_;
};

}    // namespace anogate::http
