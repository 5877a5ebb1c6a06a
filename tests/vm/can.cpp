// Frames cut into pieces on the bus, and reassembled.
#include "can.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <thread>

namespace anogate::vm {
namespace {

TEST_F(Can, an_11_bit_frame_on_the_wire_has_base_and_source_as_id_and_pieces_of_8_bytes) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    auto bus = dump();
    app.send(gateway.port("app"), frame(0xFE, 0xFF, 0xA0, data_of(3)));
    EXPECT_EQ(dumped(*bus, 2), (std::vector<std::string>{"6FE#ABFEFFA003000102", "6FE#0351C5"}));
    app.send(gateway.port("app"), frame(0x01, 0xFF, 0x03));    // sent now, it would overtake the less urgent one
    EXPECT_EQ(dumped(*bus, 1), std::vector<std::string>{"601#AB01FF030000AE0C"});
    EXPECT_EQ(gateway.count("vcan0", "frames_out"), 2u) << gateway.status();
    EXPECT_EQ(gateway.count("vcan0", "frames_in"), 0u);    // own frames are not received
}

TEST_F(Can, frames_received_during_a_stall_of_the_gateway_keep_their_age) {
    for (const std::string can : {"can:vcan0", "can:vcan0,framing=isotp,tx=0x101,rx=0x102"}) {
        RunningGateway gateway{loop, {can, app.link("app") + ",age.control=2s"}};
        EXPECT_TRUE(loop.until([&] { return gateway.up("vcan0"); }));
        const auto send = [&](std::uint8_t n) {
            const Bytes sticks = frame(0xFE, 0xDC, 0x41, Bytes(14, n));
            if (can == "can:vcan0") return BusSocket{"vcan0"}.send(sticks);
            std::string spaced;
            for (const std::uint8_t byte : sticks) spaced += hex({&byte, 1}) + " ";
            EXPECT_EQ(run("echo " + spaced + "| isotpsend -s 102 -d 101 vcan0"), 0);
        };
        send(1);
        std::this_thread::sleep_for(2500ms);    // the loop does not run
        send(2);
        EXPECT_EQ(received(app, 1), Frames{frame(0xFE, 0xDC, 0x41, Bytes(14, 2))}) << can;
        EXPECT_EQ(gateway.count("app", "stale"), 1u) << can;
    }
}

TEST_F(Can, base_moves_the_ids) {
    RunningGateway gateway{loop, {"can:vcan0,base=0x100", app.link("app")}};
    auto bus = dump();
    app.send(gateway.port("app"), frame(0xFE, 0xFF, 0x03));
    EXPECT_EQ(dumped(*bus, 1).at(0).substr(0, 4), "1FE#");
}

TEST_F(Can, a_29_bit_id_contains_class_source_and_destination) {
    RunningGateway gateway{loop, {"can:vcan0,extended", app.link("app")}};
    auto bus = dump();
    for (const std::uint8_t id : Bytes{0xC0, 0x03, 0xB0}) app.send(gateway.port("app"), frame(0xFE, 0xDC, id));
    const auto lines = dumped(*bus, 3);
    ASSERT_EQ(lines.size(), 3u);
    std::vector<std::string> ids;
    for (const auto& line : lines) ids.push_back(line.substr(0, 9));
    std::sort(ids.begin(), ids.end());
    EXPECT_EQ(ids, (std::vector<std::string>{"0AB0FEDC#", "0AB1FEDC#", "0AB2FEDC#"}));
}

TEST_F(Can, fd_pieces_have_up_to_64_bytes_zero_padding_and_by_default_the_bit_rate_switch) {
    for (const bool brs : {true, false}) {
        RunningGateway gateway{loop, {brs ? "can:vcan0,fd" : "can:vcan0,fd,brs=false", app.link("app")}};
        auto bus = dump();
        const Bytes large = frame(0xFE, 0xFF, 0x03, data_of(65)), small = frame(0xFE, 0xFF, 0x03);
        app.send(gateway.port("app"), large);
        app.send(gateway.port("app"), small);
        const auto lines = dumped(*bus, 3);
        ASSERT_EQ(lines.size(), 3u);
        const std::string flags = brs ? "##[15]" : "##[04]";    // newer kernels add FDF, 4
        EXPECT_TRUE(lines[0].substr(0, 3) == "6FE" && lines[0].substr(6) == hex(std::span{large}.first(64))) << lines[0];
        EXPECT_EQ(lines[1].substr(6), hex(std::span{large}.subspan(64)) + "000000");
        EXPECT_EQ(lines[2].substr(6), hex(small));
        for (const auto& line : lines) EXPECT_NE(flags.find(line.at(5)), std::string::npos) << line;
    }
}

TEST_F(Can, frames_of_cansend_are_received_as_classic_extended_and_fd) {
    const std::pair<const char*, const char*> kinds[] = {{"", ""}, {"extended", ""}, {"", "fd"}, {"extended", "fd"}};
    for (const auto& [extended, fd] : kinds) {
        CanSettings can;
        can.extended = *extended;
        can.fd = *fd;
        RunningGateway gateway{loop,
                               {std::string{"can:vcan0"} + (can.extended ? ",extended" : "") + (can.fd ? ",fd" : ""),
                                app.link("app") + ",age.telemetry=60s"}};
        const Bytes sent = frame(0xDC, 0xFE, 0x03, data_of(20));
        std::string command = "true";
        for (const std::string& piece : cut(sent, can)) command += " && cansend vcan0 '" + piece + "'";
        ASSERT_EQ(run(command), 0);    // the loop stalls meanwhile
        EXPECT_EQ(received(app, 1), Frames{sent});
        EXPECT_EQ(gateway.count("vcan0", "skipped_bytes"), 0u);
        EXPECT_EQ(gateway.count("vcan0", "bytes_in"), sent.size());
    }
}

TEST_F(Can, twenty_senders_interleaved_by_canplayer_are_received_completely) {
    std::vector<std::vector<std::string>> senders;
    for (std::uint8_t s = 1; s <= 20; ++s) {
        senders.emplace_back();
        for (std::uint8_t n = 0; n < 10; ++n)
            for (auto& piece : cut(frame(s, 0xFE, 0x03, data_of(8u + s, n)), {})) senders.back().push_back(piece);
    }
    const std::string log = testing::TempDir() + "twenty.log";
    std::ofstream file{log};
    for (std::size_t i = 0; i < 50; ++i)
        for (const auto& sender : senders)
            if (i < sender.size()) file << "(0.000000) vcan0 " << sender[i] << '\n';
    file.close();
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    Shell player{"canplayer -t -I " + log};
    const auto frames = received(app, 200);
    EXPECT_EQ(frames.size(), 200u);
    std::map<std::uint8_t, std::uint8_t> next;
    for (const Bytes& f : frames) EXPECT_EQ(f, frame(f[1], 0xFE, 0x03, data_of(8u + f[1], next[f[1]]++)));
    EXPECT_EQ(gateway.count("vcan0", "skipped_bytes"), 0u);
    std::remove(log.c_str());
}

TEST_F(Can, a_lost_can_frame_damages_only_one_v8_frame) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    BusSocket bus{"vcan0"};
    for (std::size_t i = 0; i < 40; ++i) bus.send(frame(0xDC, 0xFE, 0x03, data_of(17)), {}, i == 20 ? 1 : SIZE_MAX);
    EXPECT_EQ(received(app, 39).size(), 39u);
    EXPECT_EQ(gateway.count("vcan0", "frames_in"), 39u);
}

