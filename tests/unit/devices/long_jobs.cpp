// An upgrade and a calibration: jobs that are answered at once, with steps, to be cancelled and to go on.
#include <host/calibration.hpp>
#include <support/fake_loader.hpp>
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace long_jobs_tests {
namespace {

using namespace support;
using json = nlohmann::ordered_json;

struct LongJobs : testing::Test {
    SimulatedNet net;
    FakeDevice& fake = net.add();
    FakeLoader loader;

    json until_over(int id, Duration limit = 1h) {
        json job;
        net.until(
            [&] {
                job = net.ask("GET", "/jobs/" + std::to_string(id)).json;
                return job.at("state") != "running" && job.at("state") != "waiting";
            },
            limit);
        return job;
    }
    void load() {
        fake.instead = [this](ano::FrameView f) { return loader.take(fake, f); };
    }
};

TEST_F(LongJobs, an_upgrade_writes_the_whole_file) {
    load();
    const std::string file(10'000, '\x5A');
    const auto [status, job] = net.ask("POST", "/devices/0xDC/firmware", file);
    EXPECT_EQ(status, 202u);
    EXPECT_EQ(job.at("kind"), "firmware");
    EXPECT_EQ(job.at("state"), "running");
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 409u) << "it answers nothing else meanwhile";
    const json over = until_over(1);
    EXPECT_EQ(over.at("state"), "done") << over;
    EXPECT_EQ(over.at("result").at("bytes"), 10'000);
    EXPECT_EQ(over.at("result").at("frames"), 52);
    EXPECT_EQ(over.at("unit"), "bytes");
    EXPECT_EQ(over.at("progress"), 1.0);
    EXPECT_EQ(loader.flash, Bytes(10'000, 0x5A));
}

TEST_F(LongJobs, an_upgrade_that_is_refused_says_so) {
    load();
    loader.refuses = true;
    net.ask("POST", "/devices/0xDC/firmware", std::string(1000, 'x'));
    json over = until_over(1);
    EXPECT_EQ(over.at("state"), "failed");
    EXPECT_EQ(over.at("status"), 502);
    net.ask("POST", "/devices/0xDC/firmware", "");
    over = until_over(2);
    EXPECT_EQ(over.at("status"), 422) << over;
    EXPECT_EQ(loader.erases, 0u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/firmware?crc=crc99", "x").status, 400u);
}

TEST_F(LongJobs, an_upgrade_that_is_cancelled_says_what_is_half_done) {
    load();
    net.ask("POST", "/devices/0xDC/firmware", std::string(100'000, 'x'));
    ASSERT_TRUE(net.until([&] { return loader.frames > 10; }));
    const json over = net.ask("DELETE", "/jobs/1").json;
    EXPECT_EQ(over.at("state"), "cancelled");
    EXPECT_NE(over.at("error").get<std::string>().find("loader"), std::string::npos) << over;
}

TEST_F(LongJobs, a_device_that_is_left_in_its_loader_is_known_behind_a_restart) {
    load();
    net.ask("GET", "/devices/0xDC/parameters");
    net.ask("POST", "/devices/0xDC/firmware", std::string(100'000, 'x'));
    ASSERT_TRUE(net.until([&] { return loader.frames > 10; }));
    ASSERT_TRUE(net.kept.contains("firmware-0xDC.json"));
    auto lines = net.lines("GET", "/jobs/2");
    net.service.stop(net.time);
    std::string text;
    lines->next(text);
    EXPECT_EQ(json::parse(text).at("state"), "cancelled");
    EXPECT_EQ(json::parse(text).at("error"), "the gateway ends: cancelled; it is left in its loader, begin again");

    SimulatedNet again;
    again.add();
    again.kept = net.kept;
    again.service.remember("firmware-0xDC.json", net.kept.at("firmware-0xDC.json"));
    EXPECT_EQ(again.ask("GET", "/devices").json.at("devices")[0].at("in_loader"), true);
    FakeLoader other;
    again.fakes[0]->instead = [&](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0) return std::vector<Bytes>{};    // a loader does not say who it is
        return other.take(*again.fakes[0], f);
    };
    Bytes file(300);    // a .bia for the device that it was
    file[0] = 'b', file[1] = 'i', file[2] = 'a';
    const Bytes image(file.begin() + 100, file.end());
    ano::store(&file[12], ano::crc16_of(image));
    const json known = json::parse(net.kept.at("firmware-0xDC.json")).at("device");
    file[20] = known.at("dev_id").get<std::uint8_t>();
    ano::store(&file[30], known.at("hw").get<std::uint16_t>());
    ano::store(&file[32], known.at("hw").get<std::uint16_t>());
    again.ask("POST", "/devices/0xDC/firmware", std::string(file.begin(), file.end()));
    json over;
    again.until([&] { return (over = again.ask("GET", "/jobs/1").json).at("state") != "running"; });
    EXPECT_EQ(over.at("state"), "done") << over;
    EXPECT_TRUE(again.kept.empty());
    EXPECT_FALSE(again.ask("GET", "/devices").json.at("devices")[0].contains("in_loader"));
}

TEST_F(LongJobs, one_for_which_there_is_no_place_may_be_asked_for_again) {
    net.add(0xDD);
    net.add(0xDE);
    const auto ask = [&](const std::string& device) {
        return net.routes.answer(SimulatedNet::request("POST", "/devices/" + device + "/firmware", "x"));
    };
    EXPECT_EQ(ask("0xDC").status, 202u);
    EXPECT_EQ(ask("0xDD").status, 202u);
    const auto third = ask("0xDE");
    EXPECT_EQ(third.status, 503u);
    EXPECT_EQ(anogate::http::field_value(third.headers, "Retry-After"), "1");
}

struct Calibrates : LongJobs {
    Calibrates() {
        double value = 0.5;
        for (const std::string& name : ano::host::calibration_names(ano::host::Sensor::accelerometer)) {
            Bytes bytes(4);
            ano::store(bytes.data(), static_cast<float>(value += 0.125));
            fake.parameters.push_back({8, name, "", bytes});
        }
        before = fake.parameters[0].value;
    }
    std::string state() { return net.ask("GET", "/jobs/1").json.at("state").get<std::string>(); }
    void lie(std::size_t face) {
        ano::Draft<"inertial"> m;
        std::array<int, 3> acc{20, 0, 0};
        acc[face / 2] += face % 2 == 0 ? 1000 : -1000;
        for (int i = 0; i < 100; ++i) {
            (void)m.set<"acc_x">(acc[0] + i % 3);
            (void)m.set<"acc_y">(acc[1] - i % 3);
            (void)m.set<"acc_z">(acc[2] + i % 2);
            std::array<std::uint8_t, 64> bytes{};
            const std::size_t size = m.encode(bytes, 0xDC, 0xFF);
            net.passes(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
        }
        net.pass(200ms);
    }

    Bytes before;
};

TEST_F(Calibrates, when_it_was_told_to_go_on_and_lay_on_every_face) {
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})").status, 202u);
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    EXPECT_EQ(net.kept.size(), 1u) << "the old values survive a crash";
    EXPECT_EQ(json::parse(net.kept.begin()->second).at("parameters").size(), 15u);
    EXPECT_EQ(net.kept.begin()->first, "calibration-0xDC-accelerometer.json");
    net.pass(1min);
    EXPECT_EQ(state(), "waiting");
    const auto next = net.ask("POST", "/jobs/1/next");
    EXPECT_EQ(next.status, 200u);
    EXPECT_EQ(next.json.at("state"), "running");
    EXPECT_EQ(next.json.at("message"), "the device is told to forget them");
    EXPECT_EQ(net.ask("POST", "/jobs/1/next").status, 409u) << "it goes on already";
    net.pass(1s);
    lie(0);
    const json step = net.ask("GET", "/jobs/1").json.at("step");
    EXPECT_EQ(step.at("face"), "+x");
    EXPECT_EQ(step.at("done"), json::array({"+x"}));
    EXPECT_EQ(step.at("still"), 1.0);
    for (std::size_t face = 1; face < 6; ++face) lie(face);
    const json over = until_over(1);
    EXPECT_EQ(over.at("state"), "done") << over;
    EXPECT_LT(over.at("result").at("after").get<double>(), over.at("result").at("before").get<double>());
    EXPECT_EQ(over.at("result").at("values").size(), 15u);
    EXPECT_NE(fake.parameters[0].value, before);
    EXPECT_TRUE(net.kept.empty());
}

TEST_F(Calibrates, and_puts_the_old_values_back_when_it_is_cancelled) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    net.ask("POST", "/jobs/1/next");
    net.pass(1s);
    fake.parameters[0].value = Bytes(4);    // it has forgotten
    const json over = net.ask("DELETE", "/jobs/1").json;
    EXPECT_EQ(over.at("state"), "cancelled");
    EXPECT_EQ(over.at("error"), "cancelled; the old values are back");
    EXPECT_EQ(fake.parameters[0].value, before);
    EXPECT_TRUE(net.kept.empty());
}

TEST_F(Calibrates, nothing_when_the_old_values_can_not_be_kept) {
    net.keep_fault = "the disk is full";
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    const json over = until_over(1);
    EXPECT_EQ(over.at("status"), 503);
    EXPECT_NE(over.at("error").get<std::string>().find("the disk is full"), std::string::npos);
    EXPECT_EQ(fake.parameters[0].value, before);
}

TEST_F(Calibrates, nothing_when_nobody_says_go_on) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    const json over = until_over(1);
    EXPECT_EQ(over.at("error"), "nobody said go on within 10 minutes; nothing was changed");
    EXPECT_EQ(over.at("status"), 504);
    EXPECT_TRUE(net.kept.empty());
}

TEST_F(Calibrates, and_does_not_write_to_who_took_off_meanwhile) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    net.ask("POST", "/jobs/1/next");
    net.pass(1s);
    for (std::size_t face = 0; face < 5; ++face) lie(face);
    net.passes(frame(0xDC, 0xFF, 0x06, {1, 2, 0, 0, 0}));
    lie(5);
    const json over = until_over(1);
    EXPECT_EQ(over.at("error"),
              "the new values were not written: 0xDC is unlocked or flies: this is for the ground; the old values are back");
    EXPECT_EQ(fake.parameters[0].value, before);
}

struct CutOff : Calibrates {
    // The gateway ended while the device was turned; it has half of other values since.
    explicit CutOff(const Bytes& first_value = {}) {
        if (!first_value.empty()) before = fake.parameters[0].value = first_value;
        net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
        net.until([&] { return state() == "waiting"; });
        net.ask("POST", "/jobs/1/next");
        net.pass(1s);
        auto lines = net.lines("GET", "/jobs/1");
        net.service.stop(net.time);
        std::string text;
        lines->next(text);
        last = json::parse(text);
        again.add() = fake;
        again.fakes[0]->parameters[0].value = Bytes(4);
        again.kept = net.kept;
    }
    void start() {
        for (const auto& [name, text] : net.kept) EXPECT_TRUE(again.service.remember(name, text));
    }
    const Bytes& value() const { return again.fakes[0]->parameters[0].value; }

    json last;
    SimulatedNet again;
};

TEST_F(CutOff, its_last_line_says_where_the_old_values_are) {
    EXPECT_EQ(last.at("state"), "cancelled");
    EXPECT_EQ(last.at("error"),
              "the gateway ends: the old values are kept as calibration-0xDC-accelerometer.json and are written back "
              "at the next start");
    EXPECT_EQ(net.kept.size(), 1u);
}

TEST_F(CutOff, the_old_values_are_written_back_by_the_next_run) {
    start();
    EXPECT_EQ(again.ask("GET", "/devices").json.at("devices")[0].at("kept"),
              json::array({"calibration-0xDC-accelerometer.json"}));
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 1min));
    EXPECT_EQ(value(), before);
    again.pass(5s);
    const json jobs = again.ask("GET", "/jobs").json.at("jobs");
    ASSERT_EQ(jobs.size(), 1u);
    EXPECT_EQ(jobs[0].at("state"), "done");
    EXPECT_EQ(jobs[0].at("client"), "the gateway");
    EXPECT_FALSE(again.ask("GET", "/devices").json.at("devices")[0].contains("kept"));
    again.pass(3min);
    EXPECT_FALSE(again.listens) << "nothing is left to do";
}

struct CutOffWithoutNumbers : CutOff {
    CutOffWithoutNumbers() : CutOff{{0x01, 0x00, 0x80, 0x7F}} {}    // a signalling NaN
};

TEST_F(CutOffWithoutNumbers, they_are_written_back_bit_by_bit) {
    start();
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 1min));
    EXPECT_EQ(value(), before);
}

TEST_F(CutOffWithoutNumbers, a_note_without_their_bytes_is_read_as_well) {
    json note = json::parse(net.kept.begin()->second);
    EXPECT_EQ(note.erase("bytes"), 1u);
    EXPECT_EQ(note.at("parameters").at("CAL_AOFF_X"), "nan");
    note["parameters"]["CAL_AOFF_Y"] = "-inf";
    note["parameters"]["CAL_AOFF_Z"] = 0.1f;
    again.kept.begin()->second = note.dump();
    EXPECT_TRUE(again.service.remember(again.kept.begin()->first, note.dump()));
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 1min));
    const auto stored = [&](std::size_t i) { return ano::load<float>(again.fakes[0]->parameters[i].value.data()); };
    EXPECT_TRUE(std::isnan(stored(0)));
    EXPECT_EQ(stored(1), -std::numeric_limits<float>::infinity());
    EXPECT_EQ(stored(2), 0.1f);
}

