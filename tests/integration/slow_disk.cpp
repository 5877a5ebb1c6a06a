// Recordings on a disk that really is slow, a FUSE file system: the reports in status, metrics and log, and their times by the
// clock of the gateway.
#include <support/recorded_files.hpp>
#include <support/recording_gateway.hpp>
#include <support/sanitized.hpp>
#include <support/slow_disk.hpp>

#include <gtest/gtest.h>

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <functional>
#include <iomanip>
#include <sstream>
#include <string>

#ifndef SLOW_DISK
#define SLOW_DISK ""    // built without FUSE
#endif

namespace slow_disk_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using nlohmann::json;
using LogTime = std::chrono::system_clock::time_point;

constexpr auto slow_reported_within = 1500ms * (sanitized ? 3 : 1);    // one second, plus a margin for a busy machine
constexpr int large_at_once = 10;                                      // in a datagram

/// The largest frame that the default of max_data accepts.
Bytes large_numbered(int number) {
    Bytes data(4096, 0x55);
    for (std::size_t i = 0; i < 4; ++i) data[i] = static_cast<std::uint8_t>(number >> 8 * i);
    return frame(0xDC, 0xFF, 0xF1, data);
}

class SlowDisks : public RecordingGateway {
protected:
    void SetUp() override {
        if (!disk.why_not().empty()) GTEST_SKIP() << disk.why_not();
        start(R"(, "record": {"folder": ")" + folder + R"(", "free": 0})", R"(, ")" + b.link("b") + R"(,queue=200000")");
        send_numbered(20);
        ASSERT_TRUE(until([](const json& running) { return running.at("frames") == 20; }));
        name = running().at("name");
        ASSERT_TRUE(until_heard([&] { return read_frames() == 20; }));
    }
    void TearDown() override {
        disk.be_fast();    // otherwise the gateway can't be killed during a write
        gateway.reset();
    }
    json running() const { return gateway->status().at("recording").at("running").at(0); }
    bool until(const std::function<bool(const json&)>& holds) const {
        return gateway->until([&](const json& status) { return holds(status.at("recording").at("running").at(0)); });
    }
    bool until_error(const std::string& words) const {
        return until([&](const json& running) { return running.at("error").get<std::string>().starts_with(words); });
    }
    /// Large frames from one link to the other, as fast as they are received there.
    void send_large(int count) {
        for (const int end = sent_ + count; came < end;) {
            if (sent_ < end && sent_ - came < large_at_once) {
                Bytes datagram;
                for (int i = 0; i < large_at_once && sent_ < end; ++i) datagram = std::move(datagram) + large_numbered(sent_++);
                send(datagram);
            }
            const int before = came;
            ASSERT_TRUE(until_heard([&] { return read_frames() > before; })) << "frame " << came << " did not come";
        }
    }
    bool until_heard(const std::function<bool()>& holds) const {
        return wait_until(holds, patience, [&] {
            pollfd datagram{b.fd(), POLLIN, 0};
            ::poll(&datagram, 1, 10);
        });
    }
    /// Returns the number of frames received so far; checks their order.
    int read_frames() {
        for (const Bytes& frame : b.frames()) {
            EXPECT_EQ(number_of(frame), came);
            came = number_of(frame) + 1;
        }
        return came;
    }
    double metric(const std::string& metric) const {
        const std::string all = ask("GET", "/metrics").body;
        const std::size_t at = all.find("\n" + metric + " ");
        return at == std::string::npos ? -1 : std::stod(all.substr(at + metric.size() + 2));
    }
    /// The time at which the gateway logged the line with these words.
    LogTime logged(const std::string& words) const {
        if (!gateway->until_says(words)) {
            ADD_FAILURE() << "not logged: " << words << '\n' << gateway->output();
            return {};
        }
        const std::string& log = gateway->output();
        std::istringstream line{log.substr(log.rfind('\n', log.find(words)) + 1)};
        std::tm time{};
        char point = 0;
        int ms = 0;
        line >> std::get_time(&time, "%Y-%m-%d %H:%M:%S") >> point >> ms;
        EXPECT_TRUE(line) << log;
        time.tm_isdst = -1;
        return std::chrono::system_clock::from_time_t(std::mktime(&time)) + std::chrono::milliseconds{ms};
    }
    static LogTime time_of(const KeptItem& item) {
        return LogTime{std::chrono::duration_cast<LogTime::duration>(std::chrono::nanoseconds{item.time_ns})};
    }
    RecordedFiles files() const { return recorded_files(folder, name); }

