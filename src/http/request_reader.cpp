#include <sys/asio.hpp>

#include <http/growing_body.hpp>
#include <http/request_reader.hpp>

#include <boost/beast/http/parser.hpp>

#include <functional>
#include <iterator>
#include <limits>
#include <utility>

namespace anogate::http {
namespace {

namespace beast = boost::beast::http;

constexpr std::string_view end_of_fields = "\r\n\r\n";
constexpr std::string_view min_chunks = "0\r\n\r\n";

std::string text(boost::beast::string_view view) { return {view.data(), view.size()}; }

RequestReader::Fault fault_of(const error_code& ec, const RequestLimits& limits) {
    if (ec == beast::error::header_limit)
        return {431, "the header of a request has at most " + std::to_string(limits.header) + " bytes"};
    if (ec == beast::error::body_limit)
        return {413, "the body of a request has at most " + std::to_string(limits.body) + " bytes"};
    if (ec == beast::error::bad_version) return {400, "this is not a request of HTTP/1.0 or HTTP/1.1"};
    return {400, "this is not an HTTP request: " + ec.message()};
}

RequestReader::Fault fault_of_chunk(const RequestLimits& limits) {
    return {431, "the chunk lines and the trailer have at most " + std::to_string(limits.header) + " bytes"};
}

}    // namespace

// Trailer fields after a chunked body are ignored, because Beast 1.74 fails an assertion at some malformed ones. So the parser is
// stopped at the last chunk and gets it when everything up to its end was received.
struct RequestReader::Parser : beast::request_parser<GrowingBody> {
    Parser() { on_chunk_header(stop_at_the_last); }

    std::function<void(std::uint64_t, boost::beast::string_view, error_code&)> stop_at_the_last =
        [this](std::uint64_t size, boost::beast::string_view, error_code& ec) {
            if (size > max_body || max_body - size < in_chunks) ec = beast::error::body_limit;
            in_chunks += size;
            if (size > 0 || ec) return;
            at_the_last = true;
            ec = beast::error::end_of_stream;
        };
    bool at_the_last = false;
    std::uint64_t max_body = 0;     // bytes
    std::uint64_t in_chunks = 0;    // so far

    /// Whether the end of the body or its encoding is unknown: the body must not be mistaken for the next request (RFC 9112,
    /// 6.3), nor a compressed body for a plain one.
    bool length_is_unknown() {
        const auto& message = get();
        const auto codings = message.count(beast::field::transfer_encoding);
        if (codings == 0) return false;
        const bool is_plain = codings == 1 && boost::beast::iequals(message[beast::field::transfer_encoding], "chunked");
        return !is_plain || !chunked() || message.version() == 10;
    }
};

// The limit of the body is known only after the header, but Beast needs one before: none is set.
RequestReader::RequestReader(const RequestLimits& limits, BodyLimit body_limit)
    : limits_{limits}, body_limit_{std::move(body_limit)}, parser_{std::make_unique<Parser>()} {
    parser_->header_limit(limits.header);
    parser_->body_limit(std::numeric_limits<std::uint64_t>::max());
}
RequestReader::RequestReader(RequestReader&&) noexcept = default;
RequestReader& RequestReader::operator=(RequestReader&&) noexcept = default;
RequestReader::~RequestReader() = default;

std::size_t RequestReader::feed_header(std::string_view bytes) {
    error_code ec;
    const std::size_t used = parser_->put(boost::asio::buffer(bytes.data(), bytes.size()), ec);
    if (ec && ec != beast::error::need_more) fault_ = fault_of(ec, limits_);
    if (fault_ || !parser_->is_header_done()) return used;
    if (parser_->length_is_unknown()) {
        fault_ = {400, "the only Transfer-Encoding is chunked, in HTTP/1.1"};
        return used;
    }
    if (parser_->get().count(beast::field::content_type) > 1) {
        fault_ = {400, "more than one Content-Type header"};    // with two, programs disagree on the type of the body
        return used;
    }
    head_ = read_head();
    if (body_limit_) {
        head_.body_length = parser_->chunked() ? in_chunks : parser_->content_length().value_or(0);
        const auto max_body = body_limit_(head_);
        head_.body_length = 0;
        if (!max_body) {
            fault_ = {403, "this path accepts no such body"};
            return used;
        }
        limits_.body = *max_body;
    }
    parser_->max_body = limits_.body;
    if (parser_->content_length().value_or(0) > limits_.body) fault_ = fault_of(beast::error::body_limit, limits_);
    parser_->eager(true);
    return used;
}

std::size_t RequestReader::put(std::string_view bytes) {
    if (!parser_->is_header_done()) {
        const std::size_t used = feed_header(bytes);
        const bool goes_on = !fault_ && parser_->is_header_done() && !parser_->is_done() && used < bytes.size();
        return goes_on ? used + put(bytes.substr(used)) : used;
    }
    // Another assertion of Beast 1.74 fails if only four bytes of a body with just the last chunk were received.
    if (parser_->chunked() && bytes.starts_with('0') && bytes.size() < min_chunks.size()) return 0;
    error_code ec;
    const std::size_t used = parser_->put(boost::asio::buffer(bytes.data(), bytes.size()), ec);
    if (parser_->at_the_last) return bytes.find(end_of_fields, used) + end_of_fields.size();
    if (ec && ec != beast::error::need_more) fault_ = fault_of(ec, limits_);
    else if (!parser_->is_done() && bytes.size() - used > limits_.header) fault_ = fault_of_chunk(limits_);
    return used;
}

std::size_t RequestReader::body_size() const { return parser_->get().body().size(); }

std::string RequestReader::pop_body() { return std::exchange(parser_->get().body(), {}); }

bool RequestReader::is_done() const { return parser_->is_done() || parser_->at_the_last; }

Request RequestReader::read_head() const {
    const auto& message = parser_->get();
    Request request;
    request.keep_alive = message.keep_alive();
    request.method = text(message.method_string());
    request.target = text(message.target());
    request.version = message.version() == 10 ? 10 : 11;
    request.headers.reserve(static_cast<std::size_t>(std::distance(message.begin(), message.end())));
    for (const auto& field : message) request.headers.push_back({text(field.name_string()), text(field.value())});
    return request;
}

Request RequestReader::pop_request() {
    Request request = std::move(head_);
    request.body = pop_body();
    return request;
}

}    // namespace anogate::http
