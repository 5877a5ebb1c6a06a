// A thread writes the reports; in place of the device is a socket that receives each of them separately.
#include <link/hid/hid_writer.hpp>
#include <support/bytes.hpp>
#include <support/loop.hpp>

#include <gtest/gtest.h>

#include <sys/socket.h>

#include <algorithm>
#include <numeric>

namespace hid_writer_tests {
namespace {

using anogate::HidWriter;
using anogate::UniqueFd;
using support::Bytes;

class HidDeviceWriter : public testing::Test {
protected:
    void SetUp() override {
        int ends[2];
        ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends), 0);
        ours = UniqueFd{ends[0]};
        device = UniqueFd{ends[1]};
        ASSERT_TRUE(writer.open(ours.get(), 64).has_value());
    }
    ssize_t write(const Bytes& bytes) {
        const iovec piece{const_cast<std::uint8_t*>(bytes.data()), bytes.size()};
        return writer.write_some({&piece, 1});
    }
    /// The next report with its number; empty: there is none.
    Bytes next_report() const {
        Bytes report(100);
        const ssize_t n = ::recv(device.get(), report.data(), report.size(), MSG_DONTWAIT);
        report.resize(n < 0 ? 0 : static_cast<std::size_t>(n));
        return report;
    }
    /// Waits for `size` bytes of the stream.
    Bytes stream_of(std::size_t size) {
        Bytes stream;
        EXPECT_TRUE(loop.until([&] {
            for (Bytes report = next_report(); !report.empty(); report = next_report()) {
                EXPECT_EQ(report.size(), 65u);
                EXPECT_EQ(report[0], 0) << "devices without report ids";
                EXPECT_LE(report[1], 32);
                const auto bytes = report.begin() + 2;
                stream.insert(stream.end(), bytes, bytes + report[1]);
                EXPECT_TRUE(std::all_of(bytes + report[1], report.end(), [](std::uint8_t byte) { return byte == 0; }));
            }
            return stream.size() >= size;
        }));
        return stream;
    }
    static Bytes numbered(std::size_t size) {
        Bytes bytes(size);
        std::iota(bytes.begin(), bytes.end(), std::uint8_t{1});
        return bytes;
    }

    support::Loop loop;
    UniqueFd ours, device;
    HidWriter writer{loop.io};
};

TEST_F(HidDeviceWriter, splits_the_stream_into_reports) {
    const Bytes bytes = numbered(100);
    ASSERT_EQ(write(bytes), 100);
    EXPECT_EQ(stream_of(100), bytes);
}

TEST_F(HidDeviceWriter, never_blocks_and_goes_on_when_the_device_takes_reports_again) {
    Bytes sent;
    for (;;) {
        const Bytes bytes = numbered(200);
        const ssize_t n = write(bytes);
        if (n <= 0) break;
        sent.insert(sent.end(), bytes.begin(), bytes.begin() + n);
        ASSERT_LT(sent.size(), 1'000'000u);
    }
    EXPECT_EQ(errno, EAGAIN);
    EXPECT_TRUE(writer.has_unsent());
    bool can_go_on = false;
    writer.when_writable([&] { can_go_on = true; });
    EXPECT_EQ(stream_of(sent.size()), sent);
    EXPECT_TRUE(loop.until([&] { return can_go_on; }));
    EXPECT_GT(write(numbered(1)), 0);
}

TEST_F(HidDeviceWriter, closes_the_device_after_its_own_end_although_the_device_takes_nothing) {
    while (write(numbered(200)) > 0) {}
    writer.close();
    ours = UniqueFd{};
    EXPECT_TRUE(loop.until([&] {
        Bytes byte(100);
        return ::recv(device.get(), byte.data(), byte.size(), MSG_DONTWAIT) == 0;    // after what was sent
    }));
}

TEST_F(HidDeviceWriter, counts_reports_that_fail_and_ends_no_link_for_them) {
    device = UniqueFd{};
    ASSERT_EQ(write(numbered(3)), 3);
    EXPECT_TRUE(loop.until([&] { return writer.failed_reports() == 1; }));
    ASSERT_EQ(write(numbered(3)), 3);
    EXPECT_TRUE(loop.until([&] { return writer.failed_reports() == 2; }));
}

}    // namespace
}    // namespace hid_writer_tests
