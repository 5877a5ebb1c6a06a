// Layouts of flexible messages that change while the gateway runs, and the layouts stored in recordings; the orientation of LX
// units.
#include <support/anoctl.hpp>
#include <support/asked.hpp>
#include <support/files.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/wait.hpp>

#include <ano/typed.hpp>
#include <record/decoding.hpp>
#include <record/recording_writer.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace flexible_tests {
namespace {

using namespace support;
using namespace std::chrono_literals;
using nlohmann::json;

const char* const layout =
    R"([{"id": "0xF1", "fields": [{"name": "cells", "type": "u16", "count": 2, "scale": 0.001, "unit": "V"}]}])";
const Bytes cells = frame(30, 0xFE, 0xF1, {0x10, 0x0E, 0x11, 0x0E});

class Flexible : public testing::Test {
protected:
    void start(const std::string& more = "{}") {
        json config = json::parse(more);
        config["links"] = {"udp-listen:127.0.0.1:0,name=fc"};
        dir.write("anogate.json", config.dump());
        daemon = std::make_unique<Daemon>(ANOGATED, socket, std::vector<std::string>{"--config", dir / "anogate.json"},
                                          std::vector<std::string>{"STATE_DIRECTORY=" + (dir / "state")});
        ASSERT_TRUE(daemon->until_answers());
    }
    void stop() {
        daemon->signal(SIGTERM);
        EXPECT_EQ(daemon->wait(), 0);
        daemon.reset();
    }
    json get(const std::string& target) const { return json::parse(asked(socket, "GET", target).body); }
    anogate::http::Answer put(const std::string& body) const { return asked(socket, "PUT", "/flexible", body); }
    void send(const Bytes& bytes) { peer.send(daemon->port("fc"), bytes); }
    /// The fields of 0xF1 in the gateway's message table.
    json fields() const {
        for (const json& row : get("/messages"))
            if (row.at("id") == 0xF1) return row.at("fields");
        return {};
    }

