// An upgrade and a calibration: jobs that are answered at once, have steps, and can be cancelled and continued.
#include <ano/hex.hpp>
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
    const std::string file(10'000, '\x01');
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
    EXPECT_EQ(loader.flash, Bytes(10'000, 0x01));
}

TEST_F(LongJobs, a_refused_upgrade_fails_with_its_cause) {
    load();
    loader.refuses = true;
    net.ask("POST", "/devices/0xDC/firmware", std::string(1000, '\x01'));
    json over = until_over(1);
    EXPECT_EQ(over.at("state"), "failed");
    EXPECT_EQ(over.at("status"), 502);
    net.ask("POST", "/devices/0xDC/firmware", "");
    over = until_over(2);
    EXPECT_EQ(over.at("status"), 422) << over;
    EXPECT_EQ(loader.erases, 0u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/firmware?crc=crc99", "\x01").status, 400u);
}

TEST_F(LongJobs, an_upgrade_continues_after_a_lost_connection_and_reports_the_wait) {
    for (const bool loses_power : {false, true}) {
        loader = {};
        bool is_cut = false;
        fake.instead = [&](ano::FrameView f) { return is_cut ? std::vector<Bytes>{} : loader.take(fake, f); };
        const int id = net.ask("POST", "/devices/0xDC/firmware", std::string(10'000, '\x01')).json.at("id");
        ASSERT_TRUE(net.until([&] { return loader.frames > 10; }));
        is_cut = true;
        if (loses_power) loader.lose_power();
        net.pass(50s);
        const std::string meanwhile = net.ask("GET", "/jobs/" + std::to_string(id)).json.at("message");
        EXPECT_EQ(meanwhile.substr(0, 22), "sending, no answer for") << meanwhile;
        is_cut = false;
        const json over = until_over(id);
        EXPECT_EQ(over.at("state"), "done") << over;
        EXPECT_EQ(loader.erases, loses_power ? 2u : 1u);
        EXPECT_EQ(over.at("result").contains("note"), loses_power) << over;
        EXPECT_EQ(loader.flash, Bytes(10'000, 0x01));
    }
}

TEST_F(LongJobs, a_cancelled_upgrade_reports_that_the_device_is_left_in_its_boot_loader) {
    load();
    net.ask("POST", "/devices/0xDC/firmware", std::string(100'000, '\x01'));
    ASSERT_TRUE(net.until([&] { return loader.frames > 10; }));
    const json over = net.ask("DELETE", "/jobs/1").json;
    EXPECT_EQ(over.at("state"), "cancelled");
    EXPECT_NE(over.at("error").get<std::string>().find("loader"), std::string::npos) << over;
}

TEST_F(LongJobs, a_device_left_in_its_boot_loader_is_still_known_after_a_restart) {
    load();
    net.ask("GET", "/devices/0xDC/parameters");
    net.ask("POST", "/devices/0xDC/firmware", std::string(100'000, '\x01'));
    ASSERT_TRUE(net.until([&] { return loader.frames > 10; }));
    ASSERT_EQ(net.kept.size(), 1u);
    const auto [name, note] = *net.kept.begin();
    EXPECT_TRUE(anogate::is_note(name)) << name;
    EXPECT_TRUE(name.starts_with("firmware-0xDC-")) << name;
    auto lines = net.lines("GET", "/jobs/2");
    net.service.stop(net.time);
    std::string text;
    lines->next(text);
    EXPECT_EQ(json::parse(text).at("state"), "cancelled");
    EXPECT_EQ(json::parse(text).at("error"), "the gateway is stopping: cancelled; it is left in its boot loader; start again");

    SimulatedNet again;
    again.add();
    again.kept = net.kept;
    EXPECT_TRUE(again.service.remember(name, note));
    EXPECT_EQ(again.ask("GET", "/devices").json.at("devices")[0].at("in_loader"), true);
    FakeLoader other;
    again.fakes[0]->instead = [&](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0) return std::vector<Bytes>{};    // a loader does not report its identity
        return other.take(*again.fakes[0], f);
    };
    Bytes file(300);    // a .bia for the earlier identity
    file[0] = 'b', file[1] = 'i', file[2] = 'a';
    const Bytes image(file.begin() + 100, file.end());
    ano::store(&file[12], ano::crc16_of(image));
    const json known = json::parse(note).at("device");
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

TEST_F(LongJobs, a_job_beyond_the_limit_is_rejected_with_a_retry_time) {
    net.add(0xDD);
    net.add(0xDE);
    const auto ask = [&](const std::string& device) {
        return net.routes.answer(SimulatedNet::request("POST", "/devices/" + device + "/firmware", "\x01"));
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
        for (const std::string& name : ano::host::calibration_names(ano::host::Sensor::compass)) {
            fake.parameters.push_back({8, name, "", Bytes(4)});
            ano::store(fake.parameters.back().value.data(), static_cast<float>(value += 0.125));
        }
        before = fake.parameters[0].value;
        fake.instead = [this](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
            const bool clears = f.id() == 0xE0 && f.data()[0] == 0x10 && f.data()[1] == 0x20;
            const auto neutral = ano::host::neutral_calibration(ano::host::Sensor::accelerometer);
            for (std::size_t i = 0; clears && i < neutral.size(); ++i)
                ano::store(fake.parameters[i].value.data(), static_cast<float>(std::get<double>(neutral[i].second)));
            return std::nullopt;
        };
    }
    std::string state() { return net.ask("GET", "/jobs/1").json.at("state").get<std::string>(); }
    std::string message() { return net.ask("GET", "/jobs/1").json.at("message").get<std::string>(); }
    // `corrected`: as measured with the values that the calibration finds.
    void lie(std::size_t face, bool corrected = false) {
        ano::Draft<"inertial"> m;
        std::array<int, 3> acc{corrected ? 0 : 20, 0, 0};
        acc[face / 2] += (face % 2 == 0 ? 1 : -1) * (corrected ? 981 : 1000);
        for (int i = 0; i < 100; ++i) {
            (void)m.set<"acc_x">(acc[0] + i % 3);
            (void)m.set<"acc_y">(acc[1] - i % 3);
            (void)m.set<"acc_z">(acc[2] + i % 2);
            std::array<std::uint8_t, 64> bytes{};
            const std::size_t size = m.encode(bytes, 0xDC, 0xFF);
            net.pass(20ms);
            net.passes(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)));
        }
    }

    // Samples on no face, for the time in which samples from before a clear or a store can arrive.
    void fall() {
        const Bytes sample = frame(0xDC, 0xFF, 0x01, Bytes(13));
        for (const auto end = net.time + ano::host::Calibration::most_late; net.time < end;) {
            net.pass(100ms);
            net.passes(sample);
        }
    }
    void go_on() {
        net.ask("POST", "/jobs/1/next");
        fall();
    }

    Bytes before, cleared = Bytes(4);    // of the first parameter
};

TEST_F(Calibrates, after_it_is_continued_and_the_device_lay_on_every_face) {
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})").status, 202u);
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    EXPECT_EQ(net.kept.size(), 1u) << "the old values survive a crash";
    EXPECT_EQ(json::parse(net.kept.begin()->second).at("parameters").size(), 15u);
    EXPECT_TRUE(anogate::is_note(net.kept.begin()->first)) << net.kept.begin()->first;
    net.pass(1min);
    EXPECT_EQ(state(), "waiting");
    const auto next = net.ask("POST", "/jobs/1/next");
    EXPECT_EQ(next.status, 200u);
    EXPECT_EQ(next.json.at("state"), "running");
    EXPECT_EQ(next.json.at("message"), "clearing the calibration of the device");
    EXPECT_EQ(net.ask("POST", "/jobs/1/next").status, 409u) << "it goes on already";
    fall();
    lie(0);
    const json step = net.ask("GET", "/jobs/1").json.at("step");
    EXPECT_EQ(step.at("face"), "+x");
    EXPECT_EQ(step.at("done"), json::array({"+x"}));
    EXPECT_EQ(step.at("still"), 1.0);
    for (std::size_t face = 1; face < 6; ++face) lie(face);
    ASSERT_TRUE(net.until([&] { return message() == "checking the new values: keep it still on -z"; }));
    fall();
    lie(5, true);
    const json over = until_over(1);
    EXPECT_EQ(over.at("state"), "done") << over;
    EXPECT_LT(over.at("result").at("after").get<double>(), over.at("result").at("before").get<double>());
    EXPECT_EQ(over.at("result").at("values").size(), 15u);
    EXPECT_NE(fake.parameters[0].value, before);
    EXPECT_TRUE(net.kept.empty());
}

TEST_F(Calibrates, and_restores_the_old_values_when_cancelled) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    go_on();
    EXPECT_EQ(fake.parameters[0].value, cleared) << "it has forgotten";
    const json over = net.ask("DELETE", "/jobs/1").json;
    EXPECT_EQ(over.at("state"), "cancelled");
    EXPECT_EQ(over.at("error"), "cancelled; the old values are restored");
    EXPECT_EQ(fake.parameters[0].value, before);
    EXPECT_TRUE(net.kept.empty());
}

TEST_F(Calibrates, again_from_the_beginning_when_the_device_restarts) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    go_on();
    for (std::size_t face = 0; face < 3; ++face) lie(face);
    net.pass(600ms);
    lie(3);
    fall();
    EXPECT_EQ(message(),
              "the device restarted (no samples for 0.6 s), so all samples are discarded: lay it on each of its six faces");
    EXPECT_EQ(net.ask("GET", "/jobs/1").json.at("step").at("done"), json::array());
    for (std::size_t face = 0; face < 6; ++face) lie(face);
    ASSERT_TRUE(net.until([&] { return message().starts_with("checking the new values"); }));
    fall();
    lie(5, true);
    const json over = until_over(1);
    EXPECT_EQ(over.at("state"), "done") << over;
    EXPECT_EQ(over.at("result").at("restarts"), 1);
    EXPECT_LT(over.at("result").at("verified").get<double>(), 10);
}

TEST_F(Calibrates, and_is_not_disturbed_by_scans_and_requests_of_other_hosts) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    go_on();
    for (int i = 0; i < 25; ++i) lie(0);    // longer than an answer to the last question may take
    const auto all = net.asked("POST", "/devices/scan");
    for (int i = 0; i < 35; ++i) lie(0);
    EXPECT_TRUE(all->has_value());
    EXPECT_EQ(net.ask("GET", "/jobs/1").json.at("step").at("done"), json::array({"+x"}));
    net.passes(frame(0xD2, 0xDC, 0xE0, {0, 0, 0}));    // another host asks it
    net.passes(fake.take(ano::FrameView{frame(0xFE, 0xDC, 0xE0, {0, 0, 0})}).at(0));
    EXPECT_NE(message().find("lay it on"), std::string::npos);
    EXPECT_EQ(message().find("restarted"), std::string::npos) << message();
}

TEST_F(Calibrates, and_fails_within_five_seconds_when_the_device_is_lost_and_restores_its_values_later) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    go_on();
    lie(0);
    fake.deaf = true;
    const auto died = net.time;
    const json over = until_over(1);
    EXPECT_LE(net.time - died, 5s);
    EXPECT_EQ(
        over.at("error"),
        "0xDC stopped sending: nothing was received for 4.5 s; the old values could not be written back; they are saved as " +
            net.kept.begin()->first + " and are written back when it is heard on the ground");
    net.where[0xDC] = {};
    net.pass(10min);
    EXPECT_EQ(net.kept.size(), 1u);
    fake.deaf = false;
    EXPECT_EQ(fake.parameters[0].value, cleared);
    net.where[0xDC] = {.is_known = true};
    EXPECT_TRUE(net.until([&] { return net.kept.empty(); }, 1min));
    EXPECT_EQ(fake.parameters[0].value, before);
}

TEST_F(Calibrates, nothing_when_the_old_values_cannot_be_stored) {
    net.keep_fault = "the disk is full";
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    const json over = until_over(1);
    EXPECT_EQ(over.at("status"), 503);
    EXPECT_NE(over.at("error").get<std::string>().find("the disk is full"), std::string::npos);
    EXPECT_EQ(fake.parameters[0].value, before);
}

TEST_F(Calibrates, nothing_when_not_continued_within_10_minutes) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    const json over = until_over(1);
    EXPECT_EQ(over.at("error"), "not continued within 10 minutes; nothing was changed");
    EXPECT_EQ(over.at("status"), 504);
    EXPECT_TRUE(net.kept.empty());
}

TEST_F(Calibrates, without_writing_to_a_device_that_took_off_meanwhile) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    go_on();
    for (std::size_t face = 0; face < 5; ++face) lie(face);
    net.passes(frame(0xDC, 0xFF, 0x06, {1, 2, 0, 0, 0}));
    lie(5);
    const json over = until_over(1);
    EXPECT_EQ(over.at("error"),
              "the new values were not written: 0xDC is unlocked or flying: this is only allowed on the ground; the old values "
              "are restored");
    EXPECT_EQ(fake.parameters[0].value, before);
}

struct CutOff : Calibrates {
    // The gateway ended while the device was turned; the device has lost the first value.
    explicit CutOff(const Bytes& first_value = {}) {
        if (!first_value.empty()) before = fake.parameters[0].value = first_value;
        net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
        net.until([&] { return state() == "waiting"; });
        go_on();
        auto lines = net.lines("GET", "/jobs/1");
        net.service.stop(net.time);
        std::string text;
        lines->next(text);
        last = json::parse(text);
        again.add() = fake;
        again.fakes[0]->instead = nullptr;
        again.kept = net.kept;
    }
    void start() {
        for (const auto& [name, text] : net.kept) EXPECT_TRUE(again.service.remember(name, text));
    }
    const Bytes& value() const { return again.fakes[0]->parameters[0].value; }

    json last;
    SimulatedNet again;
};

TEST_F(CutOff, its_last_line_names_the_file_with_the_old_values) {
    EXPECT_EQ(last.at("state"), "cancelled");
    EXPECT_EQ(last.at("error"), "the gateway is stopping: the old values are saved as " + net.kept.begin()->first +
                                    " and are written back at the next start");
    EXPECT_EQ(net.kept.size(), 1u);
}

TEST_F(CutOff, the_old_values_are_written_back_by_the_next_run) {
    start();
    EXPECT_EQ(again.ask("GET", "/devices").json.at("devices")[0].at("kept"), json::array({net.kept.begin()->first}));
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 1min));
    EXPECT_EQ(value(), before);
    again.pass(5s);
    const json jobs = again.ask("GET", "/jobs").json.at("jobs");
    ASSERT_EQ(jobs.size(), 1u);
    EXPECT_EQ(jobs[0].at("state"), "done");
    EXPECT_EQ(jobs[0].at("client"), "the gateway");
    EXPECT_EQ(again.reports, std::vector<std::string>{
                                 "restored the old calibration values, because the calibration was not finished: accelerometer "
                                 "of fake (0xDC), link 'fc', saved 2026-11-26 12:00:00 UTC; read back and equal, so " +
                                 net.kept.begin()->first + " is removed"});
    EXPECT_FALSE(again.ask("GET", "/devices").json.at("devices")[0].contains("kept"));
    again.pass(3min);
    EXPECT_FALSE(again.listens) << "nothing is left to do";
}

