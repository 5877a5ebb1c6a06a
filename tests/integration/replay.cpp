// replay:FILE: the frames of recorded devices are sent again, next to those of live devices.
#include <link/replay_file.hpp>
#include <link/serial/serial_settings.hpp>
#include <status/status.hpp>
#include <support/anoctl.hpp>
#include <support/bytes.hpp>
#include <support/files.hpp>
#include <support/hanging_file.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/recorded.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <sys/asio.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

namespace replay_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using nlohmann::json;
using Frames = std::vector<Bytes>;

constexpr std::uint8_t fc = 0xDC, host = 0xFE, all = 0xFF;
const Bytes question = frame(host, fc, 0xE0, {0, 0, 0});

Bytes numbered(std::uint8_t n, std::uint8_t source = fc) { return frame(source, all, 0x03, {n, 0, 0, 0, 0, 0, 1}); }

KeptItem said(const Bytes& frame, std::chrono::nanoseconds at, const std::string& link = "fc",
              anogate::Direction direction = anogate::Direction::in) {
    KeptItem item;
    item.time_ns = 1'763'898'044'000'000'000 + static_cast<std::uint64_t>(at.count());
    item.boottime_ns = 1'000'000'000 + static_cast<std::uint64_t>(at.count());
    item.link = link;
    item.direction = direction;
    item.frame = frame;
    return item;
}

class Replay : public testing::Test {
protected:
    std::string recording(const std::vector<KeptItem>& items) {
        return dir.write("flight.pcapng", write_pcapng(items, {"anogate 0.1.0"}));
    }
    std::string link(const std::vector<KeptItem>& items, const std::string& keys = "") {
        return "replay:" + recording(items) + keys;
    }
    /// Waits until the gateway reports the end of the replay; returns all frames that the ground received.
    static Frames all_heard(RunningGateway& daemon, UdpPeer& ground) {
        Frames heard;
        EXPECT_TRUE(daemon.until([&] {
            for (Bytes& one : ground.frames()) heard.push_back(std::move(one));
            return daemon.link("flight")["replay"] == "ended";
        })) << daemon.status();
        for (Bytes& one : ground.frames()) heard.push_back(std::move(one));
        return heard;
    }

    TempDir dir;
    UdpPeer ground;
};

