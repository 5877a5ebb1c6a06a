// `anoctl record` from a running gateway, and how other programs read its files.
#include <support/anoctl.hpp>
#include <support/bytes.hpp>
#include <support/files.hpp>
#include <support/process.hpp>
#include <support/recorded.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

namespace anoctl_record_tests {
namespace {

using namespace support;
using nlohmann::json;

const Bytes euler = frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
const Bytes wind = frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});

class AnoctlRecord : public testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(gateway.until_answers()) << gateway.output(); }
    Process record(
        std::vector<std::string> words, const std::function<void()>& in_child = [] {}) {
        words.insert(words.begin(), {"record", file});
        words.insert(words.end(), {"--control", socket});
        return Process{ANOCTL, std::move(words), {}, in_child};
    }
    std::vector<KeptItem> items() const { return read_pcapng(file_text(file)).items; }
    /// Sends frames until the file contains `count` of them: it sees nothing before it is attached.
    bool until_recorded(std::size_t count, const Bytes& bytes = euler) {
        return wait_until([&] {
            a.send(gateway.port("a"), bytes);
            return items().size() >= count;
        });
    }

    TempDir dir;
    std::string socket = dir / "control.sock", file = dir / "flight.pcapng";
    UdpPeer a, b;
    Daemon gateway{ANOGATED, socket, {a.link("a"), b.link("b")}};
};

TEST_F(AnoctlRecord, received_frames_are_in_the_file_while_it_records_and_after_it_ends) {
    Process recorder = record({});
    ASSERT_TRUE(until_recorded(3)) << recorder.output();
    EXPECT_FALSE(read_pcapng(file_text(file)).has_end);
    recorder.signal(SIGINT);
    EXPECT_EQ(recorder.wait(), 0) << recorder.output();
    const auto read = read_pcapng(file_text(file));
    EXPECT_TRUE(read.has_end);
    EXPECT_EQ(read.fault, "");
    EXPECT_TRUE(read.head.program.starts_with("anoctl "));
    for (const KeptItem& item : read.items) {
        EXPECT_EQ(item.frame, euler);
        EXPECT_EQ(item.link, "a");
        EXPECT_FALSE(item.description.empty());
        EXPECT_EQ(item.direction, anogate::Direction::in);
        EXPECT_TRUE(item.channel.has_value());
        EXPECT_NE(item.peer, "");
        EXPECT_GE(item.boottime_ns, read.head.boottime_ns);
        EXPECT_GE(item.time_ns, read.head.time_ns);
    }
    EXPECT_NE(recorder.output().find(file + ": " + std::to_string(read.items.size()) + " frames in "), std::string::npos)
        << recorder.output();
}

TEST_F(AnoctlRecord, records_frames_that_pass_its_filters_and_ends_after_the_given_time) {
    Process recorder = record({"--direction", "out", "--link", "b", "--id", "wind", "--seconds", "1", "--json"});
    ASSERT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), euler);
        a.send(gateway.port("a"), wind);
        return !recorder.is_running();
    }));
    EXPECT_EQ(recorder.wait(), 0) << recorder.output();
    const auto all = items();
    ASSERT_FALSE(all.empty());
    for (const KeptItem& item : all) {
        EXPECT_EQ(item.frame, wind);
        EXPECT_EQ(item.direction, anogate::Direction::out);
        EXPECT_EQ(item.link, "b");
    }
    const json summary = json::parse(recorder.output());
    EXPECT_EQ(summary["frames"], all.size());
    EXPECT_EQ(summary["bytes"], std::filesystem::file_size(file));
    EXPECT_EQ(summary["lost"], 0);
}

TEST_F(AnoctlRecord, an_existing_file_is_not_overwritten_without_force) {
    dir.write("flight.pcapng", "mine");
    Process recorder = record({});
    EXPECT_EQ(recorder.wait(), 2);
    EXPECT_NE(recorder.output().find("already exists; use --force to overwrite it"), std::string::npos) << recorder.output();
    EXPECT_EQ(file_text(file), "mine");
    Process refused = record({"--force", "--id", "nonsense"});
    EXPECT_EQ(refused.wait(), 2) << refused.output();
    EXPECT_EQ(file_text(file), "mine");
    Process forced = record({"--force"});
    EXPECT_TRUE(until_recorded(1)) << forced.output();
}