struct CutOffWithoutNumbers : CutOff {
    CutOffWithoutNumbers() : CutOff{{0x01, 0x00, 0x80, 0x7F}} {}    // a signalling NaN
};

TEST_F(CutOffWithoutNumbers, values_are_restored_bit_for_bit) {
    start();
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 1min));
    EXPECT_EQ(value(), before);
}

TEST_F(CutOffWithoutNumbers, a_note_without_the_bytes_of_the_values_is_also_read) {
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

TEST_F(CutOff, the_old_values_are_not_written_to_a_flying_or_different_device) {
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

// If anything differs, the values may belong to another unit, and the note is their only copy.
TEST_F(CutOff, the_old_values_are_written_to_no_other_unit_with_this_address) {
    const std::string name = net.kept.begin()->first;
    const auto left_alone = [&](const std::string& why) {
        again.kept = net.kept;
        again.reports.clear();
        start();
        again.pass(150s);
        EXPECT_EQ(value(), Bytes(4)) << why;
        EXPECT_EQ(again.kept, net.kept) << why;
        ASSERT_EQ(again.reports.size(), 1u) << why;
        EXPECT_NE(again.reports[0].find(why), std::string::npos) << again.reports[0];
        EXPECT_NE(again.reports[0].find(name), std::string::npos) << again.reports[0];
    };
    again.unit.gateway = "/run/other.sock";
    left_alone("is not used: it is of the gateway /run/test.sock");
    again.unit = net.unit;
    again.unit.link = "radio";
    left_alone("is not used: it is of the link 'fc'");
    again.unit = net.unit;
    again.unit.wire = "serial:/dev/other";
    left_alone("is not used: it is of the link 'fc' (serial:/dev/fake)");
    again.unit = net.unit;
    again.fakes[0]->version = 101;
    left_alone("is not used: it is of another device, fake (dev_id ");
    again.fakes[0]->version = fake.version;
    again.pass(2min);
    EXPECT_EQ(value(), before) << "it is the one again";
    EXPECT_TRUE(again.kept.empty());
}

TEST_F(CutOff, a_calibration_of_another_unit_with_this_address_restores_the_values_of_that_unit) {
    again.unit.link = "radio";
    start();
    const auto answer = again.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_EQ(answer.status, 202u) << answer.json;
    const std::string job = "/jobs/" + std::to_string(answer.json.at("id").get<int>());
    ASSERT_TRUE(again.until([&] { return again.ask("GET", job).json.at("state") == "waiting"; }, 1min));
    EXPECT_EQ(again.kept.size(), 2u) << "one for each unit";
    EXPECT_EQ(again.kept.at(net.kept.begin()->first), net.kept.begin()->second);
    again.ask("POST", job + "/next");
    again.pass(1s);
    EXPECT_EQ(again.ask("DELETE", job).json.at("error"), "cancelled; the old values are restored");
    EXPECT_EQ(value(), Bytes(4)) << "its own ones";
    EXPECT_EQ(again.kept, net.kept) << "the other's stays";
}

TEST_F(CutOff, a_note_that_does_not_name_its_gateway_is_not_used) {
    json note = json::parse(net.kept.begin()->second);
    note.erase("gateway");
    again.kept = {{"calibration-0xDC-accelerometer.json", note.dump()}};
    EXPECT_TRUE(again.service.remember("calibration-0xDC-accelerometer.json", note.dump()));
    again.pass(150s);
    EXPECT_EQ(value(), Bytes(4));
    EXPECT_EQ(again.kept.size(), 1u);
    EXPECT_EQ(again.reports.at(0),
              "calibration-0xDC-accelerometer.json is not used: it is of an older version without the gateway and link");
}

TEST_F(CutOff, the_note_stays_until_the_device_returns_the_values_as_written) {
    start();
    again.fakes[0]->parameters[0].store = [](Bytes) { return Bytes(4); };    // it stores nothing
    again.pass(70s);
    EXPECT_EQ(again.kept.size(), 1u);
    ASSERT_EQ(again.reports.size(), 1u) << "once, though tried again";
    EXPECT_NE(again.reports[0].find(" is not written back: "), std::string::npos) << again.reports[0];
    again.fakes[0]->parameters[0].store = nullptr;
    again.pass(2min);
    EXPECT_TRUE(again.kept.empty());
}

TEST_F(CutOff, notes_that_cannot_be_used_are_retried_once_a_minute) {
    again.fakes[0]->name = "another";
    start();
    again.pass(150s);
    const std::size_t tries = again.ask("GET", "/jobs").json.at("jobs").size();
    EXPECT_GE(tries, 2u);
    EXPECT_LE(tries, 3u);
    EXPECT_EQ(value(), Bytes(4));
}

TEST_F(CutOff, a_damaged_note_starts_no_job_and_blocks_no_writes) {
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
}

TEST_F(CutOff, a_new_calibration_before_the_restore_restores_the_values_from_before_the_first) {
    EXPECT_TRUE(again.service.remember(net.kept.begin()->first, net.kept.begin()->second));
    const auto answer = again.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_EQ(answer.status, 202u) << answer.json;
    const std::string job = "/jobs/" + std::to_string(answer.json.at("id").get<int>());
    ASSERT_TRUE(again.until([&] { return again.ask("GET", job).json.at("state") == "waiting"; }, 1min));
    EXPECT_EQ(again.kept, net.kept) << "what the first left in the device is not kept over it";
    again.ask("POST", job + "/next");
    again.pass(1s);
    EXPECT_EQ(again.ask("DELETE", job).json.at("error"), "cancelled; the old values are restored");
    EXPECT_EQ(value(), before);
    EXPECT_TRUE(again.kept.empty());
}

// It was calibrated by another program meanwhile, or is a spare unit of the same type.
TEST_F(CutOff, a_device_whose_values_have_changed_since_keeps_them) {
    const std::string name = net.kept.begin()->first;
    start();
    auto& parameters = again.fakes[0]->parameters;
    const Bytes own{0, 0, 0x80, 0x41};    // 16
    parameters[2].value = own;
    const std::size_t sent_before = again.sent.size();
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 1min));
    EXPECT_EQ(parameters[0].value, cleared);
    EXPECT_EQ(parameters[2].value, own);
    const auto writes = [](const Bytes& sent) { return sent[3] == 0xE1; };
    EXPECT_TRUE(std::none_of(again.sent.begin() + static_cast<std::ptrdiff_t>(sent_before), again.sent.end(), writes));
    again.pass(5s);
    ASSERT_EQ(again.reports.size(), 1u);
    EXPECT_EQ(again.reports[0].find(name + " is not written back: the calibration values of the device are not those of the "
                                           "unfinished calibration, so they stay, and the file is removed: accelerometer of fake "
                                           "(0xDC), link 'fc', saved 2026-11-26 12:00:00 UTC, {\"CAL_AOFF_X\":0.625,"),
              0u)
        << again.reports[0];
    const json device = again.ask("GET", "/devices").json.at("devices")[0];
    EXPECT_FALSE(device.contains("kept")) << device;
    EXPECT_EQ(device.at("dropped"), json::array({name + " (removed: the device has other calibration values)"}));
    again.pass(3min);
    EXPECT_EQ(again.ask("GET", "/jobs").json.at("jobs").size(), 1u);
}

