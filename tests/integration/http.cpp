// Sessions of the HTTP server over real sockets, with correct and faulty clients.
#include <integration/http_server.hpp>
#include <sys/descriptors_left.hpp>

#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

namespace http_server {
namespace {

INSTANTIATE_TEST_SUITE_P(Over, HttpServer, testing::Values(Transport::unix_socket, Transport::tcp),
                         [](const auto& way) { return way.param == Transport::tcp ? "tcp" : "unix"; });

TEST_P(HttpServer, answers_pipelined_requests_in_their_order) {
    Client client = connect(GetParam());
    std::string all;
    for (int i = 0; i < 50; ++i) all += get("/short?n=<" + std::to_string(i) + ">");
    client.send(all);
    EXPECT_TRUE(until([&] { return client.has_heard("<49>"); })) << client.heard();
    std::size_t at = 0;
    for (int i = 0; i < 50; ++i) {
        at = client.heard().find("<" + std::to_string(i) + ">", at);
        ASSERT_NE(at, std::string::npos) << i;
    }
    EXPECT_FALSE(client.is_closed());
}

TEST_P(HttpServer, accepts_a_request_that_is_received_byte_by_byte) {
    Client client = connect(GetParam());
    for (const char c : std::string{"POST /echo HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc"}) {
        client.send({&c, 1});
        settle();
    }
    EXPECT_TRUE(until([&] { return client.has_heard("\r\n\r\nabc"); }));
}

TEST_P(HttpServer, answers_a_client_that_has_closed_its_sending_half) {
    Client client = connect(GetParam());
    client.send(get("/short?n=yes"));
    client.end_output();
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
    EXPECT_TRUE(client.has_heard("\r\n\r\nyes")) << client.heard();
}

TEST_P(HttpServer, reports_a_request_that_ended_before_it_was_complete) {
    Client client = connect(GetParam());
    client.send("GET /sho");
    client.end_output();
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
    EXPECT_TRUE(has_error(client.heard(), "400 Bad Request", "the request ended before it was complete")) << client.heard();
}

TEST_F(HttpServer, reports_too_large_and_invalid_requests_and_closes_the_connection) {
    const std::string large = std::string(200'000, 'x');
    EXPECT_TRUE(has_error(answer("GET / HTTP/1.1\r\nX: " + large + "\r\n\r\n"), "431 Request Header Fields Too Large",
                          "the header of a request has at most 8192 bytes"));
    EXPECT_TRUE(has_error(answer("POST /echo HTTP/1.1\r\nContent-Length: 200000\r\n\r\n" + large), "413 Payload Too Large",
                          "the body of a request has at most 65536 bytes"));
    EXPECT_TRUE(has_error(answer("\x01\x02 HELLO\r\n\r\n" + large), "400 Bad Request", "this is not an HTTP request"));
    EXPECT_TRUE(has_error(answer("GET / HTTP/3.0\r\n\r\n"), "400 Bad Request", "this is not a request of HTTP/1.0 or HTTP/1.1"));
    const std::string two = answer(get("/short?n=one") + "GARBAGE\r\n\r\n");
    EXPECT_TRUE(two.starts_with("HTTP/1.1 200 OK")) << "what came before it is answered: " << two;
    EXPECT_NE(two.find("HTTP/1.1 400 Bad Request"), std::string::npos) << two;
}

TEST_F(HttpServer, reports_a_lack_of_memory_and_when_to_retry) {
    const std::string words = "not enough memory for a request; try again";
    const auto told = [&](const std::string& answer) {
        return has_error(answer, "503 Service Unavailable", words) && answer.find("Retry-After: 1\r\n") != answer.npos;
    };
    EXPECT_TRUE(told(answer(get("/none")))) << "it showed while the answer was made";
    Client in_time = connect();
    settle();
    has_memory = false;
    EXPECT_TRUE(told(answer(get("/short"))));
    in_time.send(get("/short"));
    EXPECT_TRUE(until([&] { return in_time.is_closed(); }));
    EXPECT_TRUE(told(in_time.heard())) << in_time.heard();
    has_memory = true;
    Client later = connect();
    later.send(get("/short"));
    EXPECT_TRUE(until([&] { return later.has_heard("200 OK"); }));
}

// Each check takes two system calls.
TEST_F(HttpServer, checks_the_memory_once_for_a_prompt_response_and_again_after_another_response) {
    Client one = connect(), other = connect();
    settle();
    const auto looks = [&](std::initializer_list<Client*> clients) {
        const int before = memory_looks;
        for (Client* client : clients) {
            client->heard().clear();
            client->send(get("/short"));
        }
        for (Client* client : clients) EXPECT_TRUE(until([client] { return client->has_heard("200 OK"); }));
        return memory_looks - before;
    };
    EXPECT_TRUE(support::wait_until([&] { return looks({&one}) == 1; })) << "unless that takes long";
    EXPECT_GE(looks({&one, &other}), 3);
}

INSTANTIATE_TEST_SUITE_P(Over, ImpatientHttpServer, testing::Values(Transport::unix_socket, Transport::tcp),
                         [](const auto& way) { return way.param == Transport::tcp ? "tcp" : "unix"; });

TEST_P(ImpatientHttpServer, closes_silent_clients_and_those_that_never_complete_a_request) {
    Client silent = connect(GetParam()), slow = connect(GetParam());
    slow.send("GET /sho");
    EXPECT_TRUE(until([&] { return slow.send("r"), silent.is_closed() && slow.is_closed(); }));
    EXPECT_EQ(silent.heard(), "");
    EXPECT_TRUE(has_error(slow.heard(), "408 Request Timeout", "the request was not complete within 100 ms")) << slow.heard();
}

TEST_P(ImpatientHttpServer, closes_a_client_that_does_not_read_its_response) {
    const auto open_files = [] {
        return std::distance(std::filesystem::directory_iterator{"/proc/self/fd"}, std::filesystem::directory_iterator{});
    };
    const auto before = open_files();
    Client client = connect(GetParam());
    ASSERT_TRUE(until([&] { return open_files() == before + 2; }));    // both ends
    client.send(get("/big"));
    EXPECT_TRUE(until([&] { return open_files() == before + 1; }));    // the client would notice it only by reading
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
    EXPECT_LT(client.heard().size(), std::size_t{16 << 20});
}

class SlowlyReadHttpServer : public HttpServer {
protected:
    // Slightly longer than the server waits for a client that reads nothing.
    void read_slowly(Client& client) {
        client.receive_some();
        client.send(get("/big"));
        for (const auto begin = std::chrono::steady_clock::now(); std::chrono::steady_clock::now() - begin < 900ms;) {
            client.receive_some();
            io.restart();
            io.run_for(4ms);
        }
        ASSERT_LT(client.receive_some(), std::size_t{16 << 20}) << "he is to be still at it";
    }
};

INSTANTIATE_TEST_SUITE_P(Over, SlowlyReadHttpServer, testing::Values(Transport::unix_socket, Transport::tcp),
                         [](const auto& way) { return way.param == Transport::tcp ? "tcp" : "unix"; });

TEST_P(SlowlyReadHttpServer, does_not_close_the_client) {
    ServerLimits limits;
    limits.session.patience = 400ms;
    begin(limits);
    Client client = connect(GetParam());
    read_slowly(client);
    EXPECT_TRUE(until([&] { return client.heard().size() > (16 << 20) || client.is_closed(); }));
    EXPECT_GT(client.heard().size(), std::size_t{16 << 20});
}

TEST_F(SlowlyReadHttpServer, does_not_close_the_client_at_once_when_another_one_waits) {
    ServerLimits limits;
    limits.local.connections = 1;
    limits.session.stalled_after = 1500ms;
    begin(limits);
    Client client = connect();
    read_slowly(client);
    Client other = connect();
    other.send(get("/short?n=here"));
    settle();
    EXPECT_FALSE(client.is_closed());
    EXPECT_TRUE(until([&] { return other.has_heard("here"); })) << "it waited in the kernel's queue";
}

TEST_P(HttpServer, at_the_shutdown_waiting_clients_are_closed_and_started_responses_are_completed) {
    Client reads = connect(GetParam()), waits = connect(GetParam());
    reads.send(get("/big"));
    EXPECT_TRUE(until([&] { return reads.has_heard("200 OK"); }));
    settle();    // it waits until more is read
    waits.send(get("/short?n=late"));
    io.restart();
    EXPECT_EQ(io.poll_one(), 1u);    // it is read, but not processed further
    server->finish(std::chrono::hours{1});
    EXPECT_TRUE(until([&] { return waits.is_closed(); }));
    EXPECT_EQ(waits.heard(), "");
    EXPECT_FALSE(reads.is_closed());
    EXPECT_TRUE(until([&] { return reads.is_closed(); }));
    EXPECT_GT(reads.heard().size(), std::size_t{16 << 20});
}

TEST_P(HttpServer, at_the_shutdown_a_client_that_does_not_read_is_closed_when_patience_is_over) {
    Client reads = connect(GetParam());
    reads.send(get("/big"));
    EXPECT_TRUE(until([&] { return reads.has_heard("200 OK"); }));
    settle();
    server->finish({});
    EXPECT_TRUE(until([&] { return reads.is_closed(); }));
    EXPECT_LT(reads.heard().size(), std::size_t{16 << 20});
}

TEST_F(HttpServer, clients_above_the_quota_wait_in_the_kernels_queue_until_others_are_answered) {
    ServerLimits limits;
    limits.local.connections = 2;
    begin(limits);
    std::vector<Client> clients;
    for (int i = 0; i < 12; ++i) {
        clients.push_back(connect());
        clients.back().send(get("/short?n=late"));
    }
    for (Client& client : clients) EXPECT_TRUE(until([&] { return client.has_heard("late"); }));
}

TEST_P(HttpServer, many_clients_share_one_response_text) {
    auto all = std::make_shared<const std::string>(std::string(8 << 20, 'z') + "end");
    server->routes().add("GET", "/shared", [&all](const Request&) {
        Response response = text("begin");
        response.shared = all;
        return response;
    });
    std::vector<Client> clients;
    for (int i = 0; i < 3; ++i) {
        clients.push_back(connect(GetParam()));
        clients.back().send(get("/shared") + get("/short?n=next"));
    }
    EXPECT_TRUE(until([&] { return all.use_count() == 4; })) << "who does not read holds no text of his own";
    for (Client& client : clients) {
        EXPECT_TRUE(until([&] { return client.has_heard("next"); }));
        const std::string& heard = client.heard();
        EXPECT_NE(heard.find("Content-Length: 8388616\r\n"), std::string::npos);
        const std::size_t body = heard.find("\r\n\r\n") + 4;
        EXPECT_EQ(heard.substr(body, 6), "beginz");
        EXPECT_EQ(heard.substr(body + 8'388'616 - 4, 12), "zendHTTP/1.1");
    }
    EXPECT_EQ(all.use_count(), 1);
    EXPECT_TRUE(answer("HEAD /shared HTTP/1.1\r\nConnection: close\r\n\r\n").ends_with("\r\n\r\n"));
}

TEST_P(HttpServer, streams_parts_as_they_become_available) {
    Client client = connect(GetParam());
    source.ready = 2;
    source.part_size = 3;
    client.send(get("/stream"));
    EXPECT_TRUE(until([&] { return client.has_heard("\r\n\r\n3\r\nxxx\r\n3\r\nxxx\r\n"); })) << client.heard();
    EXPECT_TRUE(client.has_heard("Transfer-Encoding: chunked"));
    client.heard().clear();
    source.ready = 1;
    source.wake();
    source.wake();
    EXPECT_TRUE(until([&] { return client.has_heard("3\r\nxxx\r\n"); }));
    client.send(get("/short?n=next"));
    settle();
    EXPECT_FALSE(client.has_heard("next")) << "until the stream has ended";
    source.ends = true;
    source.wake();
    EXPECT_TRUE(until([&] { return client.has_heard("0\r\n\r\nHTTP/1.1 200 OK") && client.has_heard("next"); }))
        << client.heard();
    EXPECT_TRUE(source.gone);
    source.wake();    // at any later time
    settle();
}

TEST_F(HttpServer, a_stream_of_http_1_0_ends_with_the_connection) {
    source.ready = 2;
    source.ends = true;
    const std::string all = answer("GET /stream HTTP/1.0\r\nConnection: keep-alive\r\n\r\n");
    EXPECT_TRUE(all.ends_with("\r\n\r\nxx")) << all;
    EXPECT_EQ(all.find("keep-alive"), std::string::npos) << all;
    const std::string head = answer("HEAD /stream HTTP/1.1\r\nConnection: close\r\n\r\n");
    EXPECT_TRUE(head.ends_with("\r\n\r\n")) << head;
}

TEST_P(HttpServer, a_producer_is_called_as_fast_as_the_client_reads) {
    Client client = connect(GetParam());
    source.part_size = 64 * 1024;
    source.ready = 1 << 20;
    client.send(get("/stream"));
    int before = -1;
    ASSERT_TRUE(until([&] { return std::exchange(before, source.asked) == source.asked && source.asked > 0; }));
    EXPECT_LT(source.asked, 400) << "what the sockets hold, and one";
    const int stopped = source.asked;
    EXPECT_TRUE(until([&] { return client.heard().size() > (40u << 20); }));
    EXPECT_GT(source.asked, stopped);
    client.leave();
    EXPECT_TRUE(until([&] { return source.gone; }));
}

// The client closes its sending half at once, as some programs do.
TEST_P(HttpServer, a_part_may_take_several_turns_of_the_loop) {
    source.part_size = 0;
    source.ready = 20;
    source.ends = true;
    Client client = connect(GetParam());
    client.send(get("/stream"));
    client.end_output();
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
    EXPECT_EQ(source.asked, 21);
    EXPECT_TRUE(client.heard().ends_with("\r\n0\r\n\r\n")) << client.heard();
}

TEST_P(HttpServer, a_waiting_producer_is_destroyed_when_its_client_disconnects) {
    Client client = connect(GetParam());
    client.send(get("/stream"));
    ASSERT_TRUE(until([&] { return source.asked == 1; }));
    client.leave();
    EXPECT_TRUE(until([&] { return source.gone; }));
}

TEST_P(ImpatientHttpServer, a_stream_that_is_not_read_is_closed_and_one_without_data_is_not) {
    Client client = connect(GetParam());
    client.send(get("/stream"));
    ASSERT_TRUE(until([&] { return source.asked == 1; }));
    const auto begin = std::chrono::steady_clock::now();
    until([&] { return std::chrono::steady_clock::now() - begin > 300ms; });
    EXPECT_FALSE(source.gone);
    source.part_size = 64 * 1024;
    source.ready = 1 << 20;
    source.wake();
    EXPECT_TRUE(until([&] { return source.gone; }));
    EXPECT_TRUE(until([&] { return client.is_closed(); }));
}

TEST_P(HttpServer, a_streaming_client_that_sends_many_requests_is_closed) {
    Client client = connect(GetParam());
    client.send(get("/stream"));
    ASSERT_TRUE(until([&] { return source.asked == 1; }));
    EXPECT_TRUE(until([&] { return client.send(get("/short")), client.is_closed(); }));
    EXPECT_TRUE(source.gone);
}

TEST_F(HttpServer, stop_closes_all_connections_at_once) {
    Client streamed = connect(), idle = connect(), half = connect();
    streamed.send(get("/stream"));
    half.send("GET /");
    ASSERT_TRUE(until([&] { return source.asked == 1; }));
    server->stop();
    EXPECT_TRUE(source.gone) << "not when the loop comes to it";
    settle();
    EXPECT_TRUE(streamed.is_closed() && idle.is_closed() && half.is_closed());
}

// The loop learns of the request only after it has accepted the next client.
TEST_F(HttpServer, a_client_that_has_sent_a_request_keeps_its_connection) {
    ServerLimits limits;
    limits.local.connections = 2;
    limits.local.hearing = {};
    begin(limits);
    Client first = connect(), idle = connect();
    settle();
    Client next = connect();
    first.send(get("/short?n=here"));
    EXPECT_TRUE(until([&] { return idle.is_closed() || first.is_closed(); }));
    EXPECT_TRUE(until([&] { return first.is_closed() || first.has_heard("here"); }));
    EXPECT_TRUE(first.has_heard("here"));
}

// One that asks waits for a place; one that has sent nothing has none.
TEST_F(JudgingHttpServer, network_clients_that_send_nothing_use_no_quota) {
    ServerLimits limits;
    limits.network.connections = 2;
    limits.network.hearing = std::chrono::hours{1};
    begin(limits);
    const auto listens = server->start(Server::Network{.address = "127.0.0.1", .needs_token = false});
    ASSERT_TRUE(listens) << listens.error();
    std::vector<Client> silent;
    for (int i = 0; i < 100; ++i)
        silent.emplace_back(UniqueFd{support::connect_tcp(*listens, "127.9.0." + std::to_string(1 + i))});
    settle();
    Client asks{UniqueFd{support::connect_tcp(*listens)}};
    asks.send("GET /short?n=here HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
    EXPECT_TRUE(until([&] { return asks.has_heard("here"); }));
    EXPECT_FALSE(silent.front().is_closed());
}

TEST_F(JudgingHttpServer, of_too_many_silent_clients_those_of_the_address_with_most_are_closed) {
    Client first{UniqueFd{support::connect_tcp(port, "127.9.0.2")}};
    std::vector<Client> crowd;
    for (int i = 0; i < 400; ++i) crowd.emplace_back(UniqueFd{support::connect_tcp(port, "127.9.0.1")});
    const auto closed = [&] { return std::count_if(crowd.begin(), crowd.end(), [](Client& one) { return one.is_closed(); }); };
    EXPECT_TRUE(until([&] { return static_cast<std::size_t>(closed()) >= 401 - NewConnections::places; }));
    EXPECT_EQ(server->evicted().count, 401 - NewConnections::places);
    EXPECT_FALSE(first.is_closed());
    EXPECT_FALSE(crowd.back().is_closed());
    first.send("GET /short?n=here HTTP/1.1\r\nHost: 127.0.0.1\r\n" + bearer("may-act") + "\r\n");
    EXPECT_TRUE(until([&] { return first.has_heard("here"); }));
}

// The loop learns of its request only after it has accepted the others.
TEST_F(JudgingHttpServer, a_client_that_has_sent_a_request_is_not_closed_as_silent) {
    const std::string from = "127.9.0.1";
    Client first{UniqueFd{support::connect_tcp(port, from)}};
    std::vector<Client> crowd;
    while (crowd.size() < NewConnections::places - 1) crowd.emplace_back(UniqueFd{support::connect_tcp(port, from)});
    settle();
    for (int i = 0; i < 10; ++i) crowd.emplace_back(UniqueFd{support::connect_tcp(port, from)});
    first.send("GET /short?n=here HTTP/1.1\r\nHost: 127.0.0.1\r\n" + bearer("may-act") + "\r\n");
    EXPECT_TRUE(until([&] { return first.is_closed() || first.has_heard("here"); }));
    EXPECT_TRUE(first.has_heard("here"));
    EXPECT_TRUE(until([&] { return server->evicted().count >= 9; })) << server->evicted().count;
}

TEST_F(JudgingHttpServer, a_connection_that_is_closed_for_another_is_reset_and_leaves_nothing_in_the_kernel) {
    std::vector<UniqueFd> crowd;
    while (crowd.size() < NewConnections::places + 1) crowd.emplace_back(support::connect_tcp(port, "127.9.0.1"));
    EXPECT_TRUE(until([&] { return server->evicted().count == 1; }));
    char byte;
    EXPECT_EQ(::recv(crowd.front().get(), &byte, 1, MSG_DONTWAIT), -1);
    EXPECT_EQ(errno, ECONNRESET);
}

TEST_F(JudgingHttpServer, waiting_clients_use_at_most_half_of_the_descriptors) {
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
    std::vector<Client> crowd;
    for (int i = 0; i < 200; ++i) crowd.emplace_back(UniqueFd{support::connect_tcp(port, "127.9.1." + std::to_string(1 + i))});
    const auto used = static_cast<rlim_t>(UniqueFd{::dup(STDERR_FILENO)}.get());
    const rlimit few{used + 8 + 80 + 100, before.rlim_max};    // 8 are for own work, 80 for links and their peers
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
    EXPECT_TRUE(until([&] { return server->evicted().count >= 150; })) << server->evicted().count;
    EXPECT_GE(anogate::descriptors_left(), 80u + 50u);
    EXPECT_LE(server->evicted().count, 152u);
    ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
}

}    // namespace
}    // namespace http_server