TEST_F(CutOff, not_in_the_air_and_not_to_another_device) {
    start();
    again.fakes[0]->name = "another";
    again.pass(150s);
    EXPECT_EQ(value(), Bytes(4));
    EXPECT_EQ(again.kept.size(), 1u);
    again.fakes[0]->name = fake.name;
    again.passes(frame(0xDC, 0xFF, 0x06, {1, 2, 0, 0, 0}));
    again.pass(150s);
    EXPECT_EQ(again.kept.size(), 1u);
    again.passes(frame(0xDC, 0xFF, 0x06, {1, 0, 0, 0, 0}));
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 10min)) << "as soon as it may";
    EXPECT_EQ(value(), before);
}

TEST_F(CutOff, notes_that_can_not_be_used_are_tried_once_a_minute) {
    again.fakes[0]->name = "another";
    start();
    again.pass(150s);
    const std::size_t tries = again.ask("GET", "/jobs").json.at("jobs").size();
    EXPECT_GE(tries, 2u);
    EXPECT_LE(tries, 3u);
    EXPECT_EQ(value(), Bytes(4));
}

TEST_F(CutOff, a_damaged_note_begins_no_job_and_keeps_nobody_out) {
    const json whole = json::parse(net.kept.begin()->second);
    json of_nobody = whole, without_one = whole, too_large = whole;
    of_nobody.erase("device");
    without_one["bytes"].erase("CAL_AOFF_X");
    too_large.erase("bytes");
    too_large["parameters"]["CAL_AOFF_X"] = 1e300;
    for (const std::string& text : {std::string{}, std::string{"[]"}, std::string{R"({"values": 5})"},
                                    std::string{"{\"parameters\": []}"}, of_nobody.dump(), without_one.dump(), too_large.dump()})
        EXPECT_FALSE(again.service.remember("calibration-0xDC-accelerometer.json", text)) << text;
    again.pass(150s);
    EXPECT_TRUE(again.ask("GET", "/jobs").json.at("jobs").empty());
    EXPECT_FALSE(again.ask("GET", "/devices").json.at("devices")[0].contains("kept"));
    EXPECT_EQ(again.ask("PUT", "/devices/0xDC/parameters/CAL_AOFF_Y", R"({"value": 1})").status, 200u);
    EXPECT_TRUE(again.service.remember("calibration-0xDC-accelerometer.json", whole.dump()));
    EXPECT_TRUE(again.service.remember("firmware-0xDC.json", "{}")) << "it says who is in its loader by its name alone";
}

