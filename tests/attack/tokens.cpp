// Tokens, cookies, and the requests that browsers send for pages of other sites.
#include <support/http.hpp>
#include <support/token_gateway.hpp>
#include <sys/unique_fd.hpp>

#include <sys/socket.h>

#include <filesystem>

namespace tokens_tests {
namespace {

using namespace support;

using Tokens = TokenGateway;

std::string cookie_in(const std::string& answer) {
    const std::string name = "Set-Cookie: ";
    const auto at = answer.find(name);
    if (at == std::string::npos) return {};
    return answer.substr(at + name.size(), answer.find("\r\n", at) - at - name.size());
}
std::string sent_back(const std::string& set_cookie) { return "Cookie: " + set_cookie.substr(0, set_cookie.find(';')) + "\r\n"; }
const std::string login = R"({"token": ")" + view_token + "\"}";

TEST_F(Tokens, a_correct_one_is_accepted_after_any_number_of_wrong_ones) {
    for (int i = 0; i < 10; ++i) EXPECT_EQ(code("GET /status", bearer("guess" + std::to_string(i))), "401");
    EXPECT_EQ(code("GET /status", bearer("guess")), "429") << "who guesses is slowed down";
    EXPECT_EQ(code("GET /status", bearer(control_token)), "200");
    EXPECT_EQ(code("POST /gpio", bearer(control_token), "{}"), "404") << "a command is looked at: there is no such line";
    EXPECT_EQ(code("POST /login", {}, login), "200");
    EXPECT_EQ(daemon.status().at("http").at("wrong_tokens"), 11);
    EXPECT_NE(http(socket, "GET /metrics HTTP/1.0\r\n\r\n").find("anogate_wrong_tokens_total 11"), std::string::npos);
    const std::string line = "ten wrong tokens from 127.0.0.1";
    ASSERT_TRUE(daemon.until_says(line)) << daemon.output();
    for (int i = 0; i < 20; ++i) code("GET /status", bearer("guess"));
    code_at_socket("GET /status");
    EXPECT_EQ(daemon.output().find(line), daemon.output().rfind(line)) << "told once: " << daemon.output();
}

TEST_F(Tokens, a_stale_cookie_locks_nobody_out) {
    const std::string name = [&] {
        const std::string cookie = cookie_in(http(port, request("POST /login", {}, login)));
        return cookie.substr(0, cookie.find('='));
    }();
    const std::string stale = "Cookie: " + name + "=" + std::string(30, 'x') + "\r\n";
    const std::string page = "Accept: text/html\r\nAccept-Encoding: gzip\r\n";
    for (int i = 0; i < 20; ++i) {
        const std::string shown = http(port, request("GET /", page + stale));
        EXPECT_NE(shown.find("Set-Cookie: " + name + "=;"), std::string::npos) << "it is cleared: " << shown.substr(0, 400);
        EXPECT_EQ(code_of(shown), code("GET /", page)) << "as without one";
    }
    EXPECT_EQ(code("POST /login", stale, login), "200");
    EXPECT_EQ(code("GET /status", stale), "401") << "the same wrong token again is no further guess";
    EXPECT_EQ(daemon.status().at("http").at("wrong_tokens"), 1);
    EXPECT_EQ(daemon.status().at("http").at("guessing_clients"), 0);
    EXPECT_EQ(code("GET /status", stale + bearer(view_token)), "200");
    const std::string both = name + "=" + std::string(30, 'x') + "; " + name + "=" + view_token;
    EXPECT_EQ(code("GET /status", "Cookie: " + both + "\r\n"), "200") << "any right one counts";
    EXPECT_EQ(code("GET /status", stale + "Cookie: " + name + "=" + view_token + "\r\n"), "200");
}

TEST_F(Tokens, of_others_that_are_wrong_do_not_keep_a_stale_cookie_from_paths_that_need_no_token) {
    const std::string cookie = cookie_in(http(port, request("POST /login", {}, login)));
    const std::string stale = "Cookie: " + cookie.substr(0, cookie.find('=')) + "=stale\r\n";
    const std::string html = "Accept: text/html\r\nAccept-Encoding: gzip\r\n", any = "Accept: */*\r\n";
    for (int i = 0; i < 11; ++i) code("GET /status", bearer("guess" + std::to_string(i)));
    for (const char* const what : {"GET /", "GET /web/main.js", "GET /nothing"})
        for (const std::string& accepted : {html, any}) EXPECT_EQ(code(what, accepted + stale), code(what, accepted)) << what;
    EXPECT_EQ(code("POST /logout", stale), "200");
    EXPECT_EQ(code("GET /status", stale), "429") << "where a token is needed, a cookie may be a guess";
}

TEST_F(Tokens, guessed_by_cookie_are_slowed_down_as_well) {
    const std::string in = cookie_in(http(port, request("POST /login", {}, login)));
    const std::string name = in.substr(0, in.find('='));
    const auto guess = [&](int i) { return code("GET /status", "Cookie: " + name + "=guess" + std::to_string(i) + "\r\n"); };
    for (int i = 0; i < 10; ++i) EXPECT_EQ(guess(i), "401");
    for (int i = 10; i < 20; ++i) EXPECT_EQ(guess(i), "429");
    EXPECT_EQ(code("GET /status", sent_back(in)), "200") << "a right one never is";
    EXPECT_EQ(daemon.status().at("http").at("wrong_tokens"), 20);
    EXPECT_EQ(daemon.status().at("http").at("guessing_clients"), 1);
}

TEST_F(Tokens, guessed_from_many_addresses_are_counted_and_fill_no_log) {
    for (int client = 1; client <= 40; ++client)
        for (int i = 0; i < 11; ++i)
            ASSERT_NE(http(port, request("GET /status", bearer("guess")), "127.9.0." + std::to_string(client)), "");
    EXPECT_EQ(daemon.status().at("http").at("guessing_clients"), 40);
    EXPECT_NE(http(socket, "GET /metrics HTTP/1.0\r\n\r\n").find("anogate_guessing_clients_total 40"), std::string::npos);
    ASSERT_TRUE(daemon.until_says("others are only counted in this minute")) << daemon.output();
    int lines = 0;
    const std::string said = daemon.output(), line = "ten wrong tokens from";
    for (auto at = said.find(line); at != std::string::npos; at = said.find(line, at + 1)) ++lines;
    EXPECT_EQ(lines, 10);
}

TEST_F(Tokens, signing_out_clears_the_cookie) {
    const std::string in = cookie_in(http(port, request("POST /login", {}, login)));
    EXPECT_NE(in.find("-"), in.rfind("-")) << "its name has an id of the token file: " << in;
    EXPECT_EQ(code("GET /status", sent_back(in)), "200");
    const std::string out = http(port, request("POST /logout", sent_back(in)));
    EXPECT_EQ(code_of(out), "200");
    EXPECT_EQ(cookie_in(out), in.substr(0, in.find('=')) + "=; HttpOnly; SameSite=Strict; Path=/; Max-Age=0");
    const std::string stale = http(port, request("POST /logout", "Cookie: " + in.substr(0, in.find('=')) + "=stale\r\n"));
    EXPECT_EQ(code_of(stale), "200");
    EXPECT_EQ(cookie_in(stale), cookie_in(out));
    EXPECT_EQ(stale.find("Set-Cookie"), stale.rfind("Set-Cookie")) << "once: " << stale;
}

// A viewer can sign in for control: its cookie does not count in that request.
TEST_F(Tokens, a_viewer_can_sign_in_for_control) {
    const std::string in = cookie_in(http(port, request("POST /login", {}, login)));
    const std::string more = http(port, request("POST /login", sent_back(in), R"({"token": ")" + control_token + "\"}"));
    EXPECT_EQ(body_of(more), "{\"access\": \"control\"}\n");
    EXPECT_EQ(code("POST /gpio", sent_back(cookie_in(more)), "{}"), "404") << "there is no such line";
}