TEST_F(CutOff, a_calibration_of_a_device_whose_values_have_changed_since_keeps_the_changed_ones) {
    EXPECT_TRUE(again.service.remember(net.kept.begin()->first, net.kept.begin()->second));
    const Bytes own{0, 0, 0x80, 0x41};
    again.fakes[0]->parameters[2].value = own;
    const auto answer = again.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_EQ(answer.status, 202u) << answer.json;
    const std::string job = "/jobs/" + std::to_string(answer.json.at("id").get<int>());
    ASSERT_TRUE(again.until([&] { return again.ask("GET", job).json.at("state") == "waiting"; }, 1min));
    ASSERT_EQ(again.kept.size(), 1u);
    EXPECT_EQ(json::parse(again.kept.begin()->second).at("parameters").at("CAL_AOFF_Z"), 16);
    EXPECT_EQ(again.reports.size(), 1u);
    EXPECT_FALSE(again.ask("GET", "/devices").json.at("devices")[0].contains("dropped"));
    again.ask("POST", job + "/next");
    again.pass(1s);
    EXPECT_EQ(again.ask("DELETE", job).json.at("error"), "cancelled; the old values are restored");
    EXPECT_EQ(again.fakes[0]->parameters[2].value, own);
    EXPECT_EQ(value(), cleared);
}

