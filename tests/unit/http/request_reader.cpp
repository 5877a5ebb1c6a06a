#include <http/request_reader.hpp>

#include <gtest/gtest.h>

namespace anogate::http::request_reader_tests {
namespace {

/// Passes all of `bytes`, `step` of them at a time, together with those that were not consumed; returns the rest.
std::string put(RequestReader& reader, std::string bytes, std::size_t step = 1 << 20) {
    std::string came;
    while (!bytes.empty() && !reader.is_done() && !reader.fault()) {
        came += bytes.substr(0, step);
        bytes.erase(0, step);
        came.erase(0, reader.put(came));
    }
    return came + bytes;
}

const std::string question = "POST /gpio?n=1 HTTP/1.1\r\nHost: x\r\nContent-Length: 4\r\n\r\nbody";

TEST(RequestReader, reads_a_request_however_it_is_cut) {
    for (const std::size_t step : {1u, 2u, 7u, 1000u}) {
        RequestReader reader{{}};
        EXPECT_EQ(put(reader, question + "GET", step).substr(0, 3), "GET") << "which is the next one's";
        ASSERT_TRUE(reader.is_done());
        const Request request = reader.pop_request();
        EXPECT_EQ(request.method, "POST");
        EXPECT_EQ(request.target, "/gpio?n=1");
        EXPECT_EQ(request.body, "body");
        EXPECT_EQ(request.version, 11u);
        EXPECT_TRUE(request.keep_alive);
        EXPECT_EQ(request.header("host"), "x");
    }
}

TEST(RequestReader, preserves_changes_of_the_head_made_before_the_body) {
    RequestReader reader{{}, [](Request& head) {
                             EXPECT_EQ(head.body_length, 4u);
                             head.user = 7;
                             return std::optional<std::uint64_t>{4};
                         }};
    EXPECT_EQ(put(reader, question, 5), "");
    ASSERT_TRUE(reader.is_done());
    const Request request = reader.pop_request();
    EXPECT_EQ(request.user, 7u);
    EXPECT_EQ(request.header("Host"), "x");
    EXPECT_EQ(request.body, "body");
    EXPECT_EQ(request.body_length, 0u) << "all of it is here";
}

TEST(RequestReader, reads_a_body_in_chunks) {
    const std::string head = "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n";
    for (const std::string end :
         {"0\r\n\r\n", "0;why=not\r\n\r\n", "00\r\nDigest: 1\r\nEtag: 2\r\n\r\n", "0\r\nno field\r\n\r\n"})
        for (const std::size_t step : {1u, 2u, 3u, 1000u}) {
            RequestReader reader{{}};
            EXPECT_EQ(put(reader, head + "3\r\nabc\r\n1\r\nd\r\n" + end + "GET /", step), "GET /") << end;
            ASSERT_TRUE(reader.is_done()) << end;
            EXPECT_EQ(reader.pop_request().body, "abcd");

            RequestReader empty{{}};
            EXPECT_EQ(put(empty, head + end + "GET /", step), "GET /") << end;
            EXPECT_TRUE(empty.is_done()) << end;
        }
}

TEST(RequestReader, never_reads_a_body_of_unknown_coding_as_a_request) {
    for (const std::string coding : {"gzip", "identity", "xchunked", "\"chunked\"", "chunked, gzip", "chunked, chunked"})
        for (const std::size_t step : {1u, 1000u}) {
            RequestReader reader{{}};
            put(reader, "POST / HTTP/1.1\r\nTransfer-Encoding: " + coding + "\r\n\r\nGET / HTTP/1.1\r\n\r\n", step);
            ASSERT_TRUE(reader.fault()) << coding;
            EXPECT_EQ(reader.fault()->status, 400u);
        }
    RequestReader old{{}};
    put(old, "POST / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n");
    EXPECT_TRUE(old.fault());
}

TEST(RequestReader, limits_chunk_sizes_and_trailers_like_a_header) {
    for (const std::string begin : {"0\r\nx: ", "1;a=", "0;a=", "000"}) {
        RequestReader reader{{.header = 200, .body = 10}};
        put(reader, "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n" + begin + std::string(250, '0'), 50);
        ASSERT_TRUE(reader.fault()) << begin;
    }
    RequestReader reader{{.header = 200, .body = 10}};
    EXPECT_EQ(put(reader, "GET / HTTP/1.1\r\n\r\n" + std::string(1000, 'x')).size(), 1000u) << "the next requests are another's";
    EXPECT_TRUE(reader.is_done());
}

TEST(RequestReader, detects_whether_the_connection_stays_open) {
    for (const auto& [text, stays] : {std::pair{"GET / HTTP/1.0\r\n\r\n", false},
                                      {"GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n", true},
                                      {"GET / HTTP/1.1\r\nConnection: close\r\n\r\n", false},
                                      {"GET / HTTP/1.1\r\n\r\n", true}}) {
        RequestReader reader{{}};
        put(reader, text);
        ASSERT_TRUE(reader.is_done()) << text;
        EXPECT_EQ(reader.pop_request().keep_alive, stays) << text;
    }
}

unsigned status_of(const std::string& text, std::size_t step = 1 << 20) {
    RequestReader reader{{.header = 200, .body = 10}};
    put(reader, text, step);
    return reader.fault() ? reader.fault()->status : 0;
}

TEST(RequestReader, rejects_requests_that_are_too_large) {
    EXPECT_EQ(status_of("GET / HTTP/1.1\r\nX: " + std::string(200, 'x') + "\r\n\r\n"), 431u);
    EXPECT_EQ(status_of("GET / HTTP/1.1\r\nX: " + std::string(200, 'x') + "\r\n\r\n", 1), 431u);
    EXPECT_EQ(status_of("GET /" + std::string(300, 'x')), 431u);
    EXPECT_EQ(status_of("POST / HTTP/1.1\r\nContent-Length: 11\r\n\r\n"), 413u) << "before it comes";
    EXPECT_EQ(status_of("POST / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n"), 413u);
    EXPECT_EQ(status_of("POST / HTTP/1.1\r\nContent-Length: 10\r\n\r\n"), 0u);
    EXPECT_EQ(status_of("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nb\r\n01234567890\r\n0\r\n\r\n"), 413u);
}

TEST(RequestReader, accepts_a_body_up_to_the_limit_for_its_head) {
    const auto limit = [](const Request& head) -> std::uint64_t {
        return head.target == "/file" && head.header("A") == "b" ? 1000 : 10;
    };
    for (const std::size_t step : {1u, 7u, 5000u}) {
        for (const auto& [target, fits] : {std::pair{"/file", true}, std::pair{"/other", false}}) {
            const std::string head = "POST " + std::string{target} + " HTTP/1.1\r\nA: b\r\n";
            RequestReader whole{{.header = 200, .body = 10}, limit};
            put(whole, head + "Content-Length: 1000\r\n\r\n" + std::string(1000, 'x'), step);
            EXPECT_EQ(whole.fault() ? whole.fault()->status : 200u, fits ? 200u : 413u) << target;
            EXPECT_EQ(whole.is_done(), fits);
            RequestReader chunked{{.header = 200, .body = 10}, limit};
            const std::string chunk = "1f4\r\n" + std::string(500, 'x') + "\r\n";
            put(chunked, head + "Transfer-Encoding: chunked\r\n\r\n" + chunk + chunk + "0\r\n\r\n", step);
            EXPECT_EQ(chunked.fault() ? chunked.fault()->status : 200u, fits ? 200u : 413u) << target;
            if (fits) {
                ASSERT_TRUE(chunked.is_done());
                EXPECT_EQ(chunked.pop_request().body.size(), 1000u);
            }
            RequestReader beyond{{.header = 200, .body = 10}, limit};
            put(beyond, head + "Content-Length: 1001\r\n\r\n", step);
            EXPECT_EQ(beyond.fault() ? beyond.fault()->status : 200u, 413u);
        }
    }
}

TEST(RequestReader, returns_a_body_in_parts_while_it_is_received) {
    for (const std::string& head :
         {std::string{"Content-Length: 1000\r\n\r\n"}, std::string{"Transfer-Encoding: chunked\r\n\r\n3e8\r\n"}}) {
        RequestReader reader{{.header = 200, .body = 1000}};
        std::string text = "POST / HTTP/1.1\r\n" + head, body;
        for (int i = 0; i < 1000; ++i) text += static_cast<char>('a' + i % 26);
        const std::string sent = text.substr(text.size() - 1000);
        if (head.starts_with("Transfer")) text += "\r\n0\r\n\r\n";
        std::string came;
        while (!reader.is_done() && !text.empty()) {
            came += text.substr(0, 7);
            text.erase(0, 7);
            came.erase(0, reader.put(came));
            if (reader.body_size() >= 50) body += reader.pop_body();
            ASSERT_LT(reader.body_size(), 60u);
        }
        ASSERT_TRUE(reader.is_done());
        EXPECT_EQ(body + reader.pop_request().body, sent);
    }
}

TEST(RequestReader, rejects_invalid_requests) {
    for (const char* bad : {"\x01\x02 HELLO\r\n\r\n", "GET\r\n\r\n", "GET / HTTP/2.0\r\n\r\n", "GET / XTTP/1.1\r\n\r\n",
                            "GET / HTTP/1.1\r\nno colon\r\n\r\n", "POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n",
                            "POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n",
                            "POST / HTTP/1.1\r\nContent-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n",
                            "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n"}) {
        EXPECT_EQ(status_of(bad), 400u) << bad;
        EXPECT_EQ(status_of(bad, 1), 400u) << bad;
    }
}

}    // namespace
}    // namespace anogate::http::request_reader_tests