    SlowDisk disk{SLOW_DISK, folder};
    UdpPeer b;
    std::string name;
    int came = 0;    // received at b
};

TEST_F(SlowDisks, slower_than_the_data_are_reported_within_a_second_and_lost_frames_are_counted) {
    disk.take_a_write_in(200ms);
    const auto lost = [&] { return running().at("not_written").get<int>(); };
    while (sent_ < 12'000 && lost() == 0) ASSERT_NO_FATAL_FAILURE(send_large(500));    // 17 MiB fit; at most 50 MB are sent
    ASSERT_TRUE(until_error("the disk is too slow; frames are being lost")) << running();
    EXPECT_EQ(metric("anogate_recording_failing"), 1);
    EXPECT_GT(metric("anogate_recording_not_written_total"), 0);
    const LogTime told = logged(
        "the disk is too slow; frames are being lost; frames are still forwarded, but not all are recorded");
    ASSERT_NO_FATAL_FAILURE(send_large(200));
    EXPECT_EQ(metric("anogate_recording_failing"), 1);
    disk.be_fast();
    ASSERT_TRUE(until([&](const json& now) { return now.at("frames").get<int>() + now.at("not_written").get<int>() == sent_; }))
        << running();
    const int lost_until_then = lost();
    ASSERT_NO_FATAL_FAILURE(send_large(200));
    const json ended = end(name);
    EXPECT_EQ(ended.at("not_written"), lost_until_then) << "it is fast again";
    EXPECT_EQ(ended.at("frames").get<int>() + lost_until_then, sent_);
    EXPECT_EQ(metric("anogate_recording_not_written_total"), lost_until_then);
    const RecordedFiles written = files();
    EXPECT_TRUE(written.are_whole());
    EXPECT_EQ(written.lost, static_cast<std::uint64_t>(lost_until_then));
    EXPECT_EQ(written.numbers.size() + written.lost, static_cast<std::size_t>(sent_));
    EXPECT_TRUE(std::is_sorted(written.numbers.begin(), written.numbers.end()));
    const auto& items = written.files.at(0).items;
    const auto loss = std::find_if(items.begin(), items.end(), [](const KeptItem& item) { return item.lost > 0; });
    ASSERT_TRUE(loss != items.end() && loss != items.begin());
    EXPECT_LT((told - time_of(loss[-1])) / 1ms, slow_reported_within / 1ms) << "since the last frame before the loss";
}

TEST_F(SlowDisks, of_16_KB_a_second_are_reported_within_a_second_and_lose_nothing) {
    disk.take_a_second(16'000);
    ASSERT_NO_FATAL_FAILURE(send_large(50));    // 12 s
    ASSERT_TRUE(disk.until_it_is_slow());
    ASSERT_TRUE(until_error("the disk has written nothing for ")) << running();
    EXPECT_EQ(metric("anogate_recording_failing"), 1);
    const LogTime told = logged("the disk has written nothing for 1 s; frames are still forwarded, but are not recorded");
    EXPECT_LT((told - disk.slow_since()) / 1ms, slow_reported_within / 1ms);
    ASSERT_NO_FATAL_FAILURE(send_large(200));
    EXPECT_LT(running().at("frames").get<int>(), sent_);
    disk.be_fast();
    ASSERT_TRUE(until([&](const json& now) { return now.at("frames") == sent_ && now.at("error") == ""; })) << running();
    EXPECT_EQ(metric("anogate_recording_failing"), 0);
    logged("resumed; 0 frames are missing");
    EXPECT_EQ(end(name).at("not_written"), 0);
    EXPECT_EQ(files().numbers, numbers_to(sent_));
    EXPECT_TRUE(files().are_whole());
}

}    // namespace
}    // namespace slow_disk_tests