// Interrupted while the new values were written: the device has some of them.
TEST_F(Calibrates, and_restores_the_old_values_of_a_device_that_was_lost_while_new_ones_were_written) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    std::vector<Bytes> old;
    for (const auto& parameter : fake.parameters) old.push_back(parameter.value);
    go_on();
    fake.parameters[3].store = [&](Bytes value) {
        fake.deaf = true;
        return value;
    };
    for (std::size_t face = 0; face < 6; ++face) lie(face);
    EXPECT_EQ(until_over(1).at("state"), "failed");
    EXPECT_NE(fake.parameters[1].value, old[1]);
    EXPECT_NE(fake.parameters[3].value, old[3]);
    EXPECT_EQ(ano::load<float>(fake.parameters[4].value.data()), 1) << "it is cleared";
    const json note = json::parse(net.kept.begin()->second);
    EXPECT_EQ(note.at("cleared").size(), 15u);
    EXPECT_EQ(note.at("new").size(), 15u);
    fake.parameters[3].store = nullptr;
    fake.deaf = false;
    EXPECT_TRUE(net.until([&] { return net.kept.empty(); }, 3min));
    for (std::size_t i = 0; i < old.size(); ++i) EXPECT_EQ(fake.parameters[i].value, old[i]) << i;
}

struct CutOffOfTwoSensors : CutOff {
    static void store(FakeDevice& device, std::size_t which, float value) {
        ano::store(device.parameters[which].value.data(), value);
    }
    // The values of a unit that was never calibrated.
    static void make_neutral(FakeDevice& device, std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i)
            store(device, i, (i >= 3 && i < 6) || i == 6 || i == 10 || i == 14 || i >= 18 ? 1.0f : 0.0f);
    }
    // Adds the note of a calibration that ended directly after the clear, for a device with this compass calibration.
    void remember(float offset_of_compass, bool has_cleared = false) {
        json note = json::parse(net.kept.begin()->second);
        if (!has_cleared) note.erase("cleared");
        note["other"] = json::object();
        const auto names = ano::host::calibration_names(ano::host::Sensor::compass);
        FakeDevice& device = *again.fakes[0];
        device.parameters.resize(15);
        for (const std::string& name : names) device.parameters.push_back({8, name, "", Bytes(4)});
        make_neutral(device, 15, 21);
        store(device, 15, offset_of_compass);
        for (std::size_t i = 0; i < names.size(); ++i) note["other"][names[i]] = ano::hex(device.parameters[15 + i].value);
        const std::string name = net.kept.begin()->first;
        again.kept = {{name, note.dump()}};
        EXPECT_TRUE(again.service.remember(name, note.dump()));
    }
};