TEST_F(Replay, replays_received_frames_in_their_order_and_then_reports_its_end) {
    std::vector<KeptItem> items;
    Frames expected;
    for (std::uint8_t i = 0; i < 100; ++i) {
        expected.push_back(numbered(i));
        items.push_back(said(expected.back(), i * 1ms, i % 2 == 0 ? "fc" : "radio"));
        items.push_back(said(numbered(i, 0xDD), i * 1ms, "ground", anogate::Direction::out));
    }
    RunningGateway daemon{settings_of_texts({link(items), ground.link("ground")})};
    EXPECT_EQ(all_heard(daemon, ground), expected);
    const json told = daemon.link("flight");
    EXPECT_EQ(told["kind"], "replay");
    EXPECT_EQ(told["state"], "up");
    EXPECT_EQ(told["hint_id"], "recording_ended");
    EXPECT_EQ(told["error"], "");
    EXPECT_EQ(told["frames_in"], 100);
    ASSERT_EQ(told["channels"].size(), 2u);
    EXPECT_EQ(told["channels"][0]["peer"], "fc");
    EXPECT_EQ(told["channels"][1]["peer"], "radio");
    EXPECT_EQ(told["channels"][1]["frames_in"], 50);
    EXPECT_EQ(told["replayed"], json::array({{{"address", "0xDC"}, {"who", "flight controller"}}}));
    EXPECT_FALSE(daemon.link("ground").contains("replayed"));
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST_F(Replay, replays_an_mcap_file_and_everything_before_the_cut_of_a_truncated_one) {
    std::vector<KeptItem> items;
    Frames expected;
    for (std::uint8_t i = 0; i < 100; ++i) {
        expected.push_back(numbered(i));
        items.push_back(said(expected.back(), i * 1ms, i % 2 == 0 ? "fc" : "radio"));
    }
    const auto replayed = [&](const std::string& bytes) {
        return settings_of_texts({"replay:" + dir.write("flight.mcap", bytes), ground.link("ground")});
    };
    const auto format = anogate::RecordingFormat::mcap;
    {
        RunningGateway daemon{replayed(write_recording(format, items, {"anogate 0.1.0"}))};
        EXPECT_EQ(all_heard(daemon, ground), expected);
        EXPECT_EQ(daemon.link("flight")["error"], "");
        EXPECT_EQ(daemon.link("flight")["channels"][1]["peer"], "radio");
        EXPECT_TRUE(daemon.counters_add_up());
    }
    std::string cut = write_recording(format, items, {"anogate 0.1.0"}, false, 50);    // two chunks
    cut.resize(write_recording(format, {items.begin(), items.begin() + 50}, {"anogate 0.1.0"}, false).size() + 40);
    RunningGateway daemon{replayed(cut)};
    expected.resize(50);
    EXPECT_EQ(all_heard(daemon, ground), expected);
    EXPECT_EQ(daemon.link("flight")["error_id"], "recording_damaged") << daemon.status();
    anogate::HintLog log;
    const std::vector<std::string> lines = log.news(daemon.gateway());
    ASSERT_EQ(lines.size(), 2u);
    EXPECT_NE(lines[0].find("flight.mcap: it is truncated: the data after byte "), std::string::npos) << lines[0];
    EXPECT_EQ(lines[1], "flight: the recording has ended");
    EXPECT_TRUE(log.news(daemon.gateway()).empty()) << "each once";
}

TEST_F(Replay, continues_after_a_damaged_chunk_and_reports_it) {
    std::vector<KeptItem> items;
    Frames expected;
    for (std::uint8_t i = 0; i < 100; ++i) {
        items.push_back(said(numbered(i), i * 1ms));
        if (i >= 50) expected.push_back(numbered(i));
    }
    const auto format = anogate::RecordingFormat::mcap;
    std::string damaged = write_recording(format, items, {"anogate 0.1.0"}, true, 50);    // two chunks
    const std::size_t first_chunk = write_recording(format, {}, {"anogate 0.1.0"}, false).size();
    damaged[first_chunk + 100] ^= 0x55;    // in the compressed data
    RunningGateway daemon{settings_of_texts({"replay:" + dir.write("flight.mcap", damaged), ground.link("ground")})};
    EXPECT_EQ(all_heard(daemon, ground), expected);
    EXPECT_EQ(daemon.link("flight")["error_id"], "recording_damaged") << daemon.status();
    EXPECT_NE(daemon.link("flight")["error"].get<std::string>().find("1 damaged part is skipped, at byte " +
                                                                     std::to_string(first_chunk)),
              std::string::npos)
        << daemon.status();
}

TEST_F(Replay, keeps_the_time_between_frames_and_applies_the_requested_speed) {
    const std::vector<KeptItem> items{said(numbered(0), 0s), said(numbered(1), 200ms), said(numbered(2), 400ms)};
    const auto took = [&](const std::string& keys) {
        RunningGateway daemon{settings_of_texts({link(items, keys), ground.link("ground")})};
        EXPECT_TRUE(daemon.until([&] { return daemon.count("flight", "frames_in") >= 1; }));
        const auto begin = anogate::Clock::now();
        EXPECT_TRUE(daemon.until([&] { return daemon.count("flight", "frames_in") == 3; }));
        return anogate::Clock::now() - begin;
    };
    EXPECT_GE(took(""), 390ms);
    const auto fast = took(",rate=10");
    EXPECT_GE(fast, 30ms);
    EXPECT_LT(fast, 300ms);
    EXPECT_LT(took(",rate=0"), 100ms);
}

TEST_F(Replay, replays_only_the_requested_part_and_links) {
    const std::vector<KeptItem> items{said(numbered(0), 0s), said(numbered(1), 1h), said(numbered(2), 1h + 1ms, "radio"),
                                      said(numbered(3), 1h + 2ms, "imu"), said(numbered(4), 2h)};
    RunningGateway daemon{settings_of_texts({link(items, ",from=1h,to=2h,links=fc+imu"), ground.link("ground")})};
    EXPECT_EQ(all_heard(daemon, ground), (Frames{numbered(1), numbered(3)}));
}

TEST_F(Replay, reports_why_there_is_nothing_to_replay) {
    const std::vector<KeptItem> items{said(numbered(0), 0s), said(numbered(1), 20s)};
    const std::pair<const char*, const char*> asked[] = {
        {",links=radio", "there is no link radio in it; it has fc"},
        {",from=30s", "it is 20 s long, so there is nothing to replay from 30 s on"},
        {",from=30s,loop", "it is 20 s long, so there is nothing to replay from 30 s on"}};
    for (const auto& [keys, why] : asked) {
        RunningGateway daemon{settings_of_texts({link(items, keys), ground.link("ground")})};
        EXPECT_TRUE(all_heard(daemon, ground).empty()) << keys;
        const json told = daemon.link("flight");
        EXPECT_EQ(told["error"], dir / "flight.pcapng: " + why) << told;
        EXPECT_EQ(told["error_id"], "nothing_to_replay");
        EXPECT_EQ(told["error_args"]["what"], why);
        anogate::HintLog log;
        const auto news = log.news(daemon.gateway());
        ASSERT_FALSE(news.empty()) << keys;
        EXPECT_EQ(news.front(), "flight: " + (dir / "flight.pcapng: ") + why);
    }
}

TEST_F(Replay, starts_again_at_its_end_if_requested) {
    RunningGateway daemon{
        settings_of_texts({link({said(numbered(0), 0s), said(numbered(1), 1ms)}, ",loop"), ground.link("ground")})};
    ASSERT_TRUE(daemon.until([&] { return daemon.count("flight", "frames_in") >= 20; }));
    const Frames heard = ground.frames();
    ASSERT_GE(heard.size(), 4u);
    for (std::size_t i = 0; i < heard.size(); ++i) EXPECT_EQ(heard[i], numbered(i % 2));
}

TEST_F(Replay, a_looped_recording_of_no_duration_is_replayed_at_a_limited_rate) {
    RunningGateway daemon{settings_of_texts({link({said(numbered(0), 0s)}, ",loop"), ground.link("ground")})};
    ASSERT_TRUE(daemon.until([&] { return daemon.count("flight", "frames_in") >= 1; }));
    const auto begin = anogate::Clock::now();
    ASSERT_TRUE(daemon.until([&] { return daemon.count("flight", "frames_in") >= 4; }));
    EXPECT_GE(anogate::Clock::now() - begin, 250ms);
}

TEST_F(Replay, omits_frames_that_may_command_a_vehicle_and_counts_them) {
    const Bytes command = frame(0x30, fc, 0xC0, {1, 0}), acts = frame(0x30, fc, 0xE0, {0x10, 1}),
                of_host = frame(host, fc, 0x03, {0, 0, 0, 0, 0, 0, 1}), tunnel = frame(0x30, fc, 0xB1, {1, 2, 3});
    const std::vector<KeptItem> items{said(command, 0s), said(acts, 0s), said(of_host, 0s), said(tunnel, 0s),
                                      said(numbered(0), 1ms)};
    {
        RunningGateway daemon{settings_of_texts({link(items), ground.link("ground")})};
        EXPECT_EQ(all_heard(daemon, ground), Frames{numbered(0)});
        EXPECT_EQ(daemon.link("flight")["kept_back_commands"], 2);
        EXPECT_EQ(daemon.link("flight")["kept_back_of_hosts"], 1);
        EXPECT_EQ(daemon.link("flight")["kept_back_tunnels"], 1);
    }
    RunningGateway daemon{settings_of_texts({link(items, ",commands"), ground.link("ground")})};
    EXPECT_EQ(all_heard(daemon, ground).size(), 5u);
    EXPECT_EQ(daemon.link("flight")["kept_back_commands"], 0);
}

TEST_F(Replay, a_live_device_has_its_address_at_once_and_keeps_it) {
    UdpPeer vehicle;
    RunningGateway daemon{settings_of_texts(
        {link({said(numbered(7), 0s), said(numbered(7), 20ms)}, ",loop"), ground.link("ground"), vehicle.link("vehicle")})};
    ASSERT_TRUE(daemon.until([&] { return daemon.count("flight", "frames_in") >= 10; }));
    EXPECT_TRUE(daemon.route("0xDC").is_null()) << daemon.status();
    vehicle.send(daemon.port("vehicle"), numbered(7));    // identical to a recorded one
    ASSERT_TRUE(daemon.until([&] { return daemon.count("vehicle", "frames_in") == 1; }));
    EXPECT_EQ(daemon.route("0xDC")["links"], json{"vehicle"});
    const auto before = daemon.count("flight", "frames_in");
    ASSERT_TRUE(daemon.until([&] { return daemon.count("flight", "frames_in") >= before + 10; }));
    EXPECT_EQ(daemon.route("0xDC")["links"], json{"vehicle"});
    ground.send(daemon.port("ground"), question);
    ASSERT_TRUE(daemon.until([&] {
        const Frames heard = vehicle.frames();
        return std::find(heard.begin(), heard.end(), question) != heard.end();
    }));
    EXPECT_EQ(daemon.count("flight", "frames_out"), 0u);
    EXPECT_EQ(daemon.status()["conflicts"], json::array());
}

TEST_F(Replay, accepts_no_frames) {
    anogate::Settings settings = settings_of_texts({link({said(numbered(0), 0s)}), ground.link("ground")});
    settings.routes = {{0x33, 0x33, "flight"}};
    RunningGateway daemon{settings};
    all_heard(daemon, ground);
    ground.send(daemon.port("ground"), frame(host, all, 0x03, {1}));
    ground.send(daemon.port("ground"), frame(host, 0x33, 0x03, {2}));
    ASSERT_TRUE(daemon.until([&] {
        return daemon.count("ground", "frames_in") == 2 && daemon.count("flight", "denied_out") == 1;
    })) << daemon.status();
    EXPECT_EQ(daemon.count("flight", "frames_out"), 0u);
    EXPECT_TRUE(daemon.counters_add_up());
}

TEST_F(Replay, a_missing_file_is_waited_for) {
    const std::string file = dir / "flight.pcapng";
    RunningGateway daemon{settings_of_texts({"replay:" + file, ground.link("ground")})};
    ASSERT_TRUE(daemon.until([&] { return daemon.link("flight")["error_id"] == "no_recording"; })) << daemon.status();
    EXPECT_EQ(daemon.link("flight")["state"], "waiting");
    dir.write("flight.pcapng", "this is no recording");
    ASSERT_TRUE(daemon.until([&] {
        return daemon.link("flight")["error"].get<std::string>().ends_with("it is neither pcapng nor MCAP");
    })) << daemon.status();
    recording({said(numbered(0), 0s)});
    EXPECT_EQ(all_heard(daemon, ground), Frames{numbered(0)});
}

TEST_F(Replay, of_a_truncated_or_damaged_file_sends_the_whole_frames_and_reports_the_damage) {
    const std::string whole = write_pcapng({said(numbered(0), 0s), said(numbered(1), 1ms)}, {"anogate"}, false);
    for (const bool is_cut : {true, false}) {
        dir.write("flight.pcapng", is_cut ? whole.substr(0, whole.size() - 5) : whole + std::string(64, '\1'));
        RunningGateway daemon{settings_of_texts({"replay:" + (dir / "flight.pcapng"), ground.link("ground")})};
        EXPECT_EQ(all_heard(daemon, ground), is_cut ? Frames{numbered(0)} : (Frames{numbered(0), numbered(1)}));
        EXPECT_EQ(daemon.link("flight")["error_id"], "recording_damaged") << daemon.status();
        EXPECT_NE(daemon.link("flight")["error"].get<std::string>().find(is_cut ? "is truncated" : "damaged after byte"),
                  std::string::npos);
    }
}

TEST_F(Replay, a_pipe_or_folder_is_reported_and_does_not_block) {
    const std::string file = dir / "flight.pcapng";
    for (const bool is_pipe : {true, false}) {
        ASSERT_EQ(is_pipe ? ::mkfifo(file.c_str(), 0600) : ::mkdir(file.c_str(), 0700), 0);
        RunningGateway daemon{settings_of_texts({"replay:" + file, ground.link("ground")})};
        EXPECT_TRUE(daemon.until([&] {
            return daemon.link("flight")["error"].get<std::string>().starts_with(
                file + (is_pipe ? ": it is a named pipe" : ": it is a folder") + ": use a regular file");
        })) << daemon.status();
        EXPECT_EQ(daemon.link("flight")["error_id"], "no_recording");
        EXPECT_EQ(daemon.link("flight")["state"], "waiting");
        std::filesystem::remove(file);
        recording({said(numbered(0), 0s)});
        EXPECT_EQ(all_heard(daemon, ground), Frames{numbered(0)});
        std::filesystem::remove(file);
    }
}

TEST_F(Replay, a_hanging_disk_delays_no_other_link_and_is_reported) {
    const std::string bytes = write_pcapng({said(numbered(0), 0s), said(numbered(1), 1ms)}, {"anogate"});
    const std::size_t half = write_pcapng({said(numbered(0), 0s)}, {"anogate"}, false).size();
    const std::string file = dir.write("flight.pcapng", bytes);
    const HangingFile disk{file};
    RunningGateway daemon{settings_of_texts({"replay:" + file, ground.link("ground")})};
    ASSERT_TRUE(daemon.until([&] { return HangingFile::readers() == 1; }));
    ground.send(daemon.port("ground"), question);
    ASSERT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") == 1; }));
    ASSERT_TRUE(disk.write_part(bytes.substr(0, half)));
    ASSERT_TRUE(daemon.until([&] { return daemon.link("flight")["error_id"] == "recording_slow"; })) << daemon.status();
    EXPECT_EQ(daemon.link("flight")["frames_in"], 1);
    ground.send(daemon.port("ground"), question);
    ASSERT_TRUE(daemon.until([&] { return daemon.count("ground", "frames_in") == 2; }));
    ASSERT_TRUE(disk.write_part(bytes.substr(half)));
    ASSERT_TRUE(daemon.until([&] { return daemon.count("flight", "frames_in") == 2; }));
    EXPECT_EQ(daemon.link("flight")["error"], "");
}

TEST_F(Replay, the_gateway_stops_while_the_disk_hangs) {
    const HangingFile disk{recording({said(numbered(0), 0s)})};
    RunningGateway daemon{settings_of_texts({"replay:" + (dir / "flight.pcapng"), ground.link("ground")})};
    ASSERT_TRUE(daemon.until([&] { return HangingFile::readers() == 1; }));
    EXPECT_LT(daemon.stop(), 5s);
}

// More than is read ahead, over a line of 11,520 bytes/s.
TEST_F(Replay, at_rate_0_a_slow_line_gets_every_frame) {
    std::vector<KeptItem> items;
    Frames expected;
    for (unsigned i = 0; i < 1500; ++i) {
        expected.push_back(numbered(static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(0xDC - i % 7)));
        items.push_back(said(expected.back(), i * 1s));
    }
    PtyDevice slow{dir / "slow"};
    auto line = serial("slow", slow.path());
    line.as<anogate::SerialSettings>().baud = 115200;
    line.as<anogate::SerialSettings>().pace = anogate::Pace::on;
    anogate::Settings settings = settings_of_texts({link(items, ",rate=0")});
    settings.links.insert(settings.links.begin(), line);
    RunningGateway daemon{settings};
    ASSERT_TRUE(daemon.until(
        [&] {
            slow.heard();
            return daemon.count("slow", "frames_out") == expected.size();
        },
        60s))
        << daemon.status();
    daemon.run_for(5ms);
    EXPECT_EQ(split(slow.heard()).frames, expected);
}

// Without a gateway.
TEST_F(Replay, by_anoctl_at_rate_0_sends_every_frame_to_a_slow_line_as_well) {
    std::vector<KeptItem> items;
    Frames expected;
    for (unsigned i = 0; i < 400; ++i) {
        expected.push_back(numbered(static_cast<std::uint8_t>(i)));
        items.push_back(said(expected.back(), i * 1s));
    }
    PtyDevice slow{dir / "slow"};
    Process replay{ANOCTL, {"replay", recording(items), "serial:" + slow.path() + ",baud=115200,pace=on", "--rate", "0"}};
    ASSERT_TRUE(wait_until([&] {
        slow.heard();
        return !replay.is_running();
    })) << replay.output();
    EXPECT_EQ(replay.wait(), 0) << replay.output();
    EXPECT_NE(replay.output().find("400 frames replayed"), std::string::npos) << replay.output();
    EXPECT_EQ(split(slow.heard()).frames, expected);
}

TEST_F(Replay, of_many_links_leaves_channels_for_live_links) {
    std::vector<KeptItem> items;
    for (std::uint8_t i = 0; i < 100; ++i) items.push_back(said(numbered(i), 0s, "link" + std::to_string(i)));
    RunningGateway daemon{settings_of_texts({link(items), "udp-listen:127.0.0.1:0,name=air", ground.link("ground")})};
    EXPECT_EQ(all_heard(daemon, ground).size(), 100u);
    EXPECT_EQ(daemon.link("flight")["channels"].size(), 16u);
    EXPECT_EQ(daemon.link("flight")["channels"][15]["frames_in"], 85);
    UdpPeer peer;
    peer.send(daemon.port("air"), numbered(1));
    EXPECT_TRUE(daemon.until([&] { return daemon.link("air")["channels"].size() == 1; }));
}

TEST_F(Replay, names_of_links_are_shown_with_control_characters_escaped_and_limited_in_length) {
    const std::string forged = "\x1b[31mred\a\r\n2026-01-01 all is well";
    const std::vector<KeptItem> items{said(numbered(0), 0s, forged), said(numbered(1), 0s, "\xff(\n"),
                                      said(numbered(2), 0s, std::string(1000, 'L'))};
    RunningGateway daemon{settings_of_texts({link(items), ground.link("ground")})};
    EXPECT_EQ(all_heard(daemon, ground).size(), 3u);
    const json told = daemon.link("flight")["channels"];
    ASSERT_EQ(told.size(), 3u);
    EXPECT_EQ(told[0]["peer"], "\\x1b[31mred\\x07\\x0d\\x0a2026-01-01 all is well");
    EXPECT_EQ(told[1]["peer"], "\\xff(\\x0a");
    EXPECT_EQ(told[2]["peer"], std::string(64, 'L') + "...");
}

// Compressed equal frames take a thousandth of their size, so one read of the file contains megabytes of them. Every second one
// is left out, and that count shows how far the file was read.
TEST_F(Replay, of_highly_compressed_frames_decompresses_only_those_read_ahead) {
    std::vector<KeptItem> items;
    const Bytes wanted = frame(fc, all, 0xF1, Bytes(4000, 0)), kept_back = frame(fc, 0xDD, 0x40, Bytes(4000, 0));
    for (unsigned i = 0; i < 2000; ++i) {
        items.push_back(said(wanted, i * 1ms));
        items.push_back(said(kept_back, i * 1ms));
    }
    const std::string bytes = write_recording(anogate::RecordingFormat::mcap, items, {"anogate 0.1.0"});
    ASSERT_LT(bytes.size(), items.size() * wanted.size() / 64);
    anogate::ReplaySettings settings;
    settings.file = dir.write("flight.mcap", bytes);
    anogate::asio::io_context io{1};
    anogate::ReplayFile file{io, [] {}};
    file.start(settings);
    while (!file.next()) io.run_one_for(10s);
    io.run_for(50ms);
    const std::uint64_t most = anogate::ReplayFile::read_ahead / wanted.size() + 50;
    EXPECT_LE(file.kept_back().commands, most) << "a batch more than is read ahead, and one that waits";
    unsigned taken = 0;
    while (file.state() != anogate::ReplayFile::State::ended || file.next()) {
        while (file.next()) {
            file.pop();
            ++taken;
            EXPECT_LE(file.kept_back().commands, taken + most);
        }
        if (file.state() != anogate::ReplayFile::State::ended) io.run_one_for(10s);
    }
    EXPECT_EQ(taken, 2000u);
    EXPECT_EQ(file.kept_back().commands, 2000u);
}

// With the real programs.
TEST_F(Replay, a_recording_that_is_replayed_and_recorded_again_is_the_same) {
    std::vector<KeptItem> items;
    Frames expected;
    for (unsigned i = 0; i < 2000; ++i) {
        Bytes data(1 + i % 60, static_cast<std::uint8_t>(0xAB + i % 3));
        data[0] = static_cast<std::uint8_t>(i);
        if (data.size() > 1) data[1] = static_cast<std::uint8_t>(i >> 8);
        expected.push_back(frame(static_cast<std::uint8_t>(0xD0 + i % 2 * 12), i % 5 == 0 ? host : all, 0xF1, data));
        items.push_back(said(expected.back(), 1s + i * 200us, i % 3 == 0 ? "radio" : "fc"));
    }
    const std::string first = dir.write("first.pcapng", write_pcapng(items, {"anogate"}));
    const std::string socket = dir / "control.sock", second = dir / "second.pcapng", later = dir / "later.pcapng";
    Daemon gateway{ANOGATED, socket, {"replay:" + later + ",name=again", ground.link("ground")}};
    ASSERT_TRUE(gateway.until_answers()) << gateway.output();
    Process recorder{ANOCTL, {"record", second, "--control", socket}};
    ASSERT_TRUE(wait_until([&] {    // it sees nothing before it is attached
        ground.send(gateway.port("ground"), question);
        return !read_pcapng(file_text(second)).items.empty();
    })) << recorder.output();
    std::filesystem::rename(first, later);
    const auto replayed = [&] {
        std::vector<KeptItem> of_replay = read_pcapng(file_text(second)).items;
        std::erase_if(of_replay, [](const KeptItem& item) { return item.link != "again"; });
        return of_replay;
    };
    ASSERT_TRUE(wait_until([&] { return replayed().size() >= expected.size(); })) << gateway.status();
    recorder.signal(SIGINT);
    EXPECT_EQ(recorder.wait(), 0) << recorder.output();
    const std::vector<KeptItem> again = replayed();
    ASSERT_EQ(again.size(), expected.size());
    for (std::size_t i = 0; i < again.size(); ++i) {
        EXPECT_EQ(again[i].frame, expected[i]) << i;
        EXPECT_EQ(again[i].peer, items[i].link) << i;
    }
}

}    // namespace
}    // namespace replay_tests
