// Request bodies that are large, slow or not accepted.
#include <integration/http_server.hpp>

#include <string>
#include <utility>
#include <vector>

namespace http_server {
namespace {

TEST_F(HttpServer, stores_a_large_body_in_parts_and_a_small_one_in_memory) {
    EXPECT_TRUE(answer(post_of(65'536)).ends_with("here 65536"));
    EXPECT_EQ(keeping.largest_part, 0u);
    EXPECT_TRUE(answer(post_of(65'537)).ends_with("stored 65537"));
    EXPECT_TRUE(answer(post_of(5'000'000)).ends_with("stored 5000000"));
    EXPECT_EQ(keeping.kept, std::string(5'000'000, 'x'));
    EXPECT_LT(keeping.largest_part, std::size_t{272} * 1024) << "what is held of it";
    const std::string chunk = "10000\r\n" + std::string(0x10000, 'y') + "\r\n";
    EXPECT_TRUE(
        answer("POST /large HTTP/1.1\r\nConnection: close\r\nTransfer-Encoding: chunked\r\n\r\n" + chunk + chunk + "0\r\n\r\n")
            .ends_with("stored 131072"));
    EXPECT_TRUE(has_error(answer(post_of((std::size_t{8} << 20) + 1)), "413 Payload Too Large",
                          "the body of a request has at most 8388608 bytes"));
}

TEST_F(HttpServer, reports_why_a_large_body_cannot_be_stored) {
    keeping.fault = "there is no room";
    EXPECT_TRUE(has_error(answer(post_of(1'000'000)), "507 Insufficient Storage", "there is no room"));
}

TEST_F(HttpServer, stores_two_large_bodies_at_a_time_and_frees_those_of_closed_clients) {
    keeping.waits = true;
    std::optional<Client> first = connect(), second = connect();
    const std::string part = post_of(1'000'000).substr(0, 300'000);
    for (std::size_t i = 0; i < 2; ++i) {
        std::size_t sent = 0;
        auto& client = i == 0 ? first : second;
        EXPECT_TRUE(until([&] {
            if (sent < part.size()) sent += client->send(std::string_view{part}.substr(sent));
            return keeping.done.size() == i + 1;
        }));
    }
    EXPECT_TRUE(has_error(answer(post_of(100'000)), "503 Service Unavailable", "other large uploads are in progress"));
    EXPECT_TRUE(answer(post_of(1000)).ends_with("here 1000")) << "a small one needs no place";
    EXPECT_NE(answer(post_of(100'000)).find("Retry-After: 1\r\n"), std::string::npos);
    keeping.waits = false;
    second.reset();
    for (const auto& done : std::exchange(keeping.done, {})) done("");
    EXPECT_TRUE(until([&] { return answer(post_of(100'000)).ends_with("stored 100000"); })) << "the place of who left is free";
}

TEST_F(HttpServer, a_chunked_body_uses_the_quota_of_large_bodies_once_it_is_large) {
    keeping.waits = true;
    std::vector<Client> clients;
    for (std::size_t i = 0; i < 2; ++i) {
        clients.push_back(connect());
        std::size_t sent = 0;
        const std::string part = post_of(1'000'000).substr(0, 300'000);
        EXPECT_TRUE(until([&] {
            if (sent < part.size()) sent += clients.back().send(std::string_view{part}.substr(sent));
            return keeping.done.size() == i + 1;
        }));
    }
    const std::string head = "POST /large HTTP/1.1\r\nConnection: close\r\nTransfer-Encoding: chunked\r\n\r\n";
    EXPECT_TRUE(answer(head + "3e8\r\n" + std::string(1000, 'y') + "\r\n0\r\n\r\n").ends_with("here 1000"));
    EXPECT_TRUE(has_error(answer(head + "20000\r\n" + std::string(0x20000, 'y') + "\r\n0\r\n\r\n"), "503 Service Unavailable",
                          "other large uploads are in progress"));
    for (const auto& done : std::exchange(keeping.done, {})) done("");
}

// Two clients that occupy the places and send almost nothing.
TEST_F(HttpServer, a_client_that_sends_a_large_body_too_slowly_is_closed_for_another) {
    ServerLimits limits;
    limits.session.slow_body = 50ms;
    begin(limits);
    std::vector<Client> slow;
    for (int i = 0; i < 2; ++i) {
        slow.push_back(connect());
        slow.back().send(post_of(1'000'000).substr(0, 500));
    }
    const auto trickle = [&] {
        for (Client& client : slow) client.send("x");
    };
    Client other = connect();
    EXPECT_TRUE(until([&] {
        trickle();
        if (other.has_heard("503")) other = connect();
        if (other.heard().empty()) other.send(post_of(100'000));
        return other.has_heard("stored 100000") || other.has_heard("here");
    })) << other.heard();
    EXPECT_TRUE(until([&] { return slow[0].is_closed() || slow[1].is_closed(); }));
    Client& gone = slow[0].is_closed() ? slow[0] : slow[1];
    EXPECT_TRUE(has_error(gone.heard(), "408 Request Timeout", "the body was received too slowly for 50 ms")) << gone.heard();
    EXPECT_FALSE(slow[0].is_closed() && slow[1].is_closed()) << "one place was enough";
}

TEST_F(HttpServer, sends_100_continue_to_a_client_that_expects_it) {
    Client client = connect();
    client.send("POST /large HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 1000000\r\n\r\n");
    ASSERT_TRUE(until([&] { return client.has_heard("\r\n\r\n"); }));
    EXPECT_EQ(client.heard(), "HTTP/1.1 100 Continue\r\n\r\n");
    client.heard().clear();
    const std::string body(1'000'000, 'x');
    std::size_t sent = 0;
    EXPECT_TRUE(until([&] {
        sent += client.send(std::string_view{body}.substr(sent));
        return client.has_heard("stored 1000000");
    }));
    EXPECT_TRUE(client.heard().starts_with("HTTP/1.1 200 OK\r\n")) << client.heard();
    const std::string refused = answer("POST /echo HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 1000000\r\n\r\n");
    EXPECT_TRUE(refused.starts_with("HTTP/1.1 413 ")) << refused;
    client.heard().clear();
    client.send("POST /echo HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 3\r\n\r\nabc");
    EXPECT_TRUE(until([&] { return client.has_heard("abc"); }));
    EXPECT_TRUE(client.heard().starts_with("HTTP/1.1 200 OK\r\n")) << "the body came without it: " << client.heard();
}

TEST_F(JudgingHttpServer, a_request_without_permission_is_rejected_before_a_large_body_is_received) {
    for (const std::string target : {"/large", "/echo"}) {
        EXPECT_TRUE(has_error(ask(target, ""), "401 Unauthorized", "this path needs a token")) << target;
        EXPECT_TRUE(has_error(ask(target, bearer("wrong")), "401 Unauthorized", "wrong token")) << target;
        EXPECT_TRUE(has_error(ask(target, bearer("only-looks")), "403 Forbidden", "this token does not allow this")) << target;
    }
    EXPECT_TRUE(has_error(ask("/echo", bearer("may-act")), "413 Payload Too Large", "the body of a request has at most 65536"));
    EXPECT_TRUE(
        has_error(ask("/large", bearer("may-act"), 9'000'000), "413 Payload Too Large", "the body of a request has at most"));
    EXPECT_NE(ask("/large", bearer("may-act"), 3, 3).find("here 3"), std::string::npos);
}

TEST_F(JudgingHttpServer, a_wrong_token_counts_once_a_request) {
    for (std::size_t i = 0; i + 1 < Attempts::max_failures; ++i)
        EXPECT_TRUE(ask("/large", bearer("wrong")).starts_with("HTTP/1.1 401 ")) << i;
    EXPECT_NE(ask("/large", bearer("may-act"), 3, 3).find("here 3"), std::string::npos);
    EXPECT_TRUE(ask("/large", bearer("wrong"), 3, 3).starts_with("HTTP/1.1 401 "));
    EXPECT_TRUE(ask("/large", bearer("wrong"), 3, 3).starts_with("HTTP/1.1 429 "));
    EXPECT_NE(ask("/large", bearer("may-act"), 3, 3).find("here 3"), std::string::npos) << "a right one is always taken";
}

// A slow body is accepted as long as data arrive.
TEST_F(ImpatientHttpServer, reports_and_closes_a_client_that_stops_within_a_large_body) {
    Client slow = connect();
    slow.send(post_of(1'000'000).substr(0, 100'000));
    const auto begin = std::chrono::steady_clock::now();
    until([&] { return slow.send("x"), std::chrono::steady_clock::now() - begin > 500ms; });
    EXPECT_FALSE(slow.is_closed()) << slow.heard();
    EXPECT_TRUE(until([&] { return slow.is_closed(); }));
    EXPECT_TRUE(has_error(slow.heard(), "408 Request Timeout", "no more of the body was received for 100 ms")) << slow.heard();
}

TEST_F(ImpatientHttpServer, reports_that_the_disk_is_too_slow) {
    keeping.waits = true;
    Client client = connect();
    const std::string part = post_of(1'000'000).substr(0, 300'000);
    std::size_t sent = 0;
    EXPECT_TRUE(until([&] {
        if (sent < part.size()) sent += client.send(std::string_view{part}.substr(sent));
        return client.is_closed();
    }));
    EXPECT_TRUE(has_error(client.heard(), "503 Service Unavailable", "the disk is too slow")) << client.heard();
}

}    // namespace
}    // namespace http_server
