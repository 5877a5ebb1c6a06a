#include <http/client/response_reader.hpp>

#include <gtest/gtest.h>

namespace anogate::http::response_reader_tests {
namespace {

/// Passes all of `bytes`, `step` of them at a time, until the reader is done or has a fault; returns the body.
std::string body_of(ResponseReader& reader, std::string bytes, std::size_t step = 1 << 20) {
    std::string came, body;
    while (!bytes.empty() && !reader.is_done() && reader.fault().empty()) {
        came += bytes.substr(0, step);
        bytes.erase(0, step);
        came.erase(0, reader.put(came));
        if (reader.has_head()) body += reader.pop_body();
    }
    return body;
}

const std::string ok = "HTTP/1.1 200 OK\r\nServer: anogate\r\n";

TEST(ResponseReader, reads_a_response_however_it_is_cut) {
    for (const std::size_t step : {1u, 2u, 7u, 1000u}) {
        ResponseReader reader;
        EXPECT_EQ(body_of(reader, ok + "Content-Length: 4\r\n\r\nbodymore", step), "body") << step;
        EXPECT_TRUE(reader.is_done());
        EXPECT_EQ(reader.status(), 200u);
        EXPECT_EQ(reader.headers(), (std::vector<Field>{{"Server", "anogate"}, {"Content-Length", "4"}}));
    }
}

TEST(ResponseReader, returns_the_body_of_a_stream_as_it_arrives) {
    ResponseReader reader;
    EXPECT_EQ(body_of(reader, ok + "Transfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n2\r\nd"), "abcd");
    EXPECT_EQ(reader.pop_body(), "");
    EXPECT_FALSE(reader.is_done());
    EXPECT_EQ(body_of(reader, "e\r\n1\r\nf\r\n"), "ef");
    EXPECT_FALSE(reader.is_done());
}

TEST(ResponseReader, detects_the_end_of_a_stream) {
    for (const std::string end :
         {"0\r\n\r\n", "0;why=not\r\n\r\n", "00\r\nDigest: 1\r\nEtag: 2\r\n\r\n", "0\r\nno field\r\n\r\n"})
        for (const std::size_t step : {1u, 2u, 3u, 1000u})
            for (const std::string chunks : {"", "3\r\nabc\r\n"}) {
                ResponseReader reader;
                EXPECT_EQ(body_of(reader, ok + "Transfer-Encoding: chunked\r\n\r\n" + chunks + end, step),
                          chunks.empty() ? "" : "abc");
                EXPECT_TRUE(reader.is_done()) << end << step;
            }
}

TEST(ResponseReader, reads_a_body_without_a_length_up_to_the_end_of_the_connection) {
    ResponseReader reader;
    EXPECT_EQ(body_of(reader, "HTTP/1.0 200 OK\r\n\r\nbody"), "body");
    EXPECT_FALSE(reader.is_done());
    reader.end();
    EXPECT_TRUE(reader.is_done());
}

TEST(ResponseReader, rejects_a_truncated_response) {
    for (const std::string& part :
         {std::string{}, ok, ok + "Content-Length: 4\r\n\r\nbod", ok + "Transfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n"}) {
        ResponseReader reader;
        body_of(reader, part);
        EXPECT_EQ(reader.fault(), "") << part;
        reader.end();
        EXPECT_NE(reader.fault(), "") << part;
        EXPECT_FALSE(reader.is_done());
    }
}

TEST(ResponseReader, rejects_bytes_that_are_not_a_response) {
    for (const std::string& bytes :
         {std::string{"SSH-2.0-OpenSSH_9.2p1\r\n\r\n"}, std::string{"HTTP/2.0 200 OK\r\n\r\n"}, ok + "Content-Length: -1\r\n\r\n",
          ok + "Transfer-Encoding: chunked\r\n\r\nxyz\r\nabc\r\n", std::string(100, '\0')})
        for (const std::size_t step : {1u, 1000u}) {
            ResponseReader reader;
            body_of(reader, bytes, step);
            reader.end();
            EXPECT_NE(reader.fault(), "") << bytes;
        }
}

TEST(ResponseReader, stores_no_more_than_its_limits_and_the_received_bytes) {
    ResponseReader long_head{1000};
    body_of(long_head, ok + "X: " + std::string(2000, 'x'), 100);
    EXPECT_NE(long_head.fault(), "");

    ResponseReader long_line{1000};
    body_of(long_line, ok + "Transfer-Encoding: chunked\r\n\r\n5;" + std::string(5000, 'x'), 100);
    EXPECT_NE(long_line.fault(), "");

    ResponseReader promised;    // no memory is reserved for an announced length
    EXPECT_EQ(body_of(promised, ok + "Content-Length: 9223372036854775807\r\n\r\nab"), "ab");
    EXPECT_EQ(promised.fault(), "");
}

}    // namespace
}    // namespace anogate::http::response_reader_tests
