// A response out of bytes as they come.
#pragma once
#include <http/request.hpp>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

/// One response. Flow: put() what came, again with what it left and more, and end() when nothing more comes, until is_done() or
/// fault(). The body is taken in parts, as it comes: its size is bounded by who takes it.
class ResponseReader {
public:
    /// `max_header` in bytes, with the status line. It also bounds what stands between two parts of a body.
    explicit ResponseReader(std::uint32_t max_header = 16 * 1024);
    ResponseReader(ResponseReader&&) noexcept;
    ResponseReader& operator=(ResponseReader&&) noexcept;
    ~ResponseReader();

    /// Takes what it can from the front of `bytes`, and says how much that was: what it left comes again.
    std::size_t put(std::string_view bytes);
    /// The connection has ended: so does a body whose length was not told.
    void end();

    bool has_head() const;
    bool is_done() const;
    /// Why it will not become a response; empty: it may.
    const std::string& fault() const noexcept { return fault_; }

    /// Once has_head().
    unsigned status() const;
    std::vector<Field> headers() const;
    /// What came of the body since the last call.
    std::string take_body();

private:
    struct Parser;
    std::uint32_t max_header_;
    std::unique_ptr<Parser> parser_;
    std::string fault_;
};

}    // namespace anogate::http