TEST_F(AnoctlRecord, a_full_disk_ends_it_with_an_error_and_leaves_whole_frames_in_the_file) {
    Process recorder = record({}, [] {
        const rlimit most{2000, 2000};
        setrlimit(RLIMIT_FSIZE, &most);
        signal(SIGXFSZ, SIG_IGN);
    });
    ASSERT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), euler);
        return !recorder.is_running();
    }));
    EXPECT_EQ(recorder.wait(), 1);
    EXPECT_NE(recorder.output().find("cannot continue writing: File too large; the frames written so far are intact"),
              std::string::npos)
        << recorder.output();
    const auto read = read_pcapng(file_text(file));
    EXPECT_EQ(read.fault, "");
    EXPECT_EQ(read.unfinished, 0u);
    EXPECT_GT(read.items.size(), 0u);
    EXPECT_NE(recorder.output().find(": " + std::to_string(read.items.size()) + " frame"), std::string::npos)
        << recorder.output();
}

TEST_F(AnoctlRecord, leaves_whole_frames_in_the_file_when_it_is_killed) {
    Process recorder = record({});
    ASSERT_TRUE(until_recorded(2)) << recorder.output();
    recorder.signal(SIGKILL);
    recorder.wait();
    EXPECT_GE(items().size(), 2u);
    EXPECT_EQ(support::anoctl({"info", file}).exit, 0);
}

TEST_F(AnoctlRecord, ends_with_a_summary_when_the_gateway_stops) {
    Process recorder = record({});
    ASSERT_TRUE(until_recorded(1)) << recorder.output();
    gateway.signal(SIGTERM);
    EXPECT_EQ(recorder.wait(), 1);
    EXPECT_TRUE(read_pcapng(file_text(file)).has_end);
    EXPECT_NE(recorder.output().find(" in "), std::string::npos) << recorder.output();
}

TEST(AnoctlDecode, of_a_recording_names_the_commands_that_read_it) {
    const TempDir dir;
    const std::string file = dir.write("flight.mcap", "no matter what");
    Process decode{ANOCTL, {"decode", file}};
    EXPECT_EQ(decode.wait(), 2);
    EXPECT_NE(decode.output().find("is a recording: see anoctl info " + file + ", or anoctl convert"), std::string::npos)
        << decode.output();
}

TEST_F(AnoctlRecord, tshark_shows_its_frames_decoded_with_link_direction_and_cause) {
    if (run("tshark --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "tshark is not installed";
    Process recorder = record({"--direction", "in", "dropped"});
    const Bytes nowhere = frame(0xDC, 0x00, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
    ASSERT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), nowhere);
        const auto all = items();
        return std::any_of(all.begin(), all.end(), [](const KeptItem& i) { return i.cause == "no_route"; });
    })) << recorder.output();
    recorder.signal(SIGINT);
    ASSERT_EQ(recorder.wait(), 0);
    const std::string script = dir.write("ano.lua", support::anoctl({"messages", "--lua"}).out), shown = dir / "shown";
    ASSERT_EQ(run("HOME=" + dir.path().string() + " tshark -r " + file + " -X lua_script:" + script +
                  " -T fields -E separator=/t -e _ws.col.Protocol -e ano.euler.rol -e frame.interface_name -e "
                  "frame.packet_flags_direction" +
                  " -e frame.interface_queue -e frame.comment >" + shown + " 2>/dev/null"),
              0);
    const std::string text = file_text(shown);
    EXPECT_EQ(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')), items().size());
    EXPECT_TRUE(text.starts_with("ANO V8\t1.23\ta\t")) << text;
    EXPECT_NE(text.find("dropped: no_route"), std::string::npos) << text;
    EXPECT_NE(text.find("channel "), std::string::npos) << text;
}

