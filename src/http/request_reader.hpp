// Requests out of bytes as they come.
#pragma once
#include <http/request.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace anogate::http {

struct RequestLimits {
    std::uint32_t header = 8 * 1024;    // bytes, with the request line
    std::uint64_t body = 64 * 1024;
};

/// One request. Flow: put() what came, again with what it left and more, until is_done() or fault().
class RequestReader {
public:
    /// How large the body may be of a request of which all but that is known; in the place of RequestLimits::body. Nothing: none of it is
    /// taken, for a reason that who says so tells. What is added to the head is in what take() gives.
    using BodyLimit = std::function<std::optional<std::uint64_t>(Request& head)>;

    explicit RequestReader(const RequestLimits& limits, BodyLimit body_limit = {});
    RequestReader(RequestReader&&) noexcept;
    RequestReader& operator=(RequestReader&&) noexcept;
    ~RequestReader();

    /// Takes what it can from the front of `bytes`, and says how much that was: what it left comes again.
    std::size_t put(std::string_view bytes);
    bool is_done() const;
    /// Of its body, what has come and was not taken: a large one is taken in parts.
    std::size_t body_size() const;
    std::string take_body();

    /// Why it will not become a request.
    struct Fault {
        unsigned status;
        std::string words;
    };
    const std::optional<Fault>& fault() const noexcept { return fault_; }

    /// Once it is done; with what is left of its body.
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
