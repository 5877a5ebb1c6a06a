#include <http/response.hpp>

#include <array>
#include <cstdio>
#include <utility>

namespace anogate::http {
namespace {

constexpr std::pair<unsigned, std::string_view> reasons[] = {
    {101, "Switching Protocols"},
    {200, "OK"},
    {201, "Created"},
    {202, "Accepted"},
    {204, "No Content"},
    {206, "Partial Content"},
    {303, "See Other"},
    {304, "Not Modified"},
    {400, "Bad Request"},
    {401, "Unauthorized"},
    {403, "Forbidden"},
    {404, "Not Found"},
    {405, "Method Not Allowed"},
    {406, "Not Acceptable"},
    {408, "Request Timeout"},
    {409, "Conflict"},
    {413, "Payload Too Large"},
    {415, "Unsupported Media Type"},
    {416, "Range Not Satisfiable"},
    {422, "Unprocessable Entity"},
    {426, "Upgrade Required"},
    {429, "Too Many Requests"},
    {431, "Request Header Fields Too Large"},
    {500, "Internal Server Error"},
    {502, "Bad Gateway"},
    {503, "Service Unavailable"},
    {504, "Gateway Timeout"},
    {507, "Insufficient Storage"},
};

std::string_view reason(unsigned status) {
    for (const auto& [number, words] : reasons)
        if (number == status) return words;
    return "Unknown Status";
}

// Escapes invalid text: the words may quote any bytes.
std::string json_text(std::string_view words) {
    std::string text = "\"";
    for (const char c : words) {
        if (c == '"' || c == '\\') text += '\\';
        text += static_cast<unsigned char>(c) < ' ' || static_cast<unsigned char>(c) >= 0x7F ? '?' : c;
    }
    return text + '"';
}

// As ano::add_fault() adds it.
std::string id_text(const ano::Fault& fault) {
    const auto value = [](const ano::Fault::Argument& argument) {
        return argument.fault.empty() ? json_text(argument.text) : '{' + id_text(argument.fault.front()) + '}';
    };
    const ano::ArgumentNames names = fault.names();
    std::string text = "\"error_id\": " + json_text(fault.id()) + ", \"error_args\": {";
    for (std::size_t i = 0; i < names.number; ++i)
        text += (i > 0 ? ", " : "") + json_text(names.all[i]) + ": " + value(fault.arguments()[i]);
    return text + '}';
}

void add(std::string& head, std::string_view name, std::string_view value) {
    head.append(name).append(": ").append(value).append("\r\n");
}

}    // namespace

std::string_view what_of(unsigned status) noexcept {
    switch (status) {
    case 401:
    case 403:
    case 502:
    case 507: return "refused";
    case 404: return "unknown";
    case 405:
    case 406:
    case 415:
    case 426: return "unsupported";
    case 409:
    case 429:
    case 503: return "busy";
    case 408:
    case 504: return "timeout";
    default: return "invalid";
    }
}

Response error(unsigned status, const ano::Fault& fault) {
    Response response;
    response.status = status;
    response.body = "{\"error\": " + json_text(fault.text()) + ", " + id_text(fault) +
                    ", \"what\": " + json_text(what_of(status)) + "}\n";
    return response;
}

Response error(const ano::Fault& fault) { return error(fault.status(), fault); }

Response error(unsigned status, std::string_view words) { return error(status, ano::Fault{"other", words}); }

Response needs_token(std::string_view words) {
    Response response = error(401, std::string{words} + "; see the gateway's token file (control.token_file)");
    response.headers.push_back({"WWW-Authenticate", "Bearer realm=\"anogate\""});
    return response;
}

Response try_again(const ano::Fault& fault) {
    Response response = error(503, fault);
    response.headers.push_back(retry_after());
    return response;
}

Response try_again(std::string_view words) { return try_again(ano::Fault{"other", words}); }

Field retry_after() { return {"Retry-After", "1"}; }

Response later(Later promise) {
    Response response;
    response.later = std::move(promise);
    return response;
}

Response web_socket_fault(const Request& request) {
    constexpr std::size_t key_size = 24;    // 16 bytes in base64
    if (!is_web_socket(request)) {
        Response response = error(426, "this path needs a WebSocket");
        response.headers.push_back({"Upgrade", "websocket"});
        return response;
    }
    if (request.header("Sec-WebSocket-Version") != "13") {
        Response response = error(426, "only WebSocket version 13 is supported");
        response.headers.push_back({"Sec-WebSocket-Version", "13"});
        return response;
    }
    if (request.header("Sec-WebSocket-Key").size() != key_size) return error(400, "Sec-WebSocket-Key must be 16 bytes in base64");
    return {};
}

std::string head_of(const Response& response, const Sending& sending) {
    std::string head = sending.version == 10 ? "HTTP/1.0 " : "HTTP/1.1 ";
    head.append(std::to_string(response.status)).append(" ").append(reason(response.status)).append("\r\n");
    for (const Field& field : response.headers) add(head, field.name, field.value);
    if (!response.type.empty()) add(head, "Content-Type", response.type);
    add(head, "Server", "anogate");
    if (sending.version == 10 && sending.keep_alive) add(head, "Connection", "keep-alive");
    if (sending.version != 10 && !sending.keep_alive) add(head, "Connection", "close");
    if (sending.chunked) add(head, "Transfer-Encoding", "chunked");
    else if (!response.producer) add(head, "Content-Length", std::to_string(response.size()));
    else if (response.length) add(head, "Content-Length", std::to_string(*response.length));
    return head + "\r\n";
}

std::string final_text(const Response& response) {
    return head_of(response, {.keep_alive = false}) + response.body + (response.shared ? *response.shared : std::string{});
}

std::string Response::pop_text() {
    std::string text = std::exchange(body, {});
    if (shared) text += *shared;
    return text;
}

std::string chunk(std::string_view part) {
    std::array<char, 20> size{};
    const int digits = std::snprintf(size.data(), size.size(), "%zx\r\n", part.size());
    return std::string{size.data(), static_cast<std::size_t>(digits)}.append(part).append("\r\n");
}

}    // namespace anogate::http
