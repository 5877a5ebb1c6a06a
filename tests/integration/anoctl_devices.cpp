// `anoctl devices`, `param`, `command` and `waypoint`: through the running gateway, and over a link of their own.
#include <support/asked_devices.hpp>
#include <support/bytes.hpp>
#include <support/fake_loader.hpp>
#include <support/files.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <future>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace anoctl_devices_tests {
namespace {

using namespace support;
using nlohmann::json;

using AnoctlDevices = DeviceGateway;

TEST_F(AnoctlDevices, are_listed) {
    const Ran table = anoctl({"devices"});
    EXPECT_EQ(table.exit, 0);
    EXPECT_TRUE(contains(table.output, "ADDRESS")) << table.output;
    EXPECT_TRUE(contains(table.output, "0xDC")) << table.output;
    const Ran told = anoctl({"devices", "--json"});
    const auto devices = lines_of(told.output);
    ASSERT_EQ(devices.size(), 1u) << told.output;
    EXPECT_EQ(devices[0].at("address"), "0xDC");
    EXPECT_EQ(devices[0].at("link"), "fc");
}

TEST_F(AnoctlDevices, parameters_are_listed_read_and_written) {
    const Ran list = anoctl({"param", "list"});
    EXPECT_EQ(list.exit, 0) << list.output;
    EXPECT_TRUE(contains(list.output, "SIM_HEIGHT")) << list.output;
    EXPECT_TRUE(contains(list.output, "hover height, cm")) << list.output;
    const Ran all = anoctl({"param", "get", "--all", "--json"});
    EXPECT_EQ(all.exit, 0);
    const auto rows = lines_of(all.output);
    EXPECT_GT(rows.size(), 20u);
    for (const json& row : rows) EXPECT_TRUE(row.contains("value")) << row;
    const Ran set = anoctl({"param", "set", "SIM_TURN", "-30"});
    EXPECT_EQ(set.exit, 0) << set.output;
    EXPECT_EQ(set.output, "SIM_TURN=-30\n");
    const Ran clamped = anoctl({"param", "set", "SIM_TURN=100", "SIM_NOTE=2nd floor"});
    EXPECT_EQ(clamped.exit, 0) << clamped.output;
    EXPECT_TRUE(contains(clamped.output, "SIM_TURN=90 (device limited the requested 100)\n")) << clamped.output;
    const Ran get = anoctl({"param", "get", "SIM_TURN", "SIM_SERIAL"});
    EXPECT_EQ(get.output, "SIM_TURN=90\nSIM_SERIAL=687194767361\n") << get.output;
}

TEST_F(AnoctlDevices, errors_are_reported_with_their_exit_status) {
    const Ran unknown = anoctl({"param", "get", "SIM_TRN"});
    EXPECT_EQ(unknown.exit, 1);
    EXPECT_TRUE(contains(unknown.output, "anoctl: unknown parameter 'SIM_TRN' (did you mean 'SIM_TURN'?)")) << unknown.output;
    const Ran range = anoctl({"param", "set", "SIM_TURN", "300"});
    EXPECT_EQ(range.exit, 1) << range.output;
    EXPECT_EQ(anoctl({"param", "sett", "A", "1"}).output.find("anoctl: unknown action 'sett' (did you mean 'set'?)"), 0u);
    EXPECT_EQ(anoctl({"param", "set", "SIM_TURN"}).exit, 2);
    EXPECT_EQ(anoctl({"param", "import", dir / "nowhere"}).exit, 2);
    const Ran nobody = anoctl({"param", "get", "SIM_TURN", "--device", "Nobody"});
    EXPECT_EQ(nobody.exit, 1);
    EXPECT_TRUE(contains(nobody.output, "no device 'Nobody' responded")) << nobody.output;
}

TEST_F(AnoctlDevices, of_several_one_has_to_be_chosen) {
    hear_of_another();
    const Ran several = anoctl({"param", "get", "SIM_TURN"});
    EXPECT_EQ(several.exit, 2);
    EXPECT_TRUE(contains(several.output, "several devices found; choose one with --device: 0xDC")) << several.output;
    EXPECT_TRUE(contains(several.output, "0xDD")) << several.output;
    EXPECT_EQ(anoctl({"param", "get", "SIM_RANGE_OFFSET", "--device", "0xDC"}).exit, 0);
    EXPECT_EQ(anoctl({"param", "get", "SIM_RANGE_OFFSET", "--device", "flight_controller"}).exit, 0);
}

TEST_F(AnoctlDevices, an_import_lists_its_changes_and_writes_them_only_after_confirmation) {
    const std::string file = dir / "backup.json";
    ASSERT_EQ(anoctl({"param", "export", file}).exit, 0);
    json backup = json::parse(file_text(file));
    EXPECT_EQ(backup.at("device"), "0xDC");
    EXPECT_EQ(backup.at("name"), "SimFC");
    EXPECT_TRUE(backup.at("parameters").contains("CAL_AOFF_X"));
    EXPECT_TRUE(contains(anoctl({"param", "diff", file}).output, "no differences\n21 calibration parameters omitted"));

    backup["parameters"]["SIM_HEIGHT"] = 333;
    backup["parameters"]["CAL_AOFF_X"] = 5;
    dir.write("backup.json", backup.dump());
    const Ran diff = anoctl({"param", "diff", file});
    EXPECT_EQ(diff.exit, 1);
    EXPECT_TRUE(contains(diff.output, "SIM_HEIGHT: ")) << diff.output;
    EXPECT_TRUE(contains(diff.output, " -> 333\n")) << diff.output;
    EXPECT_FALSE(contains(diff.output, "CAL_AOFF_X")) << diff.output;
    const Ran calibration = anoctl({"param", "diff", file, "--with-calibration"});
    EXPECT_TRUE(contains(calibration.output, "CAL_AOFF_X: ")) << calibration.output;
    EXPECT_TRUE(contains(calibration.output, " -> 5\n")) << calibration.output;

    const Ran refused = anoctl({"param", "import", file});
    EXPECT_EQ(refused.exit, 2) << "nobody can be asked";
    EXPECT_TRUE(contains(refused.output, "--yes")) << refused.output;
    EXPECT_TRUE(contains(refused.output, " -> 333\n")) << refused.output;
    EXPECT_NE(anoctl({"param", "get", "SIM_HEIGHT"}).output, "SIM_HEIGHT=333\n");
    const Ran written = anoctl({"param", "import", file, "--yes"});
    EXPECT_EQ(written.exit, 0) << written.output;
    EXPECT_TRUE(contains(written.output, "1 parameter written")) << written.output;
    EXPECT_EQ(anoctl({"param", "get", "SIM_HEIGHT"}).output, "SIM_HEIGHT=333\n");
    EXPECT_NE(anoctl({"param", "get", "CAL_AOFF_X"}).output, "CAL_AOFF_X=5\n");
    EXPECT_EQ(anoctl({"param", "import", file}).exit, 0) << "nothing differs: nobody needs to be asked";
}

TEST_F(AnoctlDevices, defaults_are_restored_only_after_confirmation) {
    EXPECT_EQ(anoctl({"param", "reset"}).exit, 2);
    ASSERT_EQ(anoctl({"param", "set", "SIM_RANGE_OFFSET", "7"}).exit, 0);
    EXPECT_EQ(anoctl({"param", "save"}).exit, 0);
    ASSERT_EQ(anoctl({"command", "call", "TAKE_OFF", "300", "--yes"}).exit, 0);
    receive_mode();
    const Ran flies = anoctl({"param", "reset", "--yes"});
    EXPECT_EQ(flies.exit, 1);
    EXPECT_TRUE(contains(flies.output, "this is only allowed on the ground")) << flies.output;
    const Ran reset = anoctl({"param", "reset", "--yes", "--force"});
    EXPECT_EQ(reset.exit, 0) << reset.output;
    EXPECT_NE(anoctl({"param", "get", "SIM_RANGE_OFFSET"}).output, "SIM_RANGE_OFFSET=7\n");
}

TEST_F(AnoctlDevices, an_interrupt_cancels_the_job_and_reports_it) {
    hear_of_another();
    peer.forget();
    Process list{ANOCTL, {"param", "list", "--device", "0xDD", "--control", socket}};
    ASSERT_TRUE(wait_until([&] { return is_asked(); })) << list.output();
    list.signal(SIGINT);
    EXPECT_EQ(list.wait(), 130);
    EXPECT_TRUE(contains(list.output(), "anoctl: cancelled")) << list.output();
    EXPECT_TRUE(wait_until([&] { return contains(http(socket, "GET /jobs HTTP/1.0\r\n\r\n"), "\"cancelled\""); }));
}

TEST_F(AnoctlDevices, commands_are_listed_and_called_only_after_confirmation) {
    const Ran list = anoctl({"command", "list"});
    EXPECT_EQ(list.exit, 0) << list.output;
    EXPECT_TRUE(contains(list.output, "ADD u8 ")) << list.output;
    const Ran refused = anoctl({"command", "call", "TAKE_OFF", "300"});
    EXPECT_EQ(refused.exit, 2);
    EXPECT_TRUE(contains(refused.output, "--yes")) << refused.output;
    const Ran called = anoctl({"command", "call", "TURN", "-5", "--yes"});
    EXPECT_EQ(called.exit, 0) << called.output;
    EXPECT_TRUE(contains(called.output, "TURN -5: acknowledged\n")) << called.output;
    EXPECT_EQ(anoctl({"param", "get", "SIM_TURN"}).output, "SIM_TURN=-5\n");
    for (const char* wrong : {"200", "x", "1.5"}) EXPECT_EQ(anoctl({"command", "call", "TURN", wrong, "--yes"}).exit, 2) << wrong;
    EXPECT_EQ(anoctl({"command", "call", "TURN", "--yes"}).exit, 2);
    const Ran unknown = anoctl({"command", "call", "TAKEOFF", "--yes"});
    EXPECT_TRUE(contains(unknown.output, "did you mean 'TAKE_OFF'?")) << unknown.output;
    const Ran refuses = anoctl({"command", "call", "TAKE_OFF", "5", "--yes"});
    EXPECT_EQ(refuses.exit, 1) << "too low for it: it does not answer";
    EXPECT_TRUE(contains(refuses.output, "may have been carried out")) << refuses.output;
}

// The frames that anoctl and the button of the page send to the second device.
struct AnoctlCommands : AnsweringDevice {
    AnoctlCommands() {
        fake.commands = {{{1, 0, 1}, {3}, "TAKE_OFF", ""}, {{1, 0, 2}, {}, "LAND", ""}, {{1, 0, 3}, {}, "LOCK", ""}};
    }
    static Bytes ids_of(const std::vector<Bytes>& frames) {
        Bytes ids;
        for (const Bytes& one : frames)
            if (one[2] == 0xDD) ids.push_back(one[3]);
        return ids;
    }
    Bytes ids_heard() { return ids_of(std::exchange(fake.heard, {})); }
    void be_heard() {
        hear_of_another();
        ASSERT_EQ(asked({"command", "list"}).exit, 0);
        EXPECT_GE(ids_heard().size(), 5u);
    }
    const Bytes only_the_call{0xC0};
};

// By number: two parameters have the same name, and one has none.
TEST_F(AnoctlCommands, parameters_whose_names_are_not_unique_are_read_back_at_the_end_as_well) {
    fake.parameters = {{0, "P", "", {7}}, {0, "P", "", {8}}, {0, "", "", {9}}};
    hear_of_another();
    const Ran set = asked({"param", "set", "0=1", "1=2", "2=3"});
    EXPECT_EQ(set.exit, 0) << set.output;
    EXPECT_EQ(set.output, "P=1\nP=2\n=3\n");
    Bytes read_back;
    for (const Bytes& one : fake.heard) {
        if (one[3] == 0xE1) read_back.clear();
        if (one[3] == 0xE0 && one[6] == 2) read_back.push_back(one[7]);
    }
    for (const std::uint8_t id : {std::uint8_t{0}, std::uint8_t{1}, std::uint8_t{2}})
        EXPECT_GE(std::count(read_back.begin(), read_back.end(), id), 1) << "after the last write: " << int{id};
}

TEST_F(AnoctlCommands, that_were_read_are_called_by_the_first_frame) {
    be_heard();
    const Ran land = asked({"command", "call", "LAND", "--yes"});
    EXPECT_EQ(land.exit, 0) << land.output;
    EXPECT_EQ(ids_heard(), only_the_call);
    EXPECT_EQ(asked({"command", "call", "TAKE_OFF", "300", "--yes"}).exit, 0);
    EXPECT_EQ(ids_heard(), only_the_call);
    EXPECT_EQ(asked({"command", "call", "TAKE_OFF", "70000", "--yes"}).exit, 2);
    EXPECT_TRUE(ids_heard().empty()) << "checked against what was read";
    const Ran unknown = asked({"command", "call", "HOVER", "--yes"});
    EXPECT_EQ(unknown.exit, 2) << unknown.output;
    EXPECT_EQ(ids_heard()[0], 0xC1) << "it may be new";
}

// As after the board was replaced: the list that was read is no longer that of the device.
TEST_F(AnoctlCommands, whose_numbers_changed_are_read_again_once_and_called_once) {
    be_heard();
    fake.commands = {{{1, 0, 9}, {}, "HOVER", ""}, {{1, 0, 1}, {3}, "TAKE_OFF", ""}, {{1, 0, 8}, {}, "LAND", ""}};
    const auto speak = [&] {
        const auto before = gateway.count("peer", "frames_in");
        peer.send(gateway.port("peer"), frame_of_another());
        ASSERT_TRUE(wait_until([&] { return gateway.count("peer", "frames_in") > before; }));
        std::this_thread::sleep_for(20ms);    // frames within 167 ms count as one
    };
    const auto since = std::chrono::steady_clock::now();
    for (int i = 0; i < 30; ++i) speak();
    std::this_thread::sleep_for(1s + 4 * (std::chrono::steady_clock::now() - since));    // far longer than the pauses before
    speak();
    const Ran land = asked({"command", "call", "LAND", "--yes"});
    EXPECT_EQ(land.exit, 0) << land.output;
    EXPECT_TRUE(contains(land.output, "has different commands than before; reading them again\n")) << land.output;
    EXPECT_TRUE(contains(land.output, "LAND: acknowledged\n")) << land.output;
    std::vector<Bytes> calls;
    for (const Bytes& one : fake.heard)
        if (one[2] == 0xDD && one[3] == 0xC0) calls.push_back(one);
    ASSERT_EQ(calls.size(), 1u) << "never twice";
    EXPECT_EQ(Bytes(calls[0].begin() + 6, calls[0].begin() + 9), (Bytes{1, 0, 8}));
}

TEST_F(AnoctlCommands, that_were_read_are_called_from_the_page_by_the_first_frame) {
    be_heard();
    const std::string body = R"({"values":[],"repeat":false,"name":"LAND"})";    // as live/device.ts sends it
    const std::string request = "POST /devices/221/commands/1 HTTP/1.0\r\nContent-Type: application/json\r\nContent-Length: " +
                                std::to_string(body.size()) + "\r\n\r\n" + body;
    auto answered = std::async(std::launch::async, [&] { return http(socket, request); });
    EXPECT_TRUE(wait_until([&] {
        answer();
        return answered.wait_for(0s) == std::future_status::ready;
    }));
    const std::string said = answered.get();
    EXPECT_TRUE(contains(said, "200 OK")) << said;
    EXPECT_EQ(ids_heard(), only_the_call);
}

TEST_F(AnoctlCommands, are_called_by_their_three_bytes_without_any_other_request) {
    hear_of_another();
    const Ran called = asked({"command", "call", "--cid", "1,0,1", "u16:300", "--yes"});
    EXPECT_EQ(called.exit, 0) << called.output;
    EXPECT_TRUE(contains(called.output, "command 1,0,1 u16:300: acknowledged\n")) << called.output;
    ASSERT_FALSE(fake.heard.empty());
    EXPECT_EQ(Bytes(fake.heard[0].begin() + 3, fake.heard[0].end() - 2), (Bytes{0xC0, 5, 0, 1, 0, 1, 0x2C, 1}));
    EXPECT_EQ(ids_heard(), only_the_call);
    for (const char* cid : {"1,0", "1,0,1,", "1,0,256", "1;0;1", "a,b,c", ",,"})
        EXPECT_EQ(anoctl({"command", "call", "--cid", cid, "--device", "0xDD", "--yes"}).exit, 2) << cid;
    for (const char* value : {"u16:70000", "u16:x", "x"})
        EXPECT_EQ(anoctl({"command", "call", "--cid", "1,0,1", value, "--device", "0xDD", "--yes"}).exit, 2) << value;
    EXPECT_EQ(anoctl({"command", "call", "--cid", "1,0,1", "u17:1", "--device", "0xDD", "--yes"}).exit, 1);
    EXPECT_TRUE(ids_heard().empty());
}

TEST_F(AnoctlCommands, with_a_type_that_the_device_does_not_report_are_called_once_it_is_stated) {
    fake.commands = {{{1, 0, 7}, {7}, "SEVEN", ""}};
    hear_of_another();
    const Ran list = asked({"command", "list"});
    EXPECT_TRUE(contains(list.output, "SEVEN f32|u64")) << list.output;
    const Ran refused = asked({"command", "call", "SEVEN", "2", "--yes"});
    EXPECT_EQ(refused.exit, 1);
    EXPECT_TRUE(contains(refused.output, "state it once, --type7 f32 or --type7 u64")) << refused.output;
    EXPECT_EQ(asked({"command", "call", "SEVEN", "2", "--yes", "--type7", "u16"}).exit, 2);
    fake.heard.clear();
    EXPECT_EQ(asked({"command", "call", "SEVEN", "2", "--yes", "--type7", "u64"}).exit, 0);
    const Ran kept = asked({"command", "call", "SEVEN", "2", "--yes"});
    EXPECT_EQ(kept.exit, 0) << kept.output;
    EXPECT_EQ(ids_of({fake.heard.back()}), only_the_call);
    EXPECT_EQ(fake.heard.back().size(), 8u + 3 + 8);
    std::string name;
    for (const auto& entry : std::filesystem::directory_iterator{socket + ".state"})
        if (entry.path().filename().string().starts_with("type7-0xDD-")) name = entry.path().string();
    const json note = json::parse(file_text(name));    // read at the next start
    EXPECT_EQ(note.at("type7"), "u64");
    EXPECT_EQ(note.at("device").at("name"), "fake");
}

struct AnoctlParameters : AnsweringDevice {
    AnoctlParameters() { fake.make_parameters(30); }
    void be_read() {
        hear_of_another();
        ASSERT_EQ(asked({"param", "list"}).exit, 0);
        fake.heard.clear();
    }
    /// Without repeated frames.
    std::size_t different_frames() const { return std::set<Bytes>(fake.heard.begin(), fake.heard.end()).size(); }
};

TEST_F(AnoctlParameters, that_are_known_are_read_with_one_check_and_a_request_per_value) {
    be_read();
    const Ran got = asked({"param", "get", "PAR_20", "PAR_10", "0"});
    EXPECT_EQ(got.exit, 0) << got.output;
    EXPECT_EQ(got.output, "PAR_20=20\nPAR_10=10\nPAR_0=0\n");
    EXPECT_EQ(different_frames(), 5u) << "device info, number, three values";
    const Ran unknown = asked({"param", "get", "PAR_20", "PAR_99"});
    EXPECT_EQ(unknown.exit, 1);
    EXPECT_TRUE(contains(unknown.output, "no parameter is named 'PAR_99' (did you mean")) << unknown.output;
}

TEST_F(AnoctlParameters, that_are_known_are_written_after_one_check) {
    be_read();
    const Ran set = asked({"param", "set", "PAR_0=5", "PAR_10=6"});
    EXPECT_EQ(set.exit, 0) << set.output;
    EXPECT_EQ(set.output, "PAR_0=5\nPAR_10=6\n");
    EXPECT_EQ(different_frames(), 6u) << "device info, number, two values (read back by the same question), two writes";
    fake.heard.clear();
    EXPECT_EQ(asked({"param", "set", "PAR_20", "7"}).exit, 0);
    EXPECT_EQ(different_frames(), 5u) << "device info, its description beside its value, number, one write";
    const auto rows = lines_of(asked({"param", "set", "PAR_0=1", "PAR_10=2", "--json"}).output);
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0],
              json::parse(R"({"id": 0, "name": "PAR_0", "type": "u8", "was": 5, "written": 1, "stored": 1, "clamped": false,
                                        "acknowledged": true})"));
    fake.parameters[10].store = [](const Bytes&) { return Bytes{2}; };
    const Ran refused = asked({"param", "set", "PAR_0=8", "PAR_10=9", "PAR_20=9"});
    EXPECT_EQ(refused.exit, 1);
    EXPECT_TRUE(contains(refused.output, "PAR_0=8\n")) << refused.output;
    EXPECT_TRUE(contains(refused.output, "keeps PAR_10 at 2; not written: PAR_20")) << refused.output;
}

