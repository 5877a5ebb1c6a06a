// One-time codes: reused, guessed, expired, and sent by pages of other sites.
#include <control/login_route.hpp>
#include <support/http.hpp>
#include <support/token_gateway.hpp>

#include <nlohmann/json.hpp>

namespace sign_in_codes_tests {
namespace {

using namespace support;
using namespace std::chrono_literals;
using nlohmann::json;

class SignInCodes : public TokenGateway {
protected:
    std::string made(const std::string& wanted) {
        const std::string answer = http(socket, "POST /login/code HTTP/1.0\r\nHost: x\r\nContent-Length: " +
                                                    std::to_string(wanted.size()) + "\r\n\r\n" + wanted);
        return json::parse(body_of(answer), nullptr, false).value("code", answer);
    }
    std::string link() { return made("{}"); }
    std::string digits() { return made(R"({"form": "digits"})"); }
    static std::string body(const std::string& code) { return R"({"code": ")" + code + "\"}"; }
    std::string use(const std::string& code, const std::string& from = "127.0.0.1") {
        return code_of(http(port, request("POST /login", {}, body(code)), from));
    }
    std::string state(const std::string& form) { return daemon.status().at("http").at("codes").at(form); }
    static std::string other_than(const std::string& digits, int i) {
        const std::string text = std::to_string((std::stoi(digits) + 1 + i) % 1'000'000);
        return std::string(6 - text.size(), '0') + text;
    }
};

TEST_F(SignInCodes, sign_in_once) {
    for (const std::string form : {"link", "digits"}) {
        const std::string code = made(R"({"form": ")" + form + "\"}");
        EXPECT_EQ(state(form), "valid");
        const std::string in = http(port, request("POST /login", {}, body(code)));
        EXPECT_EQ(body_of(in), "{\"access\": \"control\"}\n") << in;
        const auto at = in.find("Set-Cookie: ") + 12;
        const std::string cookie = "Cookie: " + in.substr(at, in.find(';', at) - at) + "\r\n";
        EXPECT_EQ(code_of(http(port, request("POST /gpio", cookie, "{}"))), "404") << "it controls: there is no such line";
        EXPECT_EQ(use(code), "401") << "replayed";
        EXPECT_EQ(use(code, "127.9.0.1"), "401") << "replayed from elsewhere";
        EXPECT_EQ(state(form), "used");
        EXPECT_EQ(daemon.output().find(code), std::string::npos) << "the log has no code";
    }
    EXPECT_TRUE(daemon.until_says("127.0.0.1 signed in with a one-time code (control)")) << daemon.output();
}

TEST_F(SignInCodes, for_viewing_do_not_allow_control) {
    const std::string in = http(port, request("POST /login", {}, body(made(R"({"access": "view"})"))));
    EXPECT_EQ(body_of(in), "{\"access\": \"view\"}\n") << in;
    EXPECT_NE(in.find("=" + view_token), std::string::npos) << "the cookie is the read-only token";
}

TEST_F(SignInCodes, are_created_only_with_the_control_token) {
    EXPECT_EQ(code("POST /login/code", {}, "{}"), "401");
    EXPECT_EQ(code("POST /login/code", bearer(view_token), "{}"), "403");
    EXPECT_EQ(code("POST /login/code", bearer(control_token) + "Sec-Fetch-Site: cross-site\r\n", "{}"), "403");
    EXPECT_EQ(code("POST /login/code", bearer(control_token) + "Origin: http://evil.example\r\n", "{}"), "403");
    EXPECT_EQ(code("GET /login/code", bearer(control_token)), "405");
    EXPECT_EQ(state("link"), "none");
    EXPECT_EQ(code("POST /login/code", bearer(control_token), "{}"), "200");
    for (const std::string wrong : {"", "[]", R"({"form": "word"})", R"({"access": "open"})", R"({"access": 1})"})
        EXPECT_EQ(code("POST /login/code", bearer(control_token), wrong), "400") << wrong;
}

// The digits can be tried three times, from any number of addresses.
TEST_F(SignInCodes, of_digits_are_void_after_three_wrong_attempts_from_any_addresses) {
    const std::string right = digits();
    EXPECT_EQ(use(other_than(right, 0), "127.9.0.1"), "401");
    EXPECT_EQ(use(other_than(right, 1), "127.9.0.2"), "401");
    EXPECT_EQ(state("digits"), "valid");
    EXPECT_EQ(use(other_than(right, 2), "127.9.0.1"), "401");
    EXPECT_EQ(state("digits"), "void");
    EXPECT_EQ(use(right), "401");
    EXPECT_TRUE(daemon.until_says("void after 3 wrong attempts, the last from 127.9.0.1")) << daemon.output();
    EXPECT_EQ(daemon.status().at("http").at("wrong_tokens"), 4);
    const std::string another = digits();
    EXPECT_EQ(use(other_than(another, 0)), "401");
    EXPECT_EQ(use(other_than(another, 1)), "401");
    EXPECT_EQ(use(another), "200") << "it has three tries of its own";
}

TEST_F(SignInCodes, of_a_link_stay_valid_when_digits_are_guessed) {
    const std::string code = link(), guessed = digits();
    for (int i = 0; i < 20; ++i) use(other_than(guessed, i), "127.9.0." + std::to_string(1 + i % 5));
    EXPECT_EQ(state("digits"), "void");
    EXPECT_EQ(state("link"), "valid");
    EXPECT_EQ(use(code), "200");
}

TEST_F(SignInCodes, guesses_at_them_are_slowed_down_like_guesses_at_tokens) {
    const std::string right = link();
    for (int i = 0; i < 10; ++i) EXPECT_EQ(use(std::string(32, static_cast<char>('0' + i))), "401");
    EXPECT_EQ(use(std::string(32, 'a')), "429");
    EXPECT_EQ(use("000000"), "429") << "none was made";
    EXPECT_EQ(use(right), "200") << "a right one is always taken";
}