TEST_F(CutOffOfTwoSensors, are_written_to_a_device_that_looks_cleared_and_has_the_other_calibration) {
    remember(12.5f);
    make_neutral(*again.fakes[0], 0, 15);
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 3min));
    EXPECT_EQ(value(), before);
}

TEST_F(CutOffOfTwoSensors, are_not_written_to_a_spare_unit_that_was_never_calibrated) {
    remember(12.5f);
    make_neutral(*again.fakes[0], 0, 21);
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 3min));
    EXPECT_EQ(value(), Bytes(4));
    EXPECT_NE(again.reports.at(0).find("so they stay, and the file is removed"), std::string::npos);
}

// The device can't be distinguished from a spare unit.
TEST_F(CutOffOfTwoSensors, are_not_written_where_the_other_sensor_was_never_calibrated) {
    for (const bool has_cleared : {false, true}) {
        again.reports.clear();
        remember(0, has_cleared);
        make_neutral(*again.fakes[0], 0, 15);
        again.pass(3min);
        EXPECT_EQ(value(), Bytes(4));
        ASSERT_EQ(again.kept.size(), 1u);
        const std::string name = again.kept.begin()->first;
        if (!has_cleared) {    // it is reported once
            EXPECT_EQ(again.reports.at(0), name +
                                               " is not written back: this unit can't be distinguished from others of its type "
                                               "that were never calibrated; if the values belong to it: anoctl param import " +
                                               name + ", then anoctl param save; otherwise remove the file");
        }
    }
}