TEST(AnoctlCommandsOfALink, by_their_three_bytes_are_called_by_the_first_frame) {
    UdpPeer device;
    FakeDevice fake;
    fake.commands = {{{1, 0, 2}, {}, "LAND", ""}};
    Process call{ANOCTL,
                 {"command", "call", "--cid", "1,0,2", "--device", "0xDC", "--yes", "--link",
                  "udp:" + device.local().text() + ",bind=127.0.0.1:0"}};
    EXPECT_TRUE(wait_until([&] {
        for (const Bytes& one : device.frames())
            for (const Bytes& said : fake.take(ano::FrameView{one})) device.send(device.last_sender(), said);
        return !call.is_running();
    }));
    EXPECT_EQ(call.wait(), 0) << call.output();
    ASSERT_EQ(fake.heard.size(), 1u);
    EXPECT_EQ(fake.heard[0][3], 0xC0);
}

TEST_F(AnoctlDevices, waypoints_are_exported_to_a_file_and_imported_again) {
    const std::string file = dir / "way.json", plan = dir / "way.geojson";
    ASSERT_EQ(anoctl({"waypoint", "get", file}).exit, 0);
    json way = json::parse(file_text(file));
    ASSERT_FALSE(way.at("waypoints").empty());
    json second = way["waypoints"][0];
    second["num"] = 1;
    way["waypoints"].push_back(second);
    dir.write("way.json", way.dump());
    const Ran put = anoctl({"waypoint", "put", file, "--yes"});
    EXPECT_EQ(put.exit, 0) << put.output;
    EXPECT_TRUE(contains(put.output, ": 2 waypoints written\n")) << put.output;
    EXPECT_EQ(json::parse(anoctl({"waypoint", "get"}).output).at("waypoints").size(), 2u);
    ASSERT_EQ(anoctl({"waypoint", "get", plan}).exit, 0);
    EXPECT_EQ(json::parse(file_text(plan)).at("type"), "FeatureCollection");
    EXPECT_EQ(anoctl({"waypoint", "put", plan, "--yes"}).exit, 0);
    EXPECT_EQ(anoctl({"waypoint", "put", dir.write("no.json", "{")}).exit, 2);
}