using OtherSites = TokenGateway;

TEST_F(OtherSites, start_and_change_nothing) {
    const std::string marked = "Sec-Fetch-Site: cross-site\r\n", token = bearer(control_token);
    for (const std::string& with : {token, std::string{}}) {
        for (const char* const read : {"parameters", "parameters/X", "commands", "waypoints"})
            EXPECT_EQ(code(std::string{"GET /devices/0xDC/"} + read, marked + with), "403") << read << " starts a job";
        EXPECT_EQ(code("POST /send", marked + with, "{}"), "403");
        EXPECT_EQ(code("POST /login", marked + with, login), "403");
        EXPECT_EQ(code("POST /logout", marked + with), "403");
        EXPECT_EQ(code("DELETE /routes/0xDC", marked + with), "403");
    }
    EXPECT_EQ(code("GET /status", marked + token), "200") << "it reads; the other page does not see it";
    EXPECT_EQ(code("POST /send", "Sec-Fetch-Site: same-site\r\n" + token, "{}"), "403");
    EXPECT_EQ(code("POST /gpio", "Sec-Fetch-Site: same-origin\r\n" + token, "{}"), "404");
    EXPECT_EQ(code("POST /gpio", "Sec-Fetch-Site: none\r\n" + token, "{}"), "404");
    EXPECT_EQ(code("GET /status", "Origin: http://evil.example\r\n" + token), "403");
}

