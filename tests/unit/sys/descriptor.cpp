#include <sys/asio.hpp>
#include <sys/descriptor.hpp>

#include <support/loop.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

namespace descriptor_tests {
namespace {

using anogate::Descriptor;
using anogate::UniqueFd;

struct DescriptorInLoop : testing::Test {
    DescriptorInLoop() {
        std::array<int, 2> ends{};
        if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0) ADD_FAILURE();
        descriptor.open(UniqueFd{ends[0]});
        there = UniqueFd{ends[1]};
    }
    /// Makes it readable, and runs the resulting calls.
    void send() {
        EXPECT_EQ(::write(there.get(), "x", 1), 1);
        for (int i = 0; i < 3; ++i) loop.turn();
    }
    void read() {
        ++calls;
        char byte = 0;
        EXPECT_EQ(::read(descriptor.fd(), &byte, 1), 1) << "called for nothing";
    }

    support::Loop loop;
    Descriptor descriptor{loop.io};
    UniqueFd there;
    int calls = 0;
};

TEST_F(DescriptorInLoop, calls_each_time_there_is_something_to_read) {
    descriptor.read_with([this] { read(); });
    for (int said = 1; said <= 3; ++said) {
        send();
        EXPECT_EQ(calls, said);
    }
}

TEST_F(DescriptorInLoop, does_not_call_after_reading_is_stopped) {
    descriptor.read_with([this] { read(); });
    loop.turn();
    descriptor.stop_reading();
    send();
    EXPECT_EQ(calls, 0);
}

TEST_F(DescriptorInLoop, calls_once_each_time_after_reading_was_stopped_and_restarted) {
    for (int i = 0; i < 3; ++i) {
        descriptor.stop_reading();
        descriptor.read_with([this] { read(); });
        loop.turn();
    }
    for (int said = 1; said <= 3; ++said) {
        send();
        EXPECT_EQ(calls, said);
    }
}

}    // namespace
}    // namespace descriptor_tests