class AnoctlFlash : public AnsweringDevice {
protected:
    AnoctlFlash() {
        fake.instead = [this](ano::FrameView frame) { return loader.take(fake, frame); };
    }
    std::vector<std::string> flash(const std::string& file) const {
        return {"flash", file, "--device", "0xDD", "--yes", "--control", socket};
    }

    FakeLoader loader;
};

TEST_F(AnoctlFlash, firmware_is_written_and_checked) {
    hear_of_another();
    loader.reads_codes = true;
    const std::string image(1000, '\1');
    const std::string file = dir.write("new.bin", image);
    const Ran refused = anoctl({"flash", file, "--device", "0xDD"});
    EXPECT_EQ(refused.exit, 2);
    EXPECT_TRUE(contains(refused.output, "--yes")) << refused.output;
    EXPECT_EQ(anoctl({"flash", dir.write("empty.bin", ""), "--device", "0xDD", "--yes"}).exit, 2);
    EXPECT_EQ(anoctl({"flash", dir.write("backup.json", "{}"), "--device", "0xDD", "--yes"}).exit, 2) << "no firmware";
    EXPECT_EQ(anoctl({"flash", dir.write("no.bia", "hello"), "--device", "0xDD", "--yes"}).exit, 2) << "no header of a .bia";
    Process process{ANOCTL, flash(file)};
    EXPECT_EQ(until_ended(process), 0) << process.output();
    EXPECT_TRUE(contains(process.output(), ": written and verified, 6 frames, ")) << process.output();
    EXPECT_EQ(loader.flash, Bytes(image.begin(), image.end()));
    EXPECT_TRUE(contains(process.output(), "anoctl: ")) << "the steps: " << process.output();
}