TEST_F(OtherSites, start_and_change_nothing_through_a_proxy_at_the_socket_either) {
    const std::string json = "Content-Type: application/json\r\n";
    EXPECT_EQ(code_at_socket("POST /gpio", json + "Origin: http://evil.example\r\n", "{}"), "403");
    EXPECT_EQ(code_at_socket("POST /gpio", json + "Sec-Fetch-Site: cross-site\r\n", "{}"), "403");
    EXPECT_EQ(code_at_socket("GET /devices/0xDC/parameters", "Sec-Fetch-Site: cross-site\r\n"), "403");
    EXPECT_EQ(code_at_socket("POST /gpio", json, "{}"), "404") << "programs are no browsers";
    EXPECT_EQ(code_at_socket("POST /gpio", json + "Sec-Fetch-Site: none\r\nSec-Fetch-Site: cross-site\r\n", "{}"), "403");
    for (const std::string name :
         {"X-Real-IP", "CF-Connecting-IP", "True-Client-IP", "Via", "Forwarded", "X-Forwarded-For", "X-Client-IP",
          "X-Cluster-Client-IP", "X-Original-Forwarded-For", "Fastly-Client-IP", "Fly-Client-IP"})
        EXPECT_EQ(code_at_socket("GET /status", name + ": 1.2.3.4\r\n"), "401") << name << " is of a proxy";
}

TEST_F(OtherSites, and_proxies_can_use_only_chunked_coding_and_query_the_options_of_the_server) {
    const auto sent = [&](const std::string& coding) {
        return code_of(
            http(port, "POST /gpio HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n" +
                           bearer(control_token) + coding + "\r\n2\r\n{}\r\n0\r\n\r\n"));
    };
    EXPECT_EQ(sent("Transfer-Encoding: chunked\r\n"), "404") << "no such line";
    for (const std::string coding : {"gzip, chunked", "identity, chunked", "chunked, chunked", "x", "gzip"})
        EXPECT_EQ(sent("Transfer-Encoding: " + coding + "\r\n"), "400") << coding;
    EXPECT_EQ(sent("Transfer-Encoding: gzip\r\nTransfer-Encoding: chunked\r\n"), "400");
    const std::string options = http(port, request("OPTIONS *"));
    EXPECT_EQ(code_of(options), "200") << options;
    EXPECT_NE(options.find("Allow: "), std::string::npos) << options;
}

class Reloaded : public TokenGateway {
protected:
    std::string reload() { return body_of(http(socket, "POST /reload HTTP/1.0\r\n\r\n")); }
    std::string new_token = "another-token-0123456789";
};