TEST_F(CutOff, a_calibration_before_that_puts_back_what_was_before_the_first) {
    EXPECT_TRUE(again.service.remember("calibration-0xDC-accelerometer.json", net.kept.begin()->second));
    const auto answer = again.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_EQ(answer.status, 202u) << answer.json;
    const std::string job = "/jobs/" + std::to_string(answer.json.at("id").get<int>());
    ASSERT_TRUE(again.until([&] { return again.ask("GET", job).json.at("state") == "waiting"; }, 1min));
    EXPECT_EQ(again.kept, net.kept) << "what the first left in the device is not kept over it";
    again.ask("POST", job + "/next");
    again.pass(1s);
    EXPECT_EQ(again.ask("DELETE", job).json.at("error"), "cancelled; the old values are back");
    EXPECT_EQ(value(), before);
    EXPECT_TRUE(again.kept.empty());
}

TEST_F(CutOff, to_import_them_is_as_good) {
    start();
    again.pass(10ms);
    again.passes(frame(0xDC, 0xFF, 0x06, {1, 2, 0, 0, 0}));
    again.pass(3s);
    json values = json::parse(net.kept.begin()->second).at("parameters");
    values.erase("CAL_AEM3_Z");
    EXPECT_EQ(again.ask("POST", "/devices/0xDC/apply", values.dump()).status, 200u);
    EXPECT_EQ(again.kept.size(), 1u) << "one of them is not written";
    values = json::parse(net.kept.begin()->second).at("parameters");
    EXPECT_EQ(again.ask("POST", "/devices/0xDC/apply", values.dump()).status, 200u);
    EXPECT_EQ(value(), before);
    EXPECT_TRUE(again.kept.empty());
}