TEST_F(CutOffOfTwoSensors, are_written_if_one_value_distinguishes_the_device_from_a_spare_unit) {
    remember(0, true);
    make_neutral(*again.fakes[0], 0, 15);
    const json note = json::parse(again.kept.begin()->second);
    store(*again.fakes[0], 2, note.at("parameters").at("CAL_AOFF_Z").get<float>());
    ASSERT_TRUE(again.until([&] { return again.kept.empty(); }, 3min));
    EXPECT_EQ(value(), before);
}

TEST_F(CutOffOfTwoSensors, are_not_restored_by_a_calibration_of_a_unit_whose_other_sensor_was_never_calibrated) {
    remember(0, true);
    make_neutral(*again.fakes[0], 0, 15);
    const auto answer = again.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_EQ(answer.status, 202u) << answer.json;
    const std::string job = "/jobs/" + std::to_string(answer.json.at("id").get<int>());
    ASSERT_TRUE(again.until([&] { return again.ask("GET", job).json.at("state") == "waiting"; }, 1min));
    ASSERT_EQ(again.reports.size(), 1u);
    EXPECT_NE(again.reports[0].find("so its values stay, and the file is removed: "), std::string::npos) << again.reports[0];
    EXPECT_NE(again.reports[0].find("\"CAL_AOFF_X\":0.625"), std::string::npos) << again.reports[0];
    again.ask("POST", job + "/next");
    again.pass(1s);
    EXPECT_EQ(again.ask("DELETE", job).json.at("error"), "cancelled; the old values are restored");
    EXPECT_EQ(value(), Bytes(4));
}