TEST_F(Reloaded, removed_tokens_are_rejected_and_new_ones_accepted) {
    const std::string in = cookie_in(http(port, request("POST /login", {}, login)));
    dir.write("token", "control " + new_token + "\n");
    EXPECT_EQ(code("GET /status", bearer(control_token)), "200") << "nothing was read again";
    reload();
    EXPECT_EQ(code("GET /status", bearer(control_token)), "401");
    EXPECT_EQ(code("GET /status", sent_back(in)), "401") << "a session is its token";
    EXPECT_EQ(code("GET /status", bearer(new_token)), "200");
    EXPECT_EQ(code_at_socket("GET /status", "Via: 1.1 proxy\r\n" + bearer(view_token)), "401");
    std::filesystem::remove(tokens);
    reload();
    EXPECT_EQ(code("GET /status", bearer(new_token)), "401") << "others were made";
    EXPECT_TRUE(std::filesystem::exists(tokens));
}

// The streams of a stolen token end; the others stay.
TEST_F(Reloaded, streams_of_removed_tokens_are_closed) {
    const anogate::UniqueFd gone{connect_tcp(port)}, stays{connect_tcp(port)};
    const auto ask = [&](const anogate::UniqueFd& fd, const std::string& token) {
        const std::string text = "GET /frames HTTP/1.1\r\nHost: localhost\r\nVia: 1.1 test\r\n" + bearer(token) + "\r\n";
        ASSERT_EQ(::send(fd.get(), text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
        char begun[64];
        ASSERT_GT(::recv(fd.get(), begun, sizeof begun, 0), 0);
    };
    ask(gone, view_token);
    ask(stays, control_token);
    dir.write("token", "control " + control_token + "\n");
    reload();
    read_to_end(gone.get());
    char byte;
    EXPECT_EQ(::recv(gone.get(), &byte, 1, MSG_DONTWAIT), 0) << "it was closed";
    while (::recv(stays.get(), &byte, 1, MSG_DONTWAIT) > 0) {}
    EXPECT_EQ(::recv(stays.get(), &byte, 1, MSG_DONTWAIT), -1) << "it is open";
}

TEST_F(Reloaded, a_reload_request_with_a_token_that_it_removes_still_gets_its_response) {
    dir.write("token", "control " + new_token + "\n");
    EXPECT_EQ(code("POST /reload", bearer(control_token)), "200");
    EXPECT_EQ(code("POST /reload", bearer(control_token)), "401");
}

TEST_F(Reloaded, files_with_other_content_are_named) {
    const std::string none = R"("files":[])", one = R"("files":[")" + tokens + R"("])";
    EXPECT_NE(reload().find(none), std::string::npos) << reload();
    dir.write("token", "control " + new_token + "\n");
    const std::string would = body_of(http(socket, "POST /reload?dry_run HTTP/1.0\r\n\r\n"));
    EXPECT_NE(would.find(one), std::string::npos) << would;
    EXPECT_EQ(code("GET /status", bearer(control_token)), "200") << "nothing was read again";
    const std::string done = reload();
    EXPECT_NE(done.find(one), std::string::npos) << done;
    EXPECT_NE(done.find(R"("changed":true)"), std::string::npos) << done;
    EXPECT_NE(reload().find(none), std::string::npos);
}

TEST_F(Reloaded, faulty_files_switch_http_off_as_at_the_start) {
    std::filesystem::permissions(tokens, std::filesystem::perms{0644});
    const std::string told = reload();
    EXPECT_NE(told.find("token: every user of this computer can read it"), std::string::npos) << told;
    EXPECT_EQ(daemon.status().at("http").at("state"), "shut");
    EXPECT_EQ(code("GET /status", bearer(control_token)), "") << "nobody listens";
    EXPECT_EQ(code_at_socket("GET /status", "Via: 1.1 proxy\r\n" + bearer(control_token)), "401");
    std::filesystem::permissions(tokens, std::filesystem::perms{0600});
    EXPECT_EQ(reload().find("http_error"), std::string::npos);
    port = daemon.status().at("http").at("port");
    EXPECT_EQ(code("GET /status", bearer(control_token)), "200");
}

}    // namespace
}    // namespace tokens_tests