TEST_F(Can, an_incomplete_frame_does_not_block_others_for_long) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    ASSERT_EQ(run("cansend vcan0 6DC#ABDCFE03C8000102"), 0);    // 200 bytes announced
    BusSocket bus{"vcan0"};
    bus.send(frame(0xDC, 0xFE, 0x03, data_of(17)));
    EXPECT_EQ(received(app, 1, 10s), Frames{frame(0xDC, 0xFE, 0x03, data_of(17))});
    EXPECT_EQ(gateway.count("vcan0", "expired"), 1u) << gateway.status();
}

TEST_F(Can, a_frame_whose_source_differs_from_its_id_is_refused_and_counted) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    ASSERT_EQ(run("cansend vcan0 6DD#" + hex(frame(0xDC, 0xFE, 0x03))), 0);
    EXPECT_TRUE(loop.until([&] { return gateway.count("vcan0", "denied_in") == 1; }));
    EXPECT_EQ(gateway.count("vcan0", "wrong_source"), 1u);
    EXPECT_TRUE(app.frames().empty());
}

TEST_F(Can, other_traffic_on_the_bus_is_filtered_by_the_kernel) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    BusSocket bus{"vcan0"};
    for (const char* other : {"5FF#AB01", "700#AB01", "000006DC#AB01", "6DC#R8"})
        ASSERT_EQ(run(std::string{"cansend vcan0 "} + other), 0);
    bus.send(frame(0xDC, 0xFE, 0x03));
    EXPECT_EQ(received(app, 1).size(), 1u);
    EXPECT_EQ(gateway.count("vcan0", "bytes_in"), 8u);
}

TEST_F(Can, noise_at_full_rate_harms_nothing) {
    RunningGateway gateway{loop, {"can:vcan0", app.link("app")}};
    BusSocket bus{"vcan0"};
    Shell full{"cangen vcan0 -g 0 -i -I 6DD -L 8 -D r -n 20000"};
    Shell any_length{
        "cangen vcan0 -g 0 -i -I 601 -D r -n 20000"};    // no random id: noise within a frame of ours destroys that frame
    const double before = cpu_seconds(RUSAGE_SELF), theirs = cpu_seconds(RUSAGE_CHILDREN);
    std::size_t sent = 0, got = 0;
    loop.until(
        [&] {
            if (sent - got < 20) bus.send(frame(0xDC, 0xFE, 0x03, data_of(17))), ++sent;
            got += app.frames().size();
            return !full.is_running() && !any_length.is_running();
        },
        120s);
    EXPECT_TRUE(loop.until([&] { return (got += app.frames().size()) >= sent; }));
    EXPECT_EQ(got, sent);
    EXPECT_GT(sent, 20u);
    const double ours = cpu_seconds(RUSAGE_SELF) - before, noise = cpu_seconds(RUSAGE_CHILDREN) - theirs;
    RecordProperty("cpu_to_noise", std::to_string(ours / noise));
    EXPECT_LT(ours, 2 * noise) << "the test's own frames included: " << ours << " s beside " << noise
                               << " s of those who make it";
    EXPECT_TRUE(gateway.up("vcan0"));
    EXPECT_GT(gateway.count("vcan0", "skipped_bytes"), 100'000u);
    EXPECT_EQ(gateway.count("vcan0", "kernel_drops"), 0u);
}

}    // namespace
}    // namespace anogate::vm
