#include <link/asio.hpp>

#include <http/request_reader.hpp>

#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>

#include <utility>

namespace anogate::http {
namespace {

namespace beast = boost::beast::http;

std::string text(boost::beast::string_view view) { return {view.data(), view.size()}; }

RequestReader::Fault fault_of(const error_code& ec, const RequestLimits& limits) {
    if (ec == beast::error::header_limit)
        return {431, "the header of a request has at most " + std::to_string(limits.header) + " bytes"};
    if (ec == beast::error::body_limit)
        return {413, "the body of a request has at most " + std::to_string(limits.body) + " bytes"};
    if (ec == beast::error::bad_version) return {400, "this is not a request of HTTP/1.0 or HTTP/1.1"};
    return {400, "this is not an HTTP request: " + ec.message()};
}

}    // namespace

struct RequestReader::Parser : beast::request_parser<beast::string_body> {};

RequestReader::RequestReader(const RequestLimits& limits) : limits_{limits}, parser_{std::make_unique<Parser>()} {
    parser_->header_limit(limits.header);
    parser_->body_limit(limits.body);
    parser_->eager(true);
}
RequestReader::RequestReader(RequestReader&&) noexcept = default;
RequestReader& RequestReader::operator=(RequestReader&&) noexcept = default;
RequestReader::~RequestReader() = default;

std::size_t RequestReader::put(std::string_view bytes) {
    error_code ec;
    const std::size_t used = parser_->put(boost::asio::buffer(bytes.data(), bytes.size()), ec);
    if (ec && ec != beast::error::need_more) fault_ = fault_of(ec, limits_);
    return used;
}

bool RequestReader::is_done() const { return parser_->is_done(); }

Request RequestReader::take() {
    Request request;
    request.keep_alive = parser_->get().keep_alive();
    auto message = parser_->release();
    request.method = text(message.method_string());
    request.target = text(message.target());
    request.version = message.version() == 10 ? 10 : 11;
    for (const auto& field : message) request.headers.push_back({text(field.name_string()), text(field.value())});
    request.body = std::move(message.body());
    return request;
}

}    // namespace anogate::http