// While it is stopped, more frames are received than the gateway queues for one client.
TEST_F(AnoctlRecord, frames_that_overflow_the_queue_of_the_gateway_are_counted_in_the_file_and_at_the_end) {
    constexpr std::size_t many = 700, at_once = 25;
    Process recorder = record({});
    ASSERT_TRUE(until_recorded(1)) << recorder.output();
    recorder.signal(SIGSTOP);
    const Bytes large = frame(0xDC, 0xFF, 0xFB, Bytes(4000));
    const std::uint64_t before = gateway.count("a", "frames_in");
    for (std::size_t sent = 0; sent < many; sent += at_once) {
        for (std::size_t i = 0; i < at_once; ++i) a.send(gateway.port("a"), large);
        ASSERT_TRUE(wait_until([&] { return gateway.count("a", "frames_in") >= before + sent + at_once; })) << sent;
    }
    recorder.signal(SIGCONT);
    const auto losses = [](const std::vector<KeptItem>& all) {
        return std::count_if(all.begin(), all.end(), [](const KeptItem& item) { return item.lost > 0; });
    };
    ASSERT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), euler);
        return losses(items()) > 0;
    })) << recorder.output();
    recorder.signal(SIGINT);
    EXPECT_EQ(recorder.wait(), 0);
    std::uint64_t recorded = 0, lost = 0;
    for (const KeptItem& item : items()) {
        recorded += item.frame == large;
        lost += item.lost;
        if (item.lost > 0) {
            EXPECT_TRUE(item.names.find("special ") != std::string::npos) << item.names;
        }
    }
    EXPECT_GT(lost, 0u);
    EXPECT_GE(recorded + lost, many);    // some of the small ones may be lost as well
    EXPECT_NE(recorder.output().find("; " + std::to_string(lost) + " frames are missing"), std::string::npos)
        << recorder.output();
    const json told = json::parse(support::anoctl({"info", "--json", file}).out);
    EXPECT_EQ(told["lost"], lost);
}

class AnoctlRecordMcap : public AnoctlRecord {
protected:
    void SetUp() override {
        AnoctlRecord::SetUp();
        file = dir / "flight.mcap";
    }
};

// This includes the last frames, even if none follow that would complete their chunk.
TEST_F(AnoctlRecordMcap, received_frames_are_in_the_file_within_a_second_and_remain_when_it_is_killed) {
    Process recorder = record({});
    ASSERT_TRUE(until_recorded(1)) << recorder.output();
    const std::size_t before = items().size();
    a.send(gateway.port("a"), wind);
    ASSERT_TRUE(wait_until([&] { return !items().empty() && items().back().frame == wind; })) << before;
    recorder.signal(SIGKILL);
    recorder.wait();
    EXPECT_EQ(items().back().frame, wind);
    EXPECT_EQ(support::anoctl({"info", file}).exit, 0);
}

TEST_F(AnoctlRecordMcap, ends_the_file_with_an_index_and_a_summary) {
    Process recorder = record({"--json"});
    ASSERT_TRUE(until_recorded(3)) << recorder.output();
    recorder.signal(SIGINT);
    EXPECT_EQ(recorder.wait(), 0) << recorder.output();
    const auto read = support::read_recording(file_text(file));
    EXPECT_TRUE(read.has_end);
    const json summary = json::parse(recorder.output());
    EXPECT_EQ(summary["frames"], read.items.size());
    EXPECT_EQ(summary["bytes"], std::filesystem::file_size(file));
    EXPECT_EQ(json::parse(support::anoctl({"info", "--json", file}).out)["frames"], read.items.size());
    for (const KeptItem& item : read.items) {
        EXPECT_EQ(item.link, "a");
        EXPECT_TRUE(item.channel.has_value());
        EXPECT_NE(item.peer, "");
    }
}

class AnoctlReplay : public testing::Test {
protected:
    static KeptItem said(const Bytes& frame, std::uint64_t after_ns, anogate::Direction direction = anogate::Direction::in) {
        KeptItem item;
        item.time_ns = 1'763'898'044'000'000'000 + after_ns;
        item.boottime_ns = 1'000'000'000 + after_ns;
        item.link = "fc";
        item.direction = direction;
        item.frame = frame;
        return item;
    }
    Process replay(const std::vector<KeptItem>& items, std::vector<std::string> words = {}) {
        const std::string file = dir.write("flight.pcapng", write_pcapng(items, {"anoctl 0.1.0"}));
        words.insert(words.begin(), {"replay", file, peer.link("there")});
        return Process{ANOCTL, std::move(words)};
    }

    TempDir dir;
    UdpPeer peer;
};