TEST_F(AnoctlFlash, a_file_that_is_not_firmware_is_reported_and_nothing_is_sent) {
    hear_of_another();
    Process process{ANOCTL, flash(dir.write("short.bia", "bia"))};
    EXPECT_EQ(until_ended(process), 1) << process.output();
    EXPECT_EQ(loader.infos, 0u);
}

TEST_F(AnoctlFlash, an_interrupt_in_the_middle_reports_that_the_device_is_still_in_its_loader) {
    hear_of_another();
    Process process{ANOCTL, flash(dir.write("new.bin", std::string(60'000, '\x01')))};
    bool is_interrupted = false;
    EXPECT_EQ(until_ended(process,
                          [&] {
                              if (loader.frames > 5 && !std::exchange(is_interrupted, true)) process.signal(SIGINT);
                          }),
              130)
        << process.output();
    EXPECT_TRUE(contains(process.output(), "the device is still in its loader: flash it again")) << process.output();
}

TEST_F(AnoctlDevices, a_calibration_that_is_interrupted_leaves_the_old_values) {
    EXPECT_EQ(anoctl({"calibrate", "gyroscope"}).exit, 2);
    EXPECT_EQ(anoctl({"calibrate", "compass"}).exit, 2) << "nobody can be asked";
    ASSERT_EQ(anoctl({"command", "call", "LAND", "--yes"}).exit, 0);
    receive_mode();
    ASSERT_EQ(anoctl({"param", "set", "CAL_AOFF_X", "1.5"}).exit, 0);
    Process process{ANOCTL, {"calibrate", "accelerometer", "--yes", "--control", socket}};
    EXPECT_TRUE(process.until_says("of 6 faces")) << process.output();
    process.signal(SIGINT);
    EXPECT_EQ(process.wait(), 130) << process.output();
    EXPECT_TRUE(contains(process.output(), "anoctl: cancelled")) << process.output();
    EXPECT_EQ(anoctl({"param", "get", "CAL_AOFF_X"}).output, "CAL_AOFF_X=1.5\n");
}

TEST_F(AnoctlDevices, names_are_completed) {
    EXPECT_TRUE(wait_until([&] { return contains(anoctl({"__complete", "names"}).output, "\t0xDC\n"); }));
    EXPECT_TRUE(wait_until([&] { return contains(anoctl({"__complete", "parameters", "param", "get"}).output, "SIM_TURN\t"); }));
}

TEST_F(AnoctlDevices, are_not_asked_without_a_gateway_and_a_hint_is_shown) {
    Process none{ANOCTL, {"param", "list", "--control", dir / "nothing"}};
    EXPECT_EQ(none.wait(), 1);
    EXPECT_TRUE(contains(none.output(), dir / "nothing")) << none.output();
    EXPECT_TRUE(contains(none.output(), "; to start one: anogated LINK...; to work without a gateway, add --link LINK\n"))
        << none.output();
}

TEST(AnoctlDevicesOfALink, are_read_and_written_without_a_gateway) {
    TempDir dir;
    const auto by_link = [](std::vector<std::string> words) {
        words.insert(words.end(), {"--link", "sim:fc"});
        Process process{ANOCTL, std::move(words)};
        const int exit = process.wait();
        return DeviceGateway::Ran{exit, process.output()};
    };
    const auto contains = DeviceGateway::contains;
    const auto devices = by_link({"devices"});
    EXPECT_EQ(devices.exit, 0) << devices.output;
    EXPECT_TRUE(contains(devices.output, "SimFC")) << devices.output;
    const auto set = by_link({"param", "set", "SIM_TURN", "-5"});
    EXPECT_EQ(set.exit, 0) << set.output;
    EXPECT_TRUE(contains(set.output, "SIM_TURN=-5\n")) << set.output;
    EXPECT_EQ(by_link({"param", "export", dir / "backup.json"}).exit, 0);
    EXPECT_TRUE(json::parse(file_text(dir / "backup.json")).at("parameters").contains("SIM_NOTE"));
    Process absent{ANOCTL, {"param", "list", "--link", "serial:" + (dir / "absent")}};
    EXPECT_EQ(absent.wait(), 1);
    EXPECT_TRUE(contains(absent.output(), "absent not found")) << absent.output();
}

TEST_F(AnoctlDevices, confirmations_and_a_progress_bar_are_shown_on_a_terminal) {
    if (std::system("tmux -V > /dev/null 2>&1") != 0) GTEST_SKIP() << "tmux is not installed";
    const auto tmux = [&](const std::string& words) {
        return std::system(("TERM=xterm tmux -S " + (dir / "tmux") + " " + words + " 2>/dev/null").c_str());
    };
    ASSERT_EQ(anoctl({"command", "call", "LAND", "--yes"}).exit, 0);    // the device to be calibrated reports that it has landed
    receive_mode();
    const std::string file = dir / "other.json";
    dir.write("other.json", R"({"name": "Other", "dev_id": 1, "parameters": {"SIM_HEIGHT": 444}})");
    ASSERT_EQ(tmux("-f /dev/null new-session -d -x 120 -y 24 -s t 'sh'"), 0);
    const auto type = [&](const std::string& words) { tmux("send-keys -t t '" + words + "' Enter"); };
    std::string screen;
    const auto shows = [&](const std::string& words) {
        return wait_until([&] {
            Process capture{"tmux", {"-S", dir / "tmux", "capture-pane", "-p", "-t", "t"}};
            capture.wait();
            screen = capture.output();
            return contains(screen, words);
        });
    };
    type(ANOCTL " param import " + file + " --control " + socket + "; echo ended as $?");
    EXPECT_TRUE(shows("the file is for Other, device type 1, but the device is SimFC"));
    EXPECT_TRUE(shows("Continue anyway? [y/N]"));
    type("y");
    EXPECT_TRUE(shows("Write 1 parameter to SimFC (0xDC)? [y/N]"));
    type("n");
    EXPECT_TRUE(shows("ended as 1"));
    EXPECT_NE(anoctl({"param", "get", "SIM_HEIGHT"}).output, "SIM_HEIGHT=444\n");
    type("clear; " ANOCTL " calibrate accelerometer --control " + socket + "; echo ended as $?");
    EXPECT_TRUE(shows("six faces"));
    type("y");
    EXPECT_TRUE(shows("(Enter continues, Ctrl-C cancels)"));
    type("");
    EXPECT_TRUE(shows("[ ] -x"));
    EXPECT_FALSE(contains(screen, "Enter continues")) << "a line is left over: " << screen;
    tmux("send-keys -t t C-c");
    EXPECT_TRUE(shows("ended as 130"));
    type("clear");
    hear_of_another();
    type(ANOCTL " param list --device 0xDD --control " + socket + "; echo ended as $?");
    EXPECT_TRUE(shows("reading parameters"));
    tmux("send-keys -t t C-c");
    EXPECT_TRUE(shows("ended as 130"));
    tmux("kill-server");
}

}    // namespace
}    // namespace anoctl_devices_tests
