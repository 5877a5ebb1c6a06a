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

/// One request. Flow: put() the received bytes, then again what it did not take together with more, until is_done() or fault().
class RequestReader {
public:
    /// Called with the head of a request: the maximum size of its body, instead of RequestLimits::body. std::nullopt: the body is not
    /// read; the caller must answer with the reason. What it adds to the head is in what take() returns.
    using BodyLimit = std::function<std::optional<std::uint64_t>(Request& head)>;

    explicit RequestReader(const RequestLimits& limits, BodyLimit body_limit = {});
    RequestReader(RequestReader&&) noexcept;
    RequestReader& operator=(RequestReader&&) noexcept;
    ~RequestReader();

    /// Takes what it can from the front of `bytes` and returns how much; the caller passes the rest again.
    std::size_t put(std::string_view bytes);
    bool is_done() const;
    /// Bytes of the body that have come and were not taken yet; a large body is taken in parts.
    std::size_t body_size() const;
    std::string take_body();

    /// Why this is not a valid request.
    struct Fault {
        unsigned status;
        std::string words;
    };
    const std::optional<Fault>& fault() const noexcept { return fault_; }

    /// The request, once is_done(), with the part of its body that was not taken.
    Request take();

private:
    struct Parser;
    std::size_t put_header(std::string_view bytes);
    Request read_head() const;

    RequestLimits limits_;
    BodyLimit body_limit_;
    std::unique_ptr<Parser> parser_;
    Request head_;    // once it is here
    std::optional<Fault> fault_;
};

}    // namespace anogate::http