TEST_F(AnoctlReplay, replays_received_frames_in_their_order) {
    std::vector<KeptItem> items;
    std::vector<Bytes> expected;
    for (std::uint8_t i = 0; i < 40; ++i) {
        expected.push_back(frame(0xDC, 0xFF, 0x03, {i, 0, 0, 0, 0, 0, 1}));
        items.push_back(said(expected.back(), i * 1'000'000ull));
    }
    items.push_back(said(wind, 40'000'000, anogate::Direction::out));
    Process replayed = replay(items);
    EXPECT_EQ(replayed.wait(), 0) << replayed.output();
    EXPECT_EQ(peer.frames(), expected);
    EXPECT_NE(replayed.output().find("40 frames replayed\n"), std::string::npos) << replayed.output();
}

TEST_F(AnoctlReplay, replays_received_frames_of_an_mcap_file_as_well) {
    const std::vector<KeptItem> items{said(euler, 0), said(wind, 1), said(euler, 2, anogate::Direction::out)};
    const std::string file = dir.write("flight.mcap",
                                       support::write_recording(anogate::RecordingFormat::mcap, items, {"anoctl 0.1.0"}));
    Process replayed{ANOCTL, {"replay", file, peer.link("there")}};
    EXPECT_EQ(replayed.wait(), 0) << replayed.output();
    EXPECT_EQ(peer.frames(), (std::vector<Bytes>{euler, wind}));
}

TEST_F(AnoctlReplay, omits_frames_that_command_a_vehicle_unless_they_are_requested) {
    const Bytes command = frame(0x30, 0xDC, 0xC0, {1, 0}), of_host = frame(0xFE, 0xDC, 0x03, {0, 0, 0, 0, 0, 0, 1});
    const std::vector<KeptItem> items{said(command, 0), said(euler, 1), said(of_host, 2)};
    Process kept_back = replay(items);
    EXPECT_EQ(kept_back.wait(), 0) << kept_back.output();
    EXPECT_EQ(peer.frames(), std::vector<Bytes>{euler});
    EXPECT_NE(kept_back.output().find("2 from hosts or commanding a vehicle omitted"), std::string::npos) << kept_back.output();
    Process all = replay(items, {"--commands", "--json"});
    EXPECT_EQ(all.wait(), 0) << all.output();
    EXPECT_EQ(peer.frames().size(), 3u);
    EXPECT_NE(all.output().find(R"({"frames":3,"not_sent":0,"kept_back":0})"), std::string::npos) << all.output();
}

TEST_F(AnoctlReplay, reports_why_nothing_is_replayed) {
    Process nothing = replay({});
    EXPECT_EQ(nothing.wait(), 0);
    EXPECT_NE(nothing.output().find("0 frames replayed: the recording has no frames\n"), std::string::npos) << nothing.output();
    Process sent = replay({said(euler, 0, anogate::Direction::out)});
    EXPECT_EQ(sent.wait(), 0);
    EXPECT_NE(sent.output().find("0 frames replayed: the recording has no received frames\n"), std::string::npos)
        << sent.output();
}

TEST_F(AnoctlReplay, reports_once_that_nothing_listens_at_the_target) {
    const std::string nobody = support::UdpPeer{}.local().text();    // a closed port
    for (const std::size_t count : {std::size_t{1}, std::size_t{200}}) {
        const std::vector<KeptItem> items(count, said(euler, 0));
        const std::string file = dir.write("flight.pcapng", write_pcapng(items, {"anoctl 0.1.0"}));
        Process replayed{ANOCTL, {"replay", file, "udp:" + nobody, "--rate", "0"}};
        EXPECT_EQ(replayed.wait(), 0) << replayed.output();
        const std::string& said = replayed.output();
        EXPECT_NE(said.find("nothing listens at " + nobody), std::string::npos) << said;
        EXPECT_EQ(said.find("nothing listens"), said.rfind("nothing listens")) << said;
        EXPECT_NE(said.find(" replayed"), std::string::npos) << said;
    }
}

TEST_F(AnoctlReplay, ends_at_once_when_it_is_interrupted) {
    constexpr std::uint64_t an_hour = 3'600'000'000'000;
    Process replayed = replay({said(euler, 0), said(wind, an_hour)});
    std::vector<Bytes> heard;
    ASSERT_TRUE(wait_until([&] { return !(heard = peer.frames()).empty(); })) << replayed.output();
    EXPECT_EQ(heard, std::vector<Bytes>{euler});
    replayed.signal(SIGINT);
    EXPECT_EQ(replayed.wait(), 130) << replayed.output();
}

}    // namespace
}    // namespace anoctl_record_tests