TEST_F(Calibrates, and_reports_how_to_restore_the_values_of_a_device_not_distinguishable_from_others) {
    for (std::size_t i = 15; i < 21; ++i) ano::store(fake.parameters[i].value.data(), i < 18 ? 0.0f : 1.0f);
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    go_on();
    fake.deaf = true;
    const json over = until_over(1);
    const std::string name = net.kept.begin()->first;
    EXPECT_EQ(
        over.at("error"),
        "0xDC stopped sending: nothing was received for 4.5 s; the old values could not be written back; they are saved as " +
            name +
            "; this unit can't be distinguished from others of its type that were never calibrated, so write them back by hand: "
            "anoctl "
            "param import " +
            name + ", then anoctl param save");
    fake.deaf = false;
    net.pass(3min);
    EXPECT_EQ(net.kept.size(), 1u);
    EXPECT_EQ(fake.parameters[0].value, cleared);
}

TEST_F(CutOff, importing_all_old_values_removes_the_note) {
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

TEST_F(CutOff, a_damaged_file_does_not_prevent_a_calibration) {
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

TEST_F(Calibrates, nothing_when_the_device_took_off_while_the_job_waited) {
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_TRUE(net.until([&] { return state() == "waiting"; }));
    net.passes(frame(0xDC, 0xFF, 0x06, {1, 2, 0, 0, 0}));
    const auto [status, error] = net.ask("POST", "/jobs/1/next");
    EXPECT_EQ(status, 409u);
    EXPECT_EQ(error.at("error"), "0xDC is unlocked or flying: this is only allowed on the ground");
    EXPECT_EQ(state(), "waiting");
    EXPECT_EQ(fake.parameters[0].value, before);
    net.passes(frame(0xDC, 0xFF, 0x06, {1, 0, 0, 0, 0}));
    EXPECT_EQ(net.ask("POST", "/jobs/1/next").status, 200u);
}

// A loader may not report its identity: then gateway, link and address identify it.
TEST_F(LongJobs, a_boot_loader_note_applies_to_one_unit_only) {
    load();
    net.ask("GET", "/devices/0xDC/parameters");
    net.ask("POST", "/devices/0xDC/firmware", std::string(100'000, '\x01'));
    ASSERT_TRUE(net.until([&] { return loader.frames > 10; }));
    ASSERT_EQ(net.kept.size(), 1u);
    const std::string name = net.kept.begin()->first, note = net.kept.begin()->second;
    const auto in_loader = [&](const std::string& text, const anogate::UnitPlace& unit) {
        SimulatedNet again;
        again.add();
        again.unit = unit;
        EXPECT_TRUE(again.service.remember(name, text));
        const json device = again.ask("GET", "/devices").json.at("devices")[0];
        EXPECT_FALSE(device.contains("kept"));
        return device.contains("in_loader");
    };
    EXPECT_TRUE(in_loader(note, net.unit));
    EXPECT_FALSE(in_loader(note, {"/run/other.sock", net.unit.link, net.unit.wire}));
    EXPECT_FALSE(in_loader(note, {net.unit.gateway, "radio", net.unit.wire}));
    EXPECT_FALSE(in_loader(note, {net.unit.gateway, net.unit.link, "serial:/dev/other"}));
    json older = json::parse(note);
    older.erase("gateway");
    EXPECT_FALSE(in_loader(older.dump(), net.unit));
}

TEST(CrashJournal, that_are_damaged_are_not_used_and_the_consequence_is_reported) {
    const std::string whole = R"({"gateway": "g", "link": "l", "wire": "w", "device": {"address": "0xDC"}, "type7": "u64"})";
    for (const char* const name : {"firmware-0xDC-12ab34cd.json", "firmware-0xDC.json"}) {
        EXPECT_EQ(anogate::damage_of_note(name, whole), "");
        for (const std::string& text : {std::string{}, std::string{"{"}, std::string{"{}"}, std::string{"[]"}, whole + "x",
                                        std::string(200, '['), std::string{R"({"device": {"address": "0xDD"}})"},
                                        std::string{R"({"device": {"address": "0xDC", "address": "0xDC"}})"}})
            EXPECT_TRUE(anogate::damage_of_note(name, text)
                            .starts_with("is damaged and ignored: the device 0xDC may be in its boot loader"))
                << text;
    }
    EXPECT_EQ(anogate::damage_of_note("type7-0xDC.json", whole), "");
    EXPECT_NE(anogate::damage_of_note("type7-0xDC.json", R"({"device": {"address": "0xDC"}, "type7": "u16"})"), "");
}

TEST(CrashJournal, are_only_files_with_exact_note_names) {
    for (const char* name :
         {"calibration-0xDC-accelerometer.json", "calibration-0x01-compass.json", "firmware-0xDC.json",
          "calibration-0xDC-12ab34cd-compass.json", "firmware-0xDC-12ab34cd.json", "type7-0x01-00000000.json", "type7-0xDC.json"})
        EXPECT_TRUE(anogate::is_note(name)) << name;
    for (const char* name : {"calibration-0xDC\n2026 all is well-accelerometer.json", "calibration-0xDC-\x1B[2J-compass.json",
                             "calibration-0xdc-compass.json", "calibration-0xDC-gyroscope.json", "firmware-0xDC-old.json",
                             "firmware-0x\n.json", "calibration-0xDC-12AB34CD-compass.json", "firmware-0xDC-12AB34CD.json",
                             "firmware-0xDC-1.json", "firmware-0xDC.json.tmp", "firmware-0xDC", ""})
        EXPECT_FALSE(anogate::is_note(name)) << name;
}

TEST_F(Calibrates, only_sensors_that_the_device_has) {
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/calibration", R"({"what": "barometer"})").status, 400u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/calibration", "{}").status, 400u);
    fake.parameters.resize(15);
    net.ask("POST", "/devices/0xDC/calibration", R"({"what": "compass"})");
    EXPECT_EQ(until_over(1).at("what"), "unsupported");
}

}    // namespace
}    // namespace long_jobs_tests
