#include <sys/asio.hpp>

#include <http/client/response_reader.hpp>
#include <http/growing_body.hpp>

#include <boost/beast/http/parser.hpp>

#include <cstdint>
#include <functional>
#include <limits>
#include <utility>

namespace anogate::http {
namespace {

namespace beast_http = boost::beast::http;

constexpr std::size_t min_last_chunk = 5;    // "0\r\n\r\n"

}    // namespace

// Trailer fields after the last chunk are ignored: Beast 1.74 fails an assertion at some malformed ones.
struct ResponseReader::Parser : beast_http::response_parser<GrowingBody> {
    Parser() { on_chunk_header(stop_at_the_last); }

    std::function<void(std::uint64_t, boost::beast::string_view, error_code&)> stop_at_the_last =
        [this](std::uint64_t size, boost::beast::string_view, error_code& ec) {
            if (size > 0) return;
            at_the_last = true;
            ec = beast_http::error::end_of_stream;
        };
    bool at_the_last = false;
};

ResponseReader::ResponseReader(std::uint32_t max_header) : max_header_{max_header}, parser_{std::make_unique<Parser>()} {
    parser_->header_limit(max_header);
    parser_->body_limit(std::numeric_limits<std::uint64_t>::max());    // without a limit Beast 1.74 refuses any length
    parser_->eager(true);
}
ResponseReader::ResponseReader(ResponseReader&&) noexcept = default;
ResponseReader& ResponseReader::operator=(ResponseReader&&) noexcept = default;
ResponseReader::~ResponseReader() = default;

std::size_t ResponseReader::put(std::string_view bytes) {
    if (is_done() || !fault_.empty()) return 0;
    // Beast 1.74 fails an assertion if only four bytes of a body with just the last chunk were received.
    if (parser_->is_header_done() && parser_->chunked() && bytes.starts_with('0') && bytes.size() < min_last_chunk) return 0;
    error_code ec;
    const std::size_t used = parser_->put(asio::buffer(bytes.data(), bytes.size()), ec);
    if (parser_->at_the_last) return used;
    if (ec && ec != beast_http::error::need_more) fault_ = ec.message();
    else if (!is_done() && bytes.size() - used > max_header_) fault_ = "the line of a chunk is too long";
    return used;
}

void ResponseReader::end() {
    if (is_done() || !fault_.empty()) return;
    error_code ec;
    if (parser_->got_some()) parser_->put_eof(ec);
    else ec = beast_http::error::end_of_stream;
    if (ec) fault_ = ec.message();
}

bool ResponseReader::has_head() const { return parser_->is_header_done(); }
bool ResponseReader::is_done() const { return parser_->is_done() || parser_->at_the_last; }
unsigned ResponseReader::status() const { return parser_->get().result_int(); }

std::vector<Field> ResponseReader::headers() const {
    std::vector<Field> fields;
    for (const auto& field : parser_->get())
        fields.push_back(
            {{field.name_string().data(), field.name_string().size()}, {field.value().data(), field.value().size()}});
    return fields;
}

std::string ResponseReader::pop_body() { return std::exchange(parser_->get().body(), {}); }

}    // namespace anogate::http
