// Answers of the control interface that are not available at once.
#include <http/server.hpp>
#include <support/http.hpp>
#include <support/loop.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace http_later_tests {
namespace {

using namespace anogate::http;
using support::Loop;

class LaterAnswers : public testing::Test {
protected:
    LaterAnswers() {
        server.routes().add("POST", "/work", [this](const Request&) {
            return later([this](std::function<void(Response)> respond) { waiting.push_back(std::move(respond)); });
        });
        server.routes().add("POST", "/job", [this](const Request&) {
            Response response = later([this](std::function<void(Response)> respond) { waiting.push_back(std::move(respond)); });
            response.patient = true;
            return response;
        });
        server.routes().add("GET", "/now", [](const Request&) {
            return later([](const std::function<void(Response)>& respond) { respond(error(409, "at once")); });
        });
        EXPECT_EQ(server.start(dir / "socket").error, "");
    }
    ~LaterAnswers() override { server.stop(); }

    int ask(const std::string& request) const {
        const int fd = support::connect_unix(dir / "socket");
        EXPECT_EQ(::send(fd, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
        return fd;
    }
    bool heard(int fd, const std::string& words) {
        std::string& text = heard_[fd];
        return loop.until([&] {
            char buffer[4096];
            if (const ssize_t n = ::recv(fd, buffer, sizeof buffer, MSG_DONTWAIT); n > 0)
                text.append(buffer, static_cast<std::size_t>(n));
            return text.find(words) != std::string::npos;
        });
    }

    support::TempDir dir;
    Loop loop;
    Server server{loop.io};
    std::vector<std::function<void(Response)>> waiting;
    std::map<int, std::string> heard_;    // by client
};

TEST_F(LaterAnswers, are_sent_when_they_are_known_and_others_meanwhile) {
    const int slow = ask("POST /work HTTP/1.1\r\nContent-Length: 0\r\n\r\nGET /now HTTP/1.1\r\n\r\n");
    ASSERT_TRUE(loop.until([&] { return waiting.size() == 1; }));
    const int quick = ask("GET /now HTTP/1.1\r\n\r\n");
    EXPECT_TRUE(heard(quick, "at once"));
    Response response;
    response.status = 422;
    response.body = "faulty";
    waiting[0](std::move(response));
    EXPECT_TRUE(heard(slow, "HTTP/1.1 422 Unprocessable Entity\r\n"));
    EXPECT_TRUE(heard(slow, "at once")) << "what was asked behind it";
    ::close(slow);
    ::close(quick);
}

class Bytes : public Producer {
public:
    explicit Bytes(std::size_t size) : left_{size} {}
    Next next(std::string& into) override {
        into.assign(std::min<std::size_t>(left_, 1000), 'b');
        left_ -= into.size();
        return left_ == 0 ? Next::end : Next::part;
    }

private:
    std::size_t left_;
};

TEST_F(LaterAnswers, of_known_length_are_followed_by_others_unless_they_end_early) {
    const auto answer = [](std::size_t told, std::size_t made) {
        Response response;
        response.length = told;
        response.producer = std::make_unique<Bytes>(made);
        return response;
    };
    server.routes().add("GET", "/whole", [&](const Request&) { return answer(2500, 2500); });
    server.routes().add("GET", "/short", [&](const Request&) { return answer(2500, 1500); });
    server.routes().add("GET", "/long", [&](const Request&) { return answer(2500, 3500); });
    const int fd = ask("GET /whole HTTP/1.1\r\n\r\nGET /now HTTP/1.1\r\n\r\n");
    EXPECT_TRUE(heard(fd, "\r\nContent-Length: 2500\r\n\r\n" + std::string(2500, 'b') + "HTTP/1.1 409 Conflict"));
    ::close(fd);
    for (const char* path : {"/short", "/long"}) {
        const int other = ask("GET " + std::string{path} + " HTTP/1.1\r\n\r\nGET /now HTTP/1.1\r\n\r\n");
        EXPECT_TRUE(loop.until([&] {
            char buffer[4096];
            return ::recv(other, buffer, sizeof buffer, MSG_DONTWAIT) == 0;
        })) << path
            << ": only the end of the connection tells";
        ::close(other);
    }
}

TEST_F(LaterAnswers, that_are_patient_may_take_any_time) {
    SessionLimits impatient;
    impatient.patience = std::chrono::milliseconds{100};
    Server other{loop.io, {.session = impatient}};
    auto needed = std::make_shared<int>();
    const std::weak_ptr<int> still = needed;
    other.routes().add("POST", "/job", [&](const Request&) {
        Response response = later([this](std::function<void(Response)> respond) { waiting.push_back(std::move(respond)); });
        response.patient = true;
        response.needed = std::exchange(needed, nullptr);
        return response;
    });
    ASSERT_EQ(other.start(dir / "other").error, "");
    const std::string request = "POST /job HTTP/1.1\r\nContent-Length: 0\r\n\r\n";
    const int fd = support::connect_unix(dir / "other");
    ASSERT_EQ(::send(fd, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
    ASSERT_TRUE(loop.until([&] { return waiting.size() == 1; }));
    const auto until = std::chrono::steady_clock::now() + 3 * impatient.patience;
    loop.until([&] { return std::chrono::steady_clock::now() >= until; });
    EXPECT_FALSE(still.expired());
    waiting[0](error(409, "at last"));
    EXPECT_TRUE(heard(fd, "at last"));
    EXPECT_TRUE(still.expired());
    needed = std::make_shared<int>();
    const std::weak_ptr<int> again = needed;
    ASSERT_EQ(::send(fd, request.data(), request.size(), MSG_NOSIGNAL), static_cast<ssize_t>(request.size()));
    ASSERT_TRUE(loop.until([&] { return waiting.size() == 2; }));
    EXPECT_FALSE(again.expired());
    ::close(fd);
    EXPECT_TRUE(loop.until([&] { return again.expired(); })) << "who left needs nothing any more";
    waiting[1](error(409, "nobody"));
    other.stop();
}

TEST_F(LaterAnswers, followed_by_too_many_request_bytes_end_with_an_error) {
    const int fd = ask("POST /job HTTP/1.1\r\nContent-Length: 0\r\n\r\n");
    ASSERT_TRUE(loop.until([&] { return waiting.size() == 1; }));
    const std::string more(20'000, 'x');
    EXPECT_EQ(::send(fd, more.data(), more.size(), MSG_NOSIGNAL), static_cast<ssize_t>(more.size()));
    EXPECT_TRUE(heard(fd, "HTTP/1.1 431 Request Header Fields Too Large\r\n"));
    EXPECT_TRUE(heard(fd, "more than 8192 bytes were received after a request that is not answered yet"));
    waiting[0](error(409, "nobody"));
    ::close(fd);
}

TEST_F(LaterAnswers, are_waited_for_at_the_shutdown_until_no_more_are_produced) {
    const int in_time = ask("POST /job HTTP/1.1\r\nContent-Length: 0\r\n\r\n");
    const int in_vain = ask("POST /job HTTP/1.1\r\nContent-Length: 0\r\n\r\n");
    ASSERT_TRUE(loop.until([&] { return waiting.size() == 2; }));
    const auto is_closed = [](int fd) {
        char byte = 0;
        return ::recv(fd, &byte, 1, MSG_DONTWAIT | MSG_PEEK) == 0;
    };
    server.finish({});
    loop.turn();
    EXPECT_FALSE(is_closed(in_time));
    waiting[0](error(409, "in time"));
    EXPECT_TRUE(heard(in_time, "in time"));
    EXPECT_TRUE(loop.until([&] { return is_closed(in_time); }));
    EXPECT_FALSE(is_closed(in_vain));
    server.no_more_answers();
    EXPECT_TRUE(loop.until([&] { return is_closed(in_vain); }));
    ::close(in_time);
    ::close(in_vain);
}

TEST_F(LaterAnswers, for_closed_clients_are_discarded) {
    const int gone = ask("POST /work HTTP/1.1\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    ASSERT_TRUE(loop.until([&] { return waiting.size() == 1; }));
    ::close(gone);
    waiting[0](error(500, "nobody"));
    const int other = ask("GET /now HTTP/1.1\r\n\r\n");
    EXPECT_TRUE(heard(other, "at once"));
    const int last = ask("POST /work HTTP/1.1\r\nContent-Length: 0\r\n\r\n");
    ASSERT_TRUE(loop.until([&] { return waiting.size() == 2; }));
    server.stop();
    waiting[1](error(500, "the server has gone"));
    loop.turn();
    ::close(other);
    ::close(last);
}

}    // namespace
}    // namespace http_later_tests