// Otherwise a blocked address could end every code that is made, or try all digits without ending one.
TEST_F(SignInCodes, of_digits_are_not_checked_for_an_address_that_is_slowed_down) {
    for (int i = 0; i < 11; ++i) use("000000", "127.9.0.1");
    for (int round = 0; round < 3; ++round) {
        const std::string right = digits();
        for (int i = 0; i < 5; ++i) EXPECT_EQ(use(other_than(right, i), "127.9.0.1"), "429");
        EXPECT_EQ(use(right, "127.9.0.1"), "429") << "neither does it learn which is right";
        EXPECT_EQ(state("digits"), "valid");
        EXPECT_EQ(use(right), "200") << "from another address";
    }
    EXPECT_EQ(use(link(), "127.9.0.1"), "200") << "a link is too long to be guessed";
}

TEST_F(SignInCodes, are_not_used_by_pages_of_other_sites_or_forms) {
    for (const std::string& code_there : {link(), digits()}) {
        EXPECT_EQ(code("POST /login", "Sec-Fetch-Site: cross-site\r\n", body(code_there)), "403");
        EXPECT_EQ(code("POST /login", "Sec-Fetch-Site: same-site\r\n", body(code_there)), "403");
        EXPECT_EQ(code("POST /login", "Origin: http://evil.example\r\n", body(code_there)), "403");
        const std::string form =
            "POST /login HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: text/plain\r\n"
            "Content-Length: " +
            std::to_string(body(code_there).size()) + "\r\n\r\n" + body(code_there);
        EXPECT_EQ(code_of(http(port, form)), "415");
        EXPECT_EQ(use(code_there), "200") << "it was still valid";
    }
}

// A browser that prefetches a link, or an app that shows a preview of it, sends a GET without the part after the #.
TEST_F(SignInCodes, are_not_used_by_a_prefetch) {
    const std::string there = link(), page = "Accept: text/html\r\nAccept-Encoding: gzip\r\n";
    for (const std::string target : {"/", "/?once=", "/login?code=", "/login/code?code="})
        for (const std::string method : {"GET ", "HEAD "}) {
            const std::string whole = target == "/" ? target : target + there;
            const std::string answer = http(port, request(method + whole, page + "Sec-Purpose: prefetch\r\n"));
            EXPECT_EQ(answer.find("Set-Cookie"), std::string::npos) << answer.substr(0, 400);
        }
    EXPECT_EQ(state("link"), "valid");
    EXPECT_EQ(use(there), "200");
}

// A code made with a stolen token gets no cookie with the new one.
TEST_F(SignInCodes, expire_with_the_tokens_that_they_were_created_with) {
    const std::string one = link(), other = digits();
    dir.write("token", "view another-view-token-0123\ncontrol another-control-token-0123\n");
    http(socket, "POST /reload HTTP/1.0\r\n\r\n");
    EXPECT_EQ(use(one), "401");
    EXPECT_EQ(use(other), "401");
}

TEST_F(SignInCodes, are_not_created_for_tokens_that_do_not_exist) {
    dir.write("token", "view " + view_token + "\n");
    http(socket, "POST /reload HTTP/1.0\r\n\r\n");
    EXPECT_EQ(code_at_socket("POST /login/code", {}, "{}"), "409");
    EXPECT_EQ(code_at_socket("POST /login/code", {}, R"({"access": "view"})"), "200");
}

// In simulated time, through the functions that the route calls.
class LateCodes : public testing::Test {
protected:
    LateCodes() {
        admission.set(
            {.tokens = {{anogate::http::Access::control, control_token}}, .host_name = "vehicle", .hosts = {}, .origins = {}});
    }
    static anogate::http::Request request(const std::string& body) {
        anogate::http::Request request;
        request.body = body;
        request.connection_info = {
            .is_network = true, .needs_token = true, .local = "192.168.1.5", .port = 8088, .peer = "192.168.1.77"};
        return request;
    }
    std::string make(const std::string& wanted) {
        return json::parse(anogate::make_code(admission, codes, request(wanted), now).body).at("code");
    }
    unsigned use(const std::string& code) {
        return anogate::login(admission, codes, request(R"({"code": ")" + code + "\"}"), now).status;
    }

    anogate::http::Admission admission;
    anogate::SignInCodes codes;
    ano::TimePoint now{1h};
};

TEST_F(LateCodes, are_refused_after_five_minutes) {
    for (const std::string wanted : {"{}", R"({"form": "digits"})"}) {
        const std::string in_time = make(wanted);
        now += 5min - 1ms;
        EXPECT_EQ(use(in_time), 200u);
        const std::string late = make(wanted);
        now += 5min;
        EXPECT_EQ(use(late), 401u);
    }
    EXPECT_EQ(codes.state(anogate::SignInCodes::Form::digits, now), anogate::SignInCodes::State::expired);
}

// A million digits, three tries for each code: the owner makes any number of codes, and each is void at once.
TEST_F(LateCodes, allow_only_three_guesses_each_however_many_are_made) {
    unsigned tries = 0;
    for (int i = 0; i < 200; ++i) {
        const std::string right = make(R"({"form": "digits"})");
        for (int k = 0; k < 100 && codes.state(anogate::SignInCodes::Form::digits, now) == anogate::SignInCodes::State::valid;
             ++k) {
            ++tries;
            use(right == "000000" ? "000001" : "000000");
        }
        EXPECT_EQ(use(right) / 100, 4u);
        now += 1min;
    }
    EXPECT_EQ(tries, 600u);
}

}    // namespace
}    // namespace sign_in_codes_tests