    TempDir dir;
    std::string socket = dir / "control";
    std::unique_ptr<Daemon> daemon;
    UdpPeer peer;
};

TEST_F(Flexible, layouts_can_be_set_at_run_time_and_survive_a_restart) {
    start(R"({"flexible": [{"id": "0xF2", "fields": [{"name": "of_file", "type": "u8"}]}]})");
    EXPECT_EQ(get("/flexible").at("from"), "configuration");
    EXPECT_EQ(get("/flexible").at("flexible").at(0).at("id"), "0xF2");
    const auto before = get("/status").at("gateway").at("decoding_changes");

    const auto set = put(layout);
    EXPECT_EQ(set.status, 200u) << set.body;
    EXPECT_EQ(json::parse(set.body).at("from"), "client");
    EXPECT_EQ(json::parse(set.body).at("kept"), true) << set.body;
    EXPECT_EQ(fields().at(0).at("name"), "cells");
    EXPECT_EQ(fields().at(0).at("count"), 2);
    EXPECT_GT(get("/status").at("gateway").at("decoding_changes"), before);
    send(cells);    // registers the peer that receives the next one
    ASSERT_TRUE(daemon->until([&](const json&) { return daemon->count("fc", "frames_in") == 1; }));
    EXPECT_EQ(asked(socket, "POST", "/send", R"({"from": 30, "name": "flexible1", "fields": {"cells": [3.6, 3.601]}})").status,
              200u);
    stop();

    start(R"({"flexible": [{"id": "0xF2", "fields": [{"name": "of_file", "type": "u8"}]}]})");
    EXPECT_EQ(get("/flexible").at("from"), "client");
    EXPECT_EQ(fields().at(0).at("name"), "cells");
    stop();

    start(R"({"flexible": [{"id": "0xF2", "fields": [{"name": "another", "type": "u8"}]}]})");
    EXPECT_EQ(get("/flexible").at("from"), "configuration") << "its layouts were changed";
    EXPECT_EQ(get("/flexible").at("flexible").at(0).at("fields").at(0).at("name"), "another");
    EXPECT_EQ(fields(), json::array());
    EXPECT_TRUE(wait_until([&] { return !std::filesystem::exists(dir / "state/flexible.json"); }));
}

TEST_F(Flexible, a_reload_with_other_layouts_replaces_those_set_by_a_client) {
    start();
    EXPECT_EQ(put(layout).status, 200u);
    const json same = {{"links", {"udp-listen:127.0.0.1:0,name=fc"}}, {"gateway", {{"name", "other"}}}};
    dir.write("anogate.json", same.dump());
    EXPECT_EQ(asked(socket, "POST", "/reload").status, 200u);
    EXPECT_EQ(get("/flexible").at("from"), "client") << "the layouts of the file are the same";
    const json other = {{"links", {"udp-listen:127.0.0.1:0,name=fc"}},
                        {"flexible", {{{"id", "0xF2"}, {"fields", {{{"name", "x"}, {"type", "u8"}}}}}}}};
    dir.write("anogate.json", other.dump());
    EXPECT_EQ(asked(socket, "POST", "/reload").status, 200u);
    EXPECT_EQ(get("/flexible").at("from"), "configuration");
    EXPECT_TRUE(wait_until([&] { return !std::filesystem::exists(dir / "state/flexible.json"); }));
}

TEST_F(Flexible, layouts_set_by_a_client_are_restored_when_a_reload_is_not_confirmed) {
    start();
    EXPECT_EQ(put(layout).status, 200u);
    const json other = {{"links", {"udp-listen:127.0.0.1:0,name=fc"}},
                        {"flexible", {{{"id", "0xF2"}, {"fields", {{{"name", "x"}, {"type", "u8"}}}}}}}};
    dir.write("anogate.json", other.dump());
    EXPECT_EQ(asked(socket, "POST", "/reload?confirm_within=1s").status, 200u);
    EXPECT_EQ(get("/flexible").at("from"), "configuration");
    EXPECT_EQ(get("/flexible").at("flexible").at(0).at("id"), "0xF2");
    EXPECT_TRUE(std::filesystem::exists(dir / "state/flexible.json")) << "a restart would run the configuration before";
    EXPECT_TRUE(wait_until([&] { return get("/flexible").at("from") == "client"; })) << daemon->output();
    EXPECT_EQ(get("/flexible").at("flexible").at(0).at("fields").at(0).at("name"), "cells");
    EXPECT_TRUE(std::filesystem::exists(dir / "state/flexible.json"));
}

TEST_F(Flexible, faulty_layouts_change_nothing_and_are_reported_with_their_location) {
    start();
    EXPECT_EQ(put(layout).status, 200u);
    const auto answer = put(
        R"({"flexible": [{"id": 3, "fields": []}, {"id": "0xF1", "fields": [{"name": "a", "type": "u9"}]}]})");
    EXPECT_EQ(answer.status, 422u);
    const json refused = json::parse(answer.body);
    EXPECT_EQ(refused.at("what"), "invalid");
    ASSERT_EQ(refused.at("faults").size(), 2u) << refused;
    EXPECT_TRUE(refused.at("faults").at(0).get<std::string>().starts_with("/flexible/0/id: ")) << refused;
    EXPECT_TRUE(refused.at("faults").at(1).get<std::string>().starts_with("/flexible/1/fields/0/type: ")) << refused;
    json many = {{"id", "0xF1"}};
    for (int i = 0; i < 2000; ++i) many["k" + std::to_string(i)] = 0;
    const json told = json::parse(put(json::array({many}).dump()).body).at("faults");
    ASSERT_EQ(told.size(), 21u) << "the first ones, and how many more there are";
    EXPECT_TRUE(told.back().get<std::string>().ends_with(" more errors")) << told.back();
    EXPECT_EQ(put("5").status, 400u);
    EXPECT_EQ(put("{").status, 400u);
    EXPECT_EQ(fields().at(0).at("name"), "cells");
}

TEST_F(Flexible, anoctl_sets_and_shows_layouts_and_its_monitor_uses_them) {
    start();
    const std::string file = dir.write("layouts.json", std::string{"// a list with a comment\n"} + layout);
    const auto set = support::anoctl({"flexible", "set", file, "--control", socket});
    EXPECT_EQ(set.exit, 0) << set.err;
    EXPECT_NE(set.out.find("cells u16[2] × 0.001 V"), std::string::npos) << set.out;
    const auto listed = support::anoctl({"flexible", "--json", "--control", socket});
    EXPECT_EQ(json::parse(listed.out).at("flexible").at(0).at("fields").at(0).at("name"), "cells");
    const auto wrong = support::anoctl({"flexible", "set", "-", "--control", socket}, R"([{"id": "0xF1", "fields": []}])");
    EXPECT_EQ(wrong.exit, 1);
    EXPECT_NE(wrong.err.find("/flexible/0: a layout needs at least one field"), std::string::npos) << wrong.err;
    const auto hostile = support::anoctl(
        {"flexible", "set", "-", "--control", socket},
        R"([{"id": "0xF1", "fields": [{"name": "a\u0085b", "type": "u8", "unit": "\u001b[2J"}]}])");
    EXPECT_EQ(hostile.exit, 1);
    EXPECT_NE(hostile.err.find("/flexible/0/fields/0/name: control characters are not accepted"), std::string::npos)
        << hostile.err;
    EXPECT_NE(hostile.err.find("/flexible/0/fields/0/unit: control"), std::string::npos) << hostile.err;
    EXPECT_EQ(support::anoctl({"flexible", "set", "--control", socket}).exit, 2);

    std::thread sender{[&] {
        for (int i = 0; i < 100; ++i, std::this_thread::sleep_for(20ms)) send(cells);
    }};
    const auto shown = support::anoctl({"monitor", "--count", "1", "--direction", "in", "--control", socket});
    sender.join();
    EXPECT_NE(shown.out.find("flexible1 cells=[3.6,3.601]"), std::string::npos) << shown.out << shown.err;
}

TEST_F(Flexible, recordings_of_both_formats_contain_their_layouts_and_need_no_configuration) {
    start(R"({"record": {"start": false, "format": "mcap"}})");
    EXPECT_EQ(put(layout).status, 200u);
    for (const std::string format : {"mcap", "pcapng"}) {
        const std::string name = "of_" + format, file = name + "." + format;
        const json order{{"name", name}, {"format", format}};
        ASSERT_EQ(asked(socket, "POST", "/recordings", order.dump()).status, 200u);
        const std::uint64_t before = daemon->count("fc", "frames_in");
        for (int i = 0; i < 5; ++i) send(cells);
        ASSERT_TRUE(daemon->until([&](const json&) { return daemon->count("fc", "frames_in") == before + 5; }));
        const json other = {{{"id", "0xF1"}, {"fields", {{{"name", "later"}, {"type", "u32"}}}}}};
        ASSERT_EQ(put(other.dump()).status, 200u);
        for (int i = 0; i < 5; ++i) send(cells);
        ASSERT_TRUE(daemon->until([&](const json&) { return daemon->count("fc", "frames_in") == before + 10; }));
        ASSERT_EQ(asked(socket, "POST", "/recordings/" + name + "/end").status, 200u);
        const std::string path = dir.write(file, asked(socket, "GET", "/recordings/" + file).body);
        ASSERT_EQ(put(layout).status, 200u);

        const auto lines = support::anoctl({"convert", path, "-", "--id", "flexible1", "--json"});
        EXPECT_NE(lines.out.find(R"("fields":{"cells":[3.6,3.601]})"), std::string::npos) << lines.out << lines.err;
        EXPECT_NE(lines.out.find(R"("fields":{"later":)"), std::string::npos) << lines.out;
        EXPECT_NE(support::anoctl({"info", path}).out.find("layouts of flexible messages: flexible1"), std::string::npos);
        const auto table = support::anoctl({"convert", path, dir / (name + ".csv"), "--id", "flexible1"});
        EXPECT_EQ(table.exit, 0) << table.err;
        EXPECT_NE(support::file_text(dir / (name + ".csv")).find(",cells.0 [V],cells.1 [V],"), std::string::npos)
            << support::file_text(dir / (name + ".csv"));
        EXPECT_NE(support::file_text(dir / (name + "-2.csv")).find(",later,"), std::string::npos)
            << "the layout that follows has its own table";
        EXPECT_NE(table.err.find(name + "-2.csv"), std::string::npos) << table.err;
        const auto output = support::anoctl({"convert", path, "-", "--id", "flexible1"});
        EXPECT_NE(output.err.find("the layout changes in this recording"), std::string::npos) << output.err;

        // Converted to the other format, and to MCAP with decoded messages.
        const std::string again = dir / (name + "-again.mcap");
        EXPECT_EQ(support::anoctl({"convert", path, again}).exit, 0);
        const auto lines_again = support::anoctl({"convert", again, "-", "--id", "flexible1", "--json"});
        EXPECT_EQ(lines_again.out, lines.out) << format;
        std::ifstream in{again, std::ios::binary};
        const std::string bytes{std::istreambuf_iterator<char>{in}, {}};
        EXPECT_NE(bytes.find("/fc/device_30/flexible1"), std::string::npos) << "in the channels of the summary";
        const std::string config = dir.write("mine.json",
                                             R"({"flexible": [{"id": "0xF1", "fields": [{"name": "mine", "type": "u32"}]}]})");
        const std::string mine = dir / (name + "-mine.mcap");
        EXPECT_EQ(support::anoctl({"convert", path, mine, "--config", config}).exit, 0);
        EXPECT_NE(support::anoctl({"convert", mine, "-", "--id", "flexible1", "--json"}).out.find(R"("fields":{"mine":)"),
                  std::string::npos);
    }
}

TEST_F(Flexible, anoctl_record_uses_the_layouts_of_the_gateway) {
    start();
    EXPECT_EQ(put(layout).status, 200u);
    std::thread sender{[&] {
        for (int i = 0; i < 100; ++i, std::this_thread::sleep_for(20ms)) send(cells);
    }};
    const std::string path = dir / "mine.mcap";
    const auto recorded = support::anoctl({"record", path, "--seconds", "1", "--control", socket});
    sender.join();
    EXPECT_EQ(recorded.exit, 0) << recorded.err;
    EXPECT_NE(
        support::anoctl({"convert", path, "-", "--id", "flexible1", "--json"}).out.find(R"("fields":{"cells":[3.6,3.601]})"),
        std::string::npos);
}

// Replaces the layouts while `send` continues to send frames.
void while_layouts_change(const std::function<void()>& send, const std::function<void()>& replace, Process& run,
                          const std::function<bool()>& has_first, const std::function<bool()>& has_second) {
    EXPECT_TRUE(wait_until([&] { return send(), has_first(); })) << run.output();
    replace();
    EXPECT_TRUE(wait_until([&] { return send(), has_second(); })) << run.output();
    run.signal(SIGINT);
    run.wait();
}

TEST_F(Flexible, monitors_and_recordings_use_new_layouts_at_once) {
    start();
    const auto later = [&] { EXPECT_EQ(put(R"([{"id": "0xF1", "fields": [{"name": "later", "type": "u32"}]}])").status, 200u); };
    const auto sends = [&] { send(cells); };
    EXPECT_EQ(put(layout).status, 200u);
    Process monitor{ANOCTL, {"monitor", "--json", "--direction", "in", "--control", socket}};
    const auto shows = [&](const char* words) {
        return [&monitor, words] { return monitor.output().find(words) != std::string::npos; };
    };
    while_layouts_change(sends, later, monitor, shows(R"("cells":[3.6,3.601])"), shows(R"("later":)"));
    for (const std::string end : {"mcap", "pcapng"}) {
        EXPECT_EQ(put(layout).status, 200u);
        const std::string path = dir / ("while." + end);
        Process record{ANOCTL, {"record", path, "--control", socket}};
        const auto has = [&](const char* words) {
            return [&path, words] {
                std::error_code ec;
                return std::filesystem::exists(path, ec) &&
                       support::anoctl({"convert", path, "-", "--id", "flexible1", "--json"}).out.find(words) !=
                           std::string::npos;
            };
        };
        while_layouts_change(sends, later, record, has(R"("cells":[3.6,3.601])"), has(R"("later":)"));
        const auto all = support::anoctl({"convert", path, "-", "--id", "flexible1", "--json"}).out;
        EXPECT_NE(all.find(R"("cells":)"), std::string::npos) << "those before keep theirs: " << all;
        const auto info = support::anoctl({"info", path, "--json"}).out;
        EXPECT_NE(info.find(R"("name":"later")"), std::string::npos) << "the latest: " << info;
    }
}

// The program that plays a recording need not have the layouts.
TEST_F(Flexible, a_replay_uses_the_layouts_of_the_recording) {
    start();
    EXPECT_EQ(put(layout).status, 200u);
    const std::string path = dir / "flight.mcap";
    Process record{ANOCTL, {"record", path, "--control", socket}};
    EXPECT_TRUE(wait_until([&] {
        send(cells);
        return support::anoctl({"convert", path, "-", "--id", "flexible1", "--json"}).out.find("cells") != std::string::npos;
    }));
    record.signal(SIGINT);
    record.wait();
    const std::string other = dir / "other";
    Daemon player{ANOGATED, other, {"replay:" + path + ",name=tape,loop=on"}, {"STATE_DIRECTORY=" + (dir / "none")}};
    ASSERT_TRUE(player.until_answers());
    const auto fields = [&] {
        for (const json& row : json::parse(asked(other, "GET", "/messages").body))
            if (row.at("id") == 0xF1) return row.at("fields").dump();
        return std::string{};
    };
    EXPECT_TRUE(wait_until([&] { return fields().find("cells") != std::string::npos; })) << player.output();
    Process monitor{ANOCTL, {"monitor", "--json", "--id", "flexible1", "--count", "1", "--control", other}};
    EXPECT_EQ(monitor.wait(), 0) << monitor.output();
    EXPECT_NE(monitor.output().find(R"("cells":[3.6,3.601])"), std::string::npos) << monitor.output();
}

anogate::DecodingPtr one_layout(const std::string& text) { return anogate::Decoding::parse(R"({"flexible": )" + text + "}"); }

// Frames 1 s apart, the first half with `layout`, the second half with another.
std::string with_two_layouts(anogate::RecordingFormat format, const Bytes& first, const Bytes& second) {
    std::string bytes;
    const auto writer = anogate::make_recording_writer(format, {"test", 1, 1, one_layout(layout)}, bytes);
    for (std::uint64_t n = 1; n <= 20; ++n) {
        if (n == 11) writer->use(one_layout(R"([{"id": "0xF1", "fields": [{"name": "later", "type": "u32"}]}])"), bytes);
        writer->write(
            anogate::RecordedFrame{.time_ns = n * 1'000'000'000, .link = "fc", .frame = ano::FrameView{n <= 10 ? first : second}},
            bytes);
    }
    writer->end(bytes);
    return bytes;
}

// Bytes that are valid text in both encodings: "caf茅" or "café".
TEST(ConvertedTexts, have_the_recorded_encoding_also_with_other_layouts) {
    const TempDir dir;
    const Bytes log = frame(30, 0xFE, 0xA0, {0, 'c', 'a', 'f', 0xC3, 0xA9});
    std::string bytes;
    const auto gbk = anogate::Decoding::parse(R"({"flexible": [], "encoding": {"fc": "gbk"}})");
    ASSERT_TRUE(gbk);
    const auto writer = anogate::make_recording_writer(anogate::RecordingFormat::pcapng, {"test", 1, 1, gbk}, bytes);
    writer->write(anogate::RecordedFrame{.time_ns = 1, .link = "fc", .frame = ano::FrameView{log}}, bytes);
    writer->end(bytes);
    const std::string path = dir.write("texts.pcapng", bytes);
    const std::string config = dir.write("mine.json",
                                         R"({"flexible": [{"id": "0xF1", "fields": [{"name": "mine", "type": "u32"}]}]})");
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--config", config}}) {
        std::vector<std::string> words{"convert", path, "-", "--json"};
        words.insert(words.end(), more.begin(), more.end());
        const auto lines = support::anoctl(words);
        EXPECT_NE(lines.out.find("caf茅"), std::string::npos) << lines.out << lines.err;
    }
}

// The file is played repeatedly, and read ahead.
TEST_F(Flexible, each_frame_of_a_replay_is_decoded_by_the_layouts_it_was_recorded_with) {
    const Bytes number = frame(30, 0xFE, 0xF1, {7, 0, 0, 0});
    for (const auto format : {anogate::RecordingFormat::pcapng, anogate::RecordingFormat::mcap}) {
        const std::string kind{anogate::text(format)};
        const std::string path = dir.write("both." + kind, with_two_layouts(format, cells, number));
        const auto expect = [&](const std::string& lines, const std::string& by) {
            SCOPED_TRACE(by + " of " + kind);
            EXPECT_NE(lines.find(R"("fields":{"cells":[3.6,3.601]})"), std::string::npos) << lines;
            EXPECT_NE(lines.find(R"("fields":{"later":7})"), std::string::npos) << lines;
            EXPECT_EQ(lines.find(R"("fields":{"cells":[0.007,0.0]})"), std::string::npos) << lines;
            EXPECT_EQ(lines.find(R"("fields":{"later":2)"), std::string::npos) << lines;
        };
        expect(support::anoctl({"convert", path, "-", "--id", "flexible1", "--json"}).out, "convert");
        const std::string as_mcap = dir / (kind + "-again.mcap");
        EXPECT_EQ(support::anoctl({"convert", path, as_mcap}).exit, 0);
        expect(support::anoctl({"convert", as_mcap, "-", "--id", "flexible1", "--json"}).out, "convert to MCAP");
        const std::string other = dir / ("player-" + kind);
        Daemon player{ANOGATED, other, {"replay:" + path + ",name=tape,loop=on,rate=20"}, {"STATE_DIRECTORY=" + (dir / "none")}};
        ASSERT_TRUE(player.until_answers());
        Process monitor{ANOCTL, {"monitor", "--json", "--id", "flexible1", "--count", "60", "--control", other}};
        EXPECT_EQ(monitor.wait(), 0) << monitor.output();
        expect(monitor.output(), "monitor of a replay");
        const std::string again = dir / ("recorded-of-" + kind + ".mcap");
        Process record{ANOCTL, {"record", again, "--control", other}};
        EXPECT_TRUE(wait_until([&] {
            std::error_code ec;
            if (!std::filesystem::exists(again, ec)) return false;
            const std::string lines = support::anoctl({"convert", again, "-", "--id", "flexible1", "--json"}).out;
            return lines.find("cells") != std::string::npos && lines.find("later") != std::string::npos;
        })) << record.output();
        record.signal(SIGINT);
        record.wait();
        expect(support::anoctl({"convert", again, "-", "--id", "flexible1", "--json"}).out, "record of a replay");
    }
}

template <class Draft>
Bytes encoded(const Draft& draft) {
    Bytes bytes(64);
    bytes.resize(draft.encode(bytes, 0xDD, 0xFE));
    return bytes;
}

// Sends the frames of an LX unit turned by 40°: yaw of its Euler angles has the opposite sign.
void send_lx(UdpPeer& peer, std::uint16_t port) {
    ano::Draft<"euler"> euler;
    ano::Draft<"quaternion"> quaternion;
    EXPECT_TRUE(euler.set<"yaw">(40) && quaternion.set<"v0">(std::cos(-0.349066)) && quaternion.set<"v3">(std::sin(-0.349066)));
    peer.send(port, encoded(euler));
    peer.send(port, encoded(quaternion));
}

TEST_F(Flexible, contradicting_orientations_cause_a_hint_until_the_key_is_set) {
    start();
    const auto hint = [&] { return daemon->link("fc").at("hint").get<std::string>(); };
    EXPECT_TRUE(daemon->until([&](const json&) {
        send_lx(peer, daemon->port("fc"));
        return hint() == "Euler angles and quaternion of 0xDD contradict each other: try attitude=lx";
    })) << hint();
    stop();
    json config = {{"links", {"udp-listen:127.0.0.1:0,name=fc,attitude=lx"}}};
    dir.write("lx.json", config.dump());
    daemon = std::make_unique<Daemon>(ANOGATED, socket, std::vector<std::string>{"--config", dir / "lx.json"},
                                      std::vector<std::string>{"STATE_DIRECTORY=" + (dir / "state")});
    ASSERT_TRUE(daemon->until_answers());
    EXPECT_EQ(daemon->link("fc").at("attitude"), "lx");
    ASSERT_EQ(asked(socket, "POST", "/recordings", R"({"name": "lx", "format": "mcap", "message_encoding": "json"})").status,
              200u);
    for (int i = 0; i < 60; ++i, std::this_thread::sleep_for(50ms)) send_lx(peer, daemon->port("fc"));
    EXPECT_EQ(hint().find("contradict"), std::string::npos);
    ASSERT_EQ(asked(socket, "POST", "/recordings/lx/end").status, 200u);
    const std::string path = dir.write("lx.mcap", asked(socket, "GET", "/recordings/lx.mcap").body);
    EXPECT_EQ(json::parse(support::anoctl({"info", path, "--json"}).out).at("decoding").at("attitude").at("fc"), "lx");
}

}    // namespace
}    // namespace flexible_tests
