#include <http/large_body.hpp>
#include <http/listeners/admission.hpp>

#include <gtest/gtest.h>

#include <memory>
#include <span>

namespace anogate::http::admission_tests {
namespace {

using namespace std::chrono_literals;

const std::string looks = "view-token-0123456789", acts = "control-token-0123456789";

ConnectionInfo network_listener(bool needs_token = true) {
    return {.is_network = true, .needs_token = needs_token, .local = "192.168.1.5", .port = 8088, .peer = "192.168.1.77"};
}

Request asked(std::vector<Field> headers, ConnectionInfo connection_info = network_listener()) {
    Request request;
    request.method = "GET";
    request.target = "/status";
    request.headers = std::move(headers);
    request.connection_info = std::move(connection_info);
    return request;
}

Admission admission_with(AdmissionRules more = {}) {
    Admission admission;
    more.tokens = {{Access::view, looks}, {Access::control, acts}};
    more.host_name = "Vehicle";
    admission.set(std::move(more));
    return admission;
}

/// The access of the request as a number, or the status of the refusal as a negative number.
int judged(Admission& admission, Request request, ano::TimePoint now = {}) {
    const auto allowed = admission.judge(request, now);
    return allowed ? static_cast<int>(*allowed) : -static_cast<int>(allowed.error().status);
}
int judged(const Request& request) {
    Admission admission = admission_with();
    return judged(admission, request);
}
constexpr int open = static_cast<int>(Access::open), view = static_cast<int>(Access::view),
              control = static_cast<int>(Access::control);
const Field host{"Host", "192.168.1.5:8088"};

TEST(Admission, grants_all_rights_to_clients_of_the_unix_socket) {
    EXPECT_EQ(judged(asked({}, {})), control);
    EXPECT_EQ(judged(asked({{"Host", "evil.example"}, {"Origin", "http://evil.example"}}, {})), control);
}

TEST(Admission, grants_network_clients_the_rights_of_their_token) {
    EXPECT_EQ(judged(asked({host})), open);
    EXPECT_EQ(judged(asked({host, {"Authorization", "Bearer " + looks}})), view);
    EXPECT_EQ(judged(asked({host, {"authorization", "bearer   " + acts}})), control);
    for (const std::string wrong : {"x", "view-token-012345678", "view-token-01234567890", "VIEW-token-0123456789"})
        EXPECT_EQ(judged(asked({host, {"Authorization", "Bearer " + wrong}})), -401) << wrong;
    EXPECT_EQ(judged(asked({host, {"Authorization", "Basic " + acts}})), open);
}

TEST(Admission, accepts_a_token_in_a_cookie_like_one_in_a_header) {
    EXPECT_EQ(judged(asked({host, {"Cookie", "a=b; anogate-8088=" + acts}})), control);
    EXPECT_EQ(judged(asked({host, {"Cookie", "anogate-8088=" + looks + "; c=d"}})), view);
    EXPECT_EQ(judged(asked({host, {"Cookie", "anogate-9000=" + acts}})), open) << "another gateway of this host";
    EXPECT_EQ(judged(asked({host, {"Cookie", ";;; =;anogate-8088"}})), open);
    const Field made = admission_with().cookie(acts, network_listener());
    EXPECT_EQ(made.name, "Set-Cookie");
    EXPECT_EQ(made.value, "anogate-8088=" + acts + "; HttpOnly; SameSite=Strict; Path=/; Max-Age=31536000");
    ConnectionInfo encrypted = network_listener();
    encrypted.is_encrypted = true;
    EXPECT_TRUE(admission_with().cookie(acts, encrypted).value.ends_with("; Secure"));
}

/// A WebSocket that offers `subprotocols`.
Request upgrade(std::string target, std::string subprotocols, std::vector<Field> more = {}) {
    Request request = asked({host, {"Connection", "Upgrade"}, {"Upgrade", "websocket"}});
    if (!subprotocols.empty()) request.headers.push_back({"Sec-WebSocket-Protocol", std::move(subprotocols)});
    request.headers.insert(request.headers.end(), more.begin(), more.end());
    request.target = std::move(target);
    return request;
}
constexpr std::string_view subprotocol = "plot.v1";
Admission admission_of_plots() {
    AdmissionRules rules;
    rules.paths = {"/", "/plot"};
    rules.subprotocols = {subprotocol};
    return admission_with(std::move(rules));
}

TEST(Admission, accepts_a_token_in_the_query_only_for_subprotocols_whose_clients_need_it) {
    Admission admission = admission_of_plots();
    EXPECT_EQ(judged(admission, upgrade("/?token=" + looks, "plot.v2, plot.v1")), view);
    EXPECT_EQ(judged(admission, upgrade("/?a=b&token=" + acts + "&c", "plot.v1")), control);
    EXPECT_EQ(judged(admission, upgrade("/?tok%65n=view%2Dtoken-0123456789", "plot.v1")), view);
    EXPECT_EQ(judged(admission, upgrade("/plot?token=" + looks, "plot.v1")), view);
    EXPECT_EQ(judged(admission, upgrade("/link?name=x&token=" + acts, "plot.v1")), open) << "where something else is spoken";
    EXPECT_EQ(judged(admission, upgrade("/?token=" + looks, "")), open);
    EXPECT_EQ(judged(admission, upgrade("/?token=" + looks, "plot.v2")), open);
    EXPECT_EQ(judged(admission, upgrade("/?Token=" + looks, "plot.v1")), open);
    EXPECT_EQ(judged(admission, upgrade("/?token=", "plot.v1")), open);
    EXPECT_EQ(judged(admission, upgrade("/?token=%zz", "plot.v1")), open);
    Request no_web_socket = asked({host, {"Sec-WebSocket-Protocol", "plot.v1"}});
    no_web_socket.target = "/status?token=" + acts;
    EXPECT_EQ(judged(admission, no_web_socket), open);
    EXPECT_EQ(judged(upgrade("/?token=" + looks, "plot.v1")), open) << "where no subprotocol is spoken";
}

TEST(Admission, prefers_a_token_in_a_header_to_the_query_and_the_query_to_a_cookie) {
    Admission admission = admission_of_plots();
    EXPECT_EQ(judged(admission, upgrade("/?token=" + acts, "plot.v1", {{"Authorization", "Bearer " + looks}})), view);
    EXPECT_EQ(judged(admission, upgrade("/?token=" + looks, "plot.v1", {{"Cookie", "anogate-8088=" + acts}})), view);
    EXPECT_EQ(judged(admission, upgrade("/?a", "plot.v1", {{"Cookie", "anogate-8088=" + acts}})), control);
}

TEST(Admission, counts_a_wrong_token_in_the_query_as_an_attempt) {
    Admission admission = admission_of_plots();
    for (int i = 0; i < 10; ++i) EXPECT_EQ(judged(admission, upgrade("/?token=x", "plot.v1")), -401);
    EXPECT_EQ(judged(admission, upgrade("/?token=x", "plot.v1")), -429);
}

TEST(Admission, removes_a_token_from_the_query_after_its_check) {
    const Admission admission = admission_of_plots();
    Request request = upgrade("/?encoding=json&t%6Fken=" + looks + "&token=x", "plot.v1");
    admission.forget_token(request);
    EXPECT_EQ(request.target, "/?encoding=json");
    Request other = upgrade("/frames?token=x", "");
    admission.forget_token(other);
    EXPECT_EQ(other.target, "/frames?token=x") << "who mistook the path is told of it";
}

TEST(Admission, requires_no_token_on_a_listener_without_tokens) {
    EXPECT_EQ(judged(asked({host}, network_listener(false))), control);
}

TEST(Admission, requires_a_token_for_proxied_requests_on_every_listener) {
    for (const std::string name : {"Forwarded", "x-forwarded-for", "X-Forwarded-Proto", "VIA"}) {
        EXPECT_EQ(judged(asked({host, {name, "1"}}, network_listener(false))), open) << name;
        EXPECT_EQ(judged(asked({{name, "1"}}, {})), open) << name;
        EXPECT_EQ(judged(asked({{name, "1"}, {"Authorization", "Bearer " + acts}}, {})), control) << name;
    }
}

TEST(Admission, rejects_a_host_name_that_does_not_belong_to_the_gateway) {
    const auto by_name = [](const std::string& name) { return judged(asked({{"Host", name}}, network_listener(false))); };
    for (const std::string ours :
         {"192.168.1.5", "192.168.1.5:8088", "localhost:9000", "LOCALHOST", "vehicle", "vehicle.local:8088", "Vehicle.Local."})
        EXPECT_EQ(by_name(ours), control) << ours;
    for (const std::string other : {"evil.example", "", "192.168.1.6", "vehicle.local.evil.example", "localhost.evil.example",
                                    "[::1]", "vehicle@evil.example"})
        EXPECT_EQ(by_name(other), -403) << other;
    EXPECT_EQ(judged(asked({}, network_listener(false))), -403) << "none at all";
    EXPECT_EQ(judged(asked({host, host}, network_listener(false))), -403) << "which of the two a proxy took is not known";

    Admission named = admission_with({{}, {}, {"Vehicle.lan"}, {}});
    EXPECT_EQ(judged(named, asked({{"Host", "vehicle.lan:8088"}}, network_listener(false))), control);
    ConnectionInfo v6 = network_listener(false);
    v6.local = "fe80::1%wlan0";
    EXPECT_EQ(judged(asked({{"Host", "[fe80::1]:8088"}}, v6)), control);
}

TEST(Admission, rejects_requests_of_pages_of_other_origins) {
    const auto from = [](const std::string& origin, const std::string& to = "192.168.1.5:8088") {
        return judged(asked({{"Host", to}, {"Origin", origin}}, network_listener(false)));
    };
    EXPECT_EQ(from("http://192.168.1.5:8088"), control);
    EXPECT_EQ(from("HTTP://192.168.1.5:8088"), control);
    EXPECT_EQ(from("http://localhost:9000", "localhost:9000"), control) << "through ssh -L 9000:localhost:8088";
    EXPECT_EQ(from("http://vehicle.local", "vehicle.local:80"), control);
    EXPECT_EQ(from("https://vehicle.local", "vehicle.local"), control) << "behind what encrypts";
    for (const std::string other :
         {"http://evil.example", "http://192.168.1.5:3000", "http://192.168.1.5", "null", "192.168.1.5:8088",
          "http://192.168.1.5:8088.evil.example", "file://", "ftp://192.168.1.5:8088", "chrome-extension://192.168.1.5:8088",
          "://192.168.1.5:8088", "httpx://192.168.1.5:8088", "http", "https", "http:", "http://"})
        EXPECT_EQ(from(other), -403) << other;
    EXPECT_EQ(judged(asked({host, {"Origin", ""}, {"origin", "http://evil.example"}}, network_listener(false))), -400)
        << "two of them";
    Admission friendly = admission_with({{}, {}, {}, {"https://ground.example"}});
    EXPECT_EQ(judged(friendly, asked({host, {"Origin", "https://Ground.example"}}, network_listener(false))), control);
    EXPECT_EQ(judged(friendly, asked({host, {"Origin", "http://ground.example"}}, network_listener(false))), -403);
}

TEST(Admission, rejects_content_types_that_a_form_can_send) {
    const auto sent = [](std::vector<Field> headers, ConnectionInfo connection_info = network_listener(false)) {
        headers.push_back(host);
        Request request = asked(std::move(headers), std::move(connection_info));
        request.method = "POST";
        request.body = "{}";
        return judged(request);
    };
    EXPECT_EQ(sent({{"Content-Type", "application/json"}}), control);
    EXPECT_EQ(sent({{"Content-Type", "Application/JSON ; charset=utf-8"}}), control);
    EXPECT_EQ(sent({{"Content-Type", "application/octet-stream"}}), control);
    for (const std::string type : {"text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", "",
                                   "text/plain; application/json"})
        EXPECT_EQ(sent({{"Content-Type", type}}), -415) << type;
    EXPECT_EQ(sent({}), -415);
    EXPECT_EQ(sent({}, {}), control) << "curl -d by the socket";
}

TEST(Admission, checks_the_content_type_of_a_body_in_a_file_too) {
    struct Stored final : StoredBody {
        std::uint64_t size() const override { return 70'000; }
        bool read(std::uint64_t, std::span<std::uint8_t>) const override { return true; }
    };
    for (const std::string type : {"text/plain", "application/octet-stream"}) {
        Request request = asked({{"Host", "vehicle:8088"}, {"Authorization", "Bearer " + acts}, {"Content-Type", type}});
        request.stored = std::make_shared<Stored>();
        EXPECT_EQ(judged(request), type == "text/plain" ? -415 : control) << type;
    }
}

TEST(Admission, rejects_further_wrong_tokens_for_a_minute_after_ten_from_one_address) {
    Admission admission = admission_with();
    std::vector<std::string> told;
    admission.on_guessing([&](const std::string& peer, const Attempts::News&) { told.push_back(peer); });
    const Request wrong = asked({host, {"Authorization", "Bearer wrong"}}),
                  right = asked({host, {"Authorization", "Bearer " + acts}});
    ano::TimePoint now{1h};
    for (int i = 0; i < 10; ++i, now += 1s) EXPECT_EQ(judged(admission, wrong, now), -401);
    EXPECT_EQ(judged(admission, wrong, now), -429);
    EXPECT_EQ(judged(admission, right, now), control) << "others of this address may have sent the wrong ones";
    EXPECT_EQ(judged(admission, asked({host}), now), open) << "who gives none is not guessing";
    EXPECT_EQ(judged(admission, wrong, ano::TimePoint{1h} + 59s), -429);
    EXPECT_EQ(judged(admission, wrong, ano::TimePoint{1h} + 60s), -401) << "the first is forgotten, nine are not";
    EXPECT_EQ(judged(admission, wrong, ano::TimePoint{1h} + 60500ms), -429);
    EXPECT_EQ(told, std::vector<std::string>{"192.168.1.77"}) << "once";
    EXPECT_EQ(admission.wrong_tokens(), 14u);
}

TEST(Admission, sends_retry_after_when_it_slows_down_wrong_tokens) {
    Admission admission = admission_with();
    Request wrong = asked({host, {"Authorization", "Bearer wrong"}});
    for (int i = 0; i < 10; ++i) (void)admission.judge(wrong, {});
    const auto slowed = admission.judge(wrong, ano::TimePoint{} + 15s);
    ASSERT_FALSE(slowed);
    EXPECT_EQ(slowed.error().headers.front(), (Field{"Retry-After", "45"}));
    EXPECT_NE(slowed.error().body.find("try again in 45 s"), std::string::npos) << slowed.error().body;
}

TEST(Admission, treats_a_wrong_token_in_a_cookie_like_no_token_and_clears_it) {
    AdmissionRules rules;
    rules.token_file_id = "12ab34cd";
    Admission admission = admission_with(rules);
    const Field right{"Cookie", "anogate-8088-12ab34cd=" + acts};
    Request stale = asked({host, {"Cookie", "anogate-8088-12ab34cd=" + std::string(20, 'x')}});
    int told = 0;
    admission.on_guessing([&](const std::string&, const Attempts::News&) { ++told; });
    for (int i = 0; i < 20; ++i) EXPECT_EQ(judged(admission, stale), open);
    EXPECT_EQ(*admission.judge(stale, {}), Access::open);
    ASSERT_TRUE(stale.also);
    EXPECT_EQ(stale.also->value, "anogate-8088-12ab34cd=; HttpOnly; SameSite=Strict; Path=/; Max-Age=0");
    EXPECT_EQ(admission.wrong_tokens(), 1u) << "the same one again is no further guess";
    EXPECT_EQ(stale.slowed, ano::Duration{});
    EXPECT_EQ(told, 0);
    for (const std::string target : {"/login", "/logout"}) {
        Request leaving = asked({host, {"Cookie", "anogate-8088-12ab34cd=other"}});
        leaving.target = target;
        EXPECT_EQ(*admission.judge(leaving, {}), Access::open);
        EXPECT_FALSE(leaving.also) << target << ": the response itself sets the cookie";
    }
    EXPECT_EQ(admission.wrong_tokens(), 1u);
    Request kept = asked({host, right});
    EXPECT_EQ(*admission.judge(kept, {}), Access::control);
    EXPECT_FALSE(kept.also);
    EXPECT_EQ(kept.slowed, ano::Duration{}) << "a right one is never slowed down";
    EXPECT_EQ(judged(admission, asked({host, {"Cookie", "anogate-8088-00000000=" + acts}})), open) << "of another token file";
    Request login = asked({host, right});
    login.target = "/login";
    EXPECT_EQ(judged(admission, login), open) << "whoever signs in has no token yet";
}

TEST(Admission, counts_each_different_wrong_token_in_cookies_as_a_guess) {
    Admission admission = admission_with();
    const auto slowed = [&](const std::string& cookies) {
        Request request = asked({host, {"Cookie", cookies}});
        EXPECT_EQ(*admission.judge(request, {}), Access::open);
        return request.slowed > ano::Duration{};
    };
    std::string nine;
    for (int i = 0; i < 9; ++i) nine += "anogate-8088=guess" + std::to_string(i) + "; ";
    EXPECT_FALSE(slowed(nine)) << "in one request";
    EXPECT_EQ(admission.wrong_tokens(), 9u);
    EXPECT_FALSE(slowed("anogate-8088=guess9"));
    EXPECT_TRUE(slowed("anogate-8088=guess10"));
    EXPECT_FALSE(slowed("anogate-8088=guess9")) << "known to be wrong";
    EXPECT_EQ(judged(admission, asked({host, {"Authorization", "Bearer wrong"}})), -429) << "they count with all others";
    EXPECT_EQ(judged(admission, asked({host, {"Cookie", "anogate-8088=guess; anogate-8088=" + acts}})), control);
}

TEST(Admission, recognizes_pages_of_other_sites) {
    AdmissionRules rules;
    rules.origins = {"https://ground.example"};
    const Admission admission = admission_with(rules);
    const auto is_foreign = [&](std::vector<Field> headers, ConnectionInfo connection_info = network_listener()) {
        headers.push_back(host);
        return admission.is_foreign(asked(std::move(headers), std::move(connection_info)));
    };
    EXPECT_FALSE(is_foreign({}));
    for (const std::string site : {"same-origin", "none", "Same-Origin"})
        EXPECT_FALSE(is_foreign({{"Sec-Fetch-Site", site}})) << site;
    for (const std::string site : {"cross-site", "same-site", "new-word"}) {
        EXPECT_TRUE(is_foreign({{"Sec-Fetch-Site", site}})) << site;
        EXPECT_TRUE(is_foreign({{"Sec-Fetch-Site", site}}, {})) << site << ", by a proxy at the Unix socket";
        EXPECT_FALSE(is_foreign({{"Sec-Fetch-Site", site}, {"Origin", "https://ground.example"}})) << site;
    }
    EXPECT_TRUE(is_foreign({{"Sec-Fetch-Site", "none"}, {"sec-fetch-site", "cross-site"}})) << "any of several";
    EXPECT_TRUE(is_foreign({{"Sec-Fetch-Site", ""}, {"Sec-Fetch-Site", "cross-site"}}));
    EXPECT_TRUE(is_foreign({{"Origin", "http://evil.example"}})) << "an older browser";
    EXPECT_TRUE(is_foreign({{"Origin", "null"}}));
    EXPECT_FALSE(is_foreign({{"Origin", "http://192.168.1.5:8088"}}));
}

TEST(Admission, requires_a_token_for_proxied_requests_whatever_header_marks_them) {
    for (const std::string name :
         {"X-Real-IP", "CF-Connecting-IP", "True-Client-IP", "Via", "Forwarded", "X-Forwarded-For", "X-Client-IP",
          "X-Cluster-Client-IP", "X-Original-Forwarded-For", "Fastly-Client-IP", "Fly-Client-IP"})
        EXPECT_EQ(judged(asked({host, {name, "1.2.3.4"}}, {})), open) << name;
}

TEST(Attempts, count_an_ipv6_network_as_one) {
    Attempts attempts;
    for (int i = 0; i < 10; ++i) attempts.failed("2001:db8::" + std::to_string(i), {});
    EXPECT_GT(attempts.slowed_for("2001:db8::ffff", {}), ano::Duration{});
    EXPECT_EQ(attempts.slowed_for("2001:db8:0:1::1", {}), ano::Duration{});
    EXPECT_EQ(attempts.slowed_for("2001", {}), ano::Duration{});
}

TEST(Attempts, are_reported_for_ten_clients_a_minute_and_counted_for_the_others) {
    Attempts attempts;
    ano::TimePoint now{1h};
    const auto guess = [&](int client) {
        Attempts::News news;
        for (std::size_t i = 0; i < Attempts::max_failures; ++i) {
            EXPECT_FALSE(news.is_told) << "before it is slowed down";
            news = attempts.failed("10.1.0." + std::to_string(client), now);
        }
        return news;
    };
    for (int client = 0; client < 10; ++client) {
        const Attempts::News news = guess(client);
        EXPECT_TRUE(news.is_told);
        EXPECT_EQ(news.unlogged, 0u);
        EXPECT_EQ(news.is_last, client == 9);
    }
    for (int client = 10; client < 30; ++client) EXPECT_FALSE(guess(client).is_told);
    EXPECT_EQ(attempts.slowed(), 30u);
    now += 1min;
    Attempts::News news = guess(30);
    EXPECT_TRUE(news.is_told && !news.is_last);
    EXPECT_EQ(news.unlogged, 20u);
    news = guess(31);
    EXPECT_TRUE(news.is_told);
    EXPECT_EQ(news.unlogged, 0u);
}

TEST(Admission, recognizes_control_rights_from_the_head_alone) {
    const Admission admission = admission_with();
    EXPECT_TRUE(admission.shows_control(asked({host, {"Authorization", "Bearer " + acts}})));
    EXPECT_FALSE(admission.shows_control(asked({host, {"Authorization", "Bearer wrong"}})));
    EXPECT_FALSE(admission.shows_control(asked({host})));
    EXPECT_TRUE(admission.shows_control(asked({host}, {}))) << "the Unix socket";
    EXPECT_FALSE(admission.shows_control(asked({host, {"Via", "1.1 test"}}, {})));
}

TEST(Attempts, of_the_client_that_failed_longest_ago_are_forgotten_first) {
    Attempts attempts;
    ano::TimePoint now{1h};
    for (std::size_t i = 0; i < Attempts::max_failures; ++i) attempts.failed("first", now);
    for (std::size_t i = 1; i < Attempts::max_peers; ++i) attempts.failed("10.0." + std::to_string(i), now += 1ms);
    EXPECT_GT(attempts.slowed_for("first", now), ano::Duration{});
    attempts.failed("one more", now);
    EXPECT_EQ(attempts.slowed_for("first", now), ano::Duration{});
}

}    // namespace
}    // namespace anogate::http::admission_tests
