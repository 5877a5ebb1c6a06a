// The last log lines of devices: no device displaces lines of another, and the memory is bounded.
#include <devices/device_log.hpp>
#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace device_log_tests {
namespace {

using anogate::DeviceLog;

struct DeviceLogs : testing::Test {
    DeviceLog log;
    std::uint64_t time = 1'000'000'000;

    bool receive(std::uint8_t from, const std::string& text, std::uint8_t color = 0,
                 DeviceLog::Origin origin = DeviceLog::Origin::known) {
        support::Bytes data{color};
        data.insert(data.end(), text.begin(), text.end());
        const support::Bytes bytes = support::frame(from, 0xFF, 0xA0, data);
        return log.receive(ano::FrameView{bytes}, "fc", time += 1'000'000, origin);
    }
    std::size_t size() const {
        std::size_t all = 0;
        for (unsigned a = 0; a < 256; ++a) all += log.lines(static_cast<std::uint8_t>(a)).size();
        return all;
    }
};

TEST_F(DeviceLogs, keep_the_last_500_lines_of_a_device) {
    for (unsigned i = 0; i < 700; ++i) EXPECT_TRUE(receive(0xDC, "line " + std::to_string(i), i % 7 == 0 ? 1 : 2));
    ASSERT_EQ(log.lines(0xDC).size(), 500u);
    EXPECT_EQ(log.lines(0xDC).front().text, "line 200");
    EXPECT_EQ(log.lines(0xDC).back().text, "line 699");
    EXPECT_EQ(log.count(0xDC), 700u);
    EXPECT_EQ(log.red(0xDC), 100u) << "also of those that are forgotten";
    EXPECT_TRUE(log.lines(0xDD).empty());
}

TEST_F(DeviceLogs, of_one_device_do_not_displace_those_of_another) {
    receive(0xDC, "engine failure", 1);
    for (unsigned n = 0; n < 100'000; ++n) receive(static_cast<std::uint8_t>(1 + n % 200), std::string(60'000 / 200, 'x'));
    EXPECT_LE(size(), DeviceLog::max_of_all);
    ASSERT_FALSE(log.lines(0xDC).empty());
    EXPECT_EQ(log.lines(0xDC).front().text, "engine failure");
}

// Any program in a network may be the sender, with the addresses of other devices or that of the vehicle.
TEST_F(DeviceLogs, of_a_known_origin_are_not_displaced_by_others_and_only_their_red_lines_count) {
    for (unsigned i = 0; i < 450; ++i) receive(0xDC, "line " + std::to_string(i), 1);
    for (unsigned n = 0; n < 20'000; ++n)
        receive(static_cast<std::uint8_t>(n % 3 == 0 ? 0xDC : 1 + n % 200), "forged", 1, DeviceLog::Origin::anybody);
    EXPECT_LE(size(), DeviceLog::max_of_all);
    const auto& lines = log.lines(0xDC);
    const auto known = std::count_if(lines.begin(), lines.end(), [](const auto& one) { return one.text != "forged"; });
    EXPECT_EQ(known, 450);
    EXPECT_EQ(lines.front().text, "line 0");
    EXPECT_EQ(log.red(0xDC), 450u);
    EXPECT_EQ(log.red(2), 0u);
    EXPECT_FALSE(log.lines(2).empty()) << "they can be read";
    for (unsigned a = 10; a < 20; ++a)
        for (unsigned i = 0; i < 500; ++i) receive(static_cast<std::uint8_t>(a), "known", 0);
    receive(2, "forged", 1, DeviceLog::Origin::anybody);
    EXPECT_LE(size(), DeviceLog::max_of_all);
    EXPECT_TRUE(log.lines(2).empty()) << "there is only room for those of a known origin";
}

TEST_F(DeviceLogs, are_bounded_in_bytes_and_end_where_the_text_ends) {
    EXPECT_TRUE(receive(0xDC, std::string(60'000, 'x')));
    EXPECT_EQ(log.lines(0xDC).back().text.size(), DeviceLog::max_text);
    EXPECT_TRUE(receive(0xDC, std::string{"ready\r\n\0rest", 12}));
    EXPECT_EQ(log.lines(0xDC).back().text, "ready");
    EXPECT_FALSE(receive(0xFE, "a host")) << "is no device";
    const support::Bytes euler = support::frame(0xDC, 0xFF, 0x03, {0, 0, 0, 0, 0, 0, 0});
    EXPECT_FALSE(log.receive(ano::FrameView{euler}, "fc", time));
    const support::Bytes number = support::frame(0xDC, 0xFF, 0xA1, {0, 0, 0xC0, 0x3F, 'v'});
    EXPECT_TRUE(log.receive(ano::FrameView{number}, "fc", time));
    EXPECT_EQ(log.lines(0xDC).back().value, 1.5f);
    const support::Bytes empty = support::frame(0xDC, 0xFF, 0xA0, {});
    log.receive(ano::FrameView{empty}, "fc", time);
}

}    // namespace
}    // namespace device_log_tests
