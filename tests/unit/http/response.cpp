#include <http/response.hpp>

#include <gtest/gtest.h>

namespace anogate::http::response_tests {
namespace {

class Parts : public Producer {
public:
    Next next(std::string&) override { return Next::end; }
};

Response with_body(std::string body) {
    Response response;
    response.body = std::move(body);
    return response;
}

TEST(ResponseHead, contains_the_length_of_the_body) {
    EXPECT_EQ(head_of(with_body("{}"), {}),
              "HTTP/1.1 200 OK\r\nContent-Type: application/json\r\nServer: anogate\r\nContent-Length: 2\r\n\r\n");
}

TEST(ResponseHead, contains_a_connection_header_only_if_it_differs_from_the_default) {
    const auto line = [](unsigned version, bool keep_alive) {
        const std::string head = head_of({}, {version, keep_alive});
        const auto at = head.find("Connection: ");
        return at == head.npos ? "" : head.substr(at + 12, head.find('\r', at) - at - 12);
    };
    EXPECT_EQ(line(11, true), "");
    EXPECT_EQ(line(11, false), "close");
    EXPECT_EQ(line(10, true), "keep-alive");
    EXPECT_EQ(line(10, false), "");
}

TEST(ResponseHead, of_a_stream_has_no_length) {
    Response response;
    response.producer = std::make_unique<Parts>();
    EXPECT_NE(head_of(response, {.chunked = true}).find("\r\nTransfer-Encoding: chunked\r\n"), std::string::npos);
    EXPECT_EQ(head_of(response, {.chunked = true}).find("Content-Length"), std::string::npos);
    EXPECT_EQ(head_of(response, {10, false}).find("Content-Length"), std::string::npos);
}

TEST(ResponseHead, of_a_stream_of_known_length_contains_the_length) {
    Response response;
    response.producer = std::make_unique<Parts>();
    response.length = 1234;
    EXPECT_NE(head_of(response, {}).find("\r\nContent-Length: 1234\r\n"), std::string::npos);
}

TEST(ResponseError, is_valid_json_whatever_text_it_quotes) {
    EXPECT_EQ(error(404, "no '\"' or \\ here").body,
              "{\"error\": \"no '\\\"' or \\\\ here\", \"error_id\": \"other\", \"error_args\": {\"text\": \"no '\\\"' or \\\\ "
              "here\"}, "
              "\"what\": \"unknown\"}\n");
    EXPECT_EQ(error(400, "\n\x1b\xff").body,
              "{\"error\": \"???\", \"error_id\": \"other\", \"error_args\": {\"text\": \"???\"}, \"what\": \"invalid\"}\n");
}

TEST(ResponseError, of_a_busy_server_contains_retry_after) {
    const std::string words = final_text(try_again("not now")), body = error(503, "not now").body;
    EXPECT_EQ(words,
              "HTTP/1.1 503 Service Unavailable\r\nRetry-After: 1\r\nContent-Type: application/json\r\nServer: anogate\r\n"
              "Connection: close\r\nContent-Length: " +
                  std::to_string(body.size()) + "\r\n\r\n" + body);
}

TEST(ResponseChunk, starts_with_its_length_in_hex) {
    EXPECT_EQ(chunk("x"), "1\r\nx\r\n");
    EXPECT_EQ(chunk(std::string(300, 'x')), "12c\r\n" + std::string(300, 'x') + "\r\n");
}

Request upgrade() {
    Request request;
    request.method = "GET";
    request.headers = {{"connection", "keep-alive, Upgrade"},
                       {"Upgrade", "WebSocket"},
                       {"Sec-WebSocket-Version", "13"},
                       {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="}};
    return request;
}

TEST(WebSocketRequest, is_a_get_with_upgrade_headers) {
    EXPECT_TRUE(is_web_socket(upgrade()));
    EXPECT_EQ(web_socket_fault(upgrade()).status, 200u);
    for (const auto change :
         {+[](Request& r) { r.method = "POST"; }, +[](Request& r) { r.version = 10; },
          +[](Request& r) { r.headers[0].value = "upgraded"; }, +[](Request& r) { r.headers[1].value = "h2c"; }}) {
        Request request = upgrade();
        change(request);
        EXPECT_FALSE(is_web_socket(request));
        EXPECT_EQ(web_socket_fault(request).status, 426u);
    }
}

TEST(WebSocketRequest, of_another_version_or_without_a_key_is_rejected) {
    Request old = upgrade(), keyless = upgrade();
    old.headers[2].value = "8";
    keyless.headers[3].value = "short";
    EXPECT_EQ(web_socket_fault(old).status, 426u);
    EXPECT_EQ(web_socket_fault(old).headers, (std::vector<Field>{{"Sec-WebSocket-Version", "13"}}));
    EXPECT_EQ(web_socket_fault(keyless).status, 400u);
}

TEST(RequestFields, are_found_by_name) {
    Request request = upgrade();
    request.parameters = {{"name", "fc"}};
    request.query = {{"dry_run", ""}, {"n", "1"}, {"n", "2"}};
    EXPECT_EQ(request.parameter("name"), "fc");
    EXPECT_EQ(request.parameter("other"), "");
    EXPECT_EQ(request.query_value("dry_run"), "");
    EXPECT_EQ(request.query_value("n"), "1");
    EXPECT_EQ(request.query_value("N"), std::nullopt);
    EXPECT_EQ(request.header("UPGRADE"), "WebSocket");
    EXPECT_EQ(request.header("Host"), "");
}

}    // namespace
}    // namespace anogate::http::response_tests