TEST_F(CutOff, a_damaged_file_is_in_nobodys_way) {
    again.kept.begin()->second = "{}";
    EXPECT_FALSE(again.service.remember("calibration-0xDC-accelerometer.json", "{\"parameters\": []}"));
    again.pass(150s);
    EXPECT_EQ(value(), Bytes(4));
    const auto answer = again.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_EQ(answer.status, 202u) << answer.json;
    const std::string job = "/jobs/" + std::to_string(answer.json.at("id").get<int>());
    ASSERT_TRUE(again.until([&] { return again.ask("GET", job).json.at("state") == "waiting"; }, 1min));
    EXPECT_TRUE(json::parse(again.kept.begin()->second).at("parameters").is_object()) << "it has those of now";
}

TEST_F(Calibrates, nothing_when_it_took_off_while_it_waited) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    net.passes(frame(0xDC, 0xFF, 0x06, {1, 2, 0, 0, 0}));
    const auto [status, error] = net.ask("POST", "/jobs/1/next");
    EXPECT_EQ(status, 409u);
    EXPECT_EQ(error.at("error"), "0xDC is unlocked or flies: this is for the ground");
    EXPECT_EQ(state(), "waiting");
    EXPECT_EQ(fake.parameters[0].value, before);
    net.passes(frame(0xDC, 0xFF, 0x06, {1, 0, 0, 0, 0}));
    EXPECT_EQ(net.ask("POST", "/jobs/1/next").status, 200u);
}

TEST(Notes, are_files_of_exactly_their_names) {
    for (const char* name : {"calibration-0xDC-accelerometer.json", "calibration-0x01-compass.json", "firmware-0xDC.json"})
        EXPECT_TRUE(anogate::is_note(name)) << name;
    for (const char* name : {"calibration-0xDC\n2026 all is well-accelerometer.json", "calibration-0xDC-\x1B[2J-compass.json",
                             "calibration-0xdc-compass.json", "calibration-0xDC-gyroscope.json", "firmware-0xDC-old.json",
                             "firmware-0x\n.json", "firmware-0xDC.json.tmp", "firmware-0xDC", ""})
        EXPECT_FALSE(anogate::is_note(name)) << name;
}

TEST_F(Calibrates, only_what_there_is_to_calibrate) {
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/calibration", R"({"what": "barometer"})").status, 400u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/calibration", "{}").status, 400u);
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "compass"})");
    EXPECT_EQ(until_over(1).at("what"), "unsupported");
}

}    // namespace
}    // namespace long_jobs_tests
