// Parameters through the routes: read, written, applied; the reports when that fails.
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

#include <functional>
#include <set>
#include <string>
#include <utility>

namespace parameters_tests {
namespace {

using namespace support;
using json = nlohmann::ordered_json;

struct ParameterRoutes : testing::Test {
    SimulatedNet net;
    FakeDevice& fake = net.add();

    ParameterRoutes() {
        fake.parameters = {{0, "U8", "a byte", {7}},
                           {8, "F32", "", {0xCD, 0xCC, 0xCC, 0x3D}},
                           {10, "TEXT", "", {'a', 'b', 'c', 'd', 0, 0}},
                           {6, "BIG", "", {1, 0, 0, 0, 0, 0, 0x20, 0}},
                           {3, "I16", "", {1, 0}}};
    }
    ~ParameterRoutes() override { EXPECT_FALSE(fake.crashed); }
};

TEST_F(ParameterRoutes, all_are_read_with_their_values) {
    const auto [status, all] = net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_EQ(status, 200u);
    EXPECT_EQ(all.at("device"),
              json::parse(R"({"address": "0xDC", "name": "fake", "dev_id": 220, "hw": 100, "sw": 100, "bl": 0, "pt": 800})"));
    ASSERT_EQ(all.at("parameters").size(), 5u);
    EXPECT_EQ(all.at("parameters")[0], json::parse(R"({"id": 0, "name": "U8", "type": "u8", "value": 7, "text": "a byte"})"));
    EXPECT_EQ(all.at("parameters")[1].at("value"), 0.1);
    EXPECT_EQ(all.at("parameters")[2].at("value"), "abcd");
    EXPECT_EQ(all.at("parameters")[3].at("value"), "9007199254740993") << "beyond 2^53";
}

TEST_F(ParameterRoutes, a_parameter_that_was_removed_meanwhile_is_reported_as_unknown) {
    int asked = 0;
    fake.instead = [&](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0 && f.data()[0] == 1) fake.reported_count = static_cast<std::uint16_t>(++asked <= 1 ? 5 : 1);
        return std::nullopt;
    };
    const auto [status, answer] = net.ask("GET", "/devices/0xDC/parameters/I16");
    EXPECT_EQ(status, 404u);
    EXPECT_EQ(answer.at("error"), "unknown parameter 'I16'");
}

TEST_F(ParameterRoutes, an_unknown_name_is_an_error_that_names_a_similar_one) {
    for (const char* const path : {"/devices/0xDC/parameters?name=I61", "/devices/0xDC/parameters/I61"}) {
        const auto [status, answer] = net.ask("GET", path);
        EXPECT_EQ(status, 404u) << path;
        EXPECT_EQ(answer.at("error"), "unknown parameter 'I61' (did you mean 'I16'?)") << path;
    }
    const auto [status, some] = net.ask("GET", "/devices/0xDC/parameters?name=I16&name=NOPE");
    EXPECT_EQ(status, 200u);
    EXPECT_EQ(some.at("parameters").size(), 1u) << "an unknown one among others is left out";
}

TEST_F(ParameterRoutes, without_values_only_descriptions_are_read) {
    const json all = net.ask("GET", "/devices/220/parameters?values=0").json;
    EXPECT_EQ(all.at("parameters")[0], json::parse(R"({"id": 0, "name": "U8", "type": "u8", "text": "a byte"})"));
}

TEST_F(ParameterRoutes, a_device_is_also_found_by_its_name) {
    EXPECT_EQ(net.ask("GET", "/devices/fake/parameters").status, 404u) << "nobody has asked for it yet";
    net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_EQ(net.ask("GET", "/devices/fake/parameters").status, 200u);
    net.add(0xDD);
    net.ask("GET", "/devices/0xDD/parameters");
    EXPECT_EQ(net.ask("GET", "/devices/fake/parameters").status, 409u) << "two are called so";
}

TEST_F(ParameterRoutes, a_parameter_that_was_not_received_is_reported_as_missing) {
    fake.instead = [](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0 && f.data()[0] == 2 && f.data()[1] == 3) return std::vector<Bytes>{};
        return std::nullopt;
    };
    const auto [status, all] = net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_EQ(status, 200u);
    EXPECT_EQ(all.at("incomplete"), "parameter 3 was not received completely");
    EXPECT_EQ(all.at("parameters")[3], json::parse(R"({"id": 3, "name": "BIG", "type": "u64", "missing": true})"));
}

TEST_F(ParameterRoutes, a_value_longer_than_its_type_is_reported_as_unreadable) {
    fake.parameters[0].value = {0x2A, 0xC0, 0x81, 0x00};
    const auto [status, all] = net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_EQ(status, 200u);
    const json row = json::parse(R"({"id": 0, "name": "U8", "type": "u8", "text": "a byte", "unreadable": "4 bytes for u8"})");
    EXPECT_EQ(all.at("parameters")[0], row);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/U8").json, row);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters?values=0").json.at("parameters")[0].contains("unreadable"), false);
}

TEST_F(ParameterRoutes, one_is_read_by_name_or_number) {
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/F32").json.at("value"), 0.1);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/4").json.at("name"), "I16");
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/F33").status, 404u);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/5").status, 404u) << "an id at the count is never sent";
}

TEST_F(ParameterRoutes, a_name_shared_by_several_is_ambiguous_and_the_error_lists_their_numbers) {
    fake.parameters.push_back({0, "U8", "another", {9}});
    const json wrong = json::parse(
        R"({"error": "several parameters have the name 'U8': use the number, 0, 5", "error_id": "ambiguous_parameter",
            "error_args": {"name": "'U8'", "numbers": "0, 5"}, "what": "ambiguous"})");
    for (const auto& [status, told] :
         {net.ask("GET", "/devices/0xDC/parameters/U8"), net.ask("PUT", "/devices/0xDC/parameters/U8", R"({"value": 1})"),
          net.ask("POST", "/devices/0xDC/apply", R"({"U8": 1})")}) {
        EXPECT_EQ(status, 409u);
        EXPECT_EQ(told.at("error"), wrong.at("error"));
        EXPECT_EQ(told.at("what"), "ambiguous");
    }
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/5", R"({"value": 1})").json.at("stored"), 1);
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
}

// As in a file of another device. If each had a row in the answer, the gateway would stall for a second.
TEST_F(ParameterRoutes, an_error_about_thousands_of_unknown_names_lists_the_first_and_counts_the_others) {
    json values;
    values["U8"] = 8;
    for (int i = 0; i < 5000; ++i) values["k" + std::to_string(i)] = 0;
    for (const char* const flag : {"rollback", "goes_on", "dry_run"}) {
        const auto told = net.ask("POST", "/devices/0xDC/apply", json{{flag, true}, {"parameters", values}}.dump());
        EXPECT_EQ(told.status, 422u);
        const std::string error = told.json.at("error");
        EXPECT_TRUE(error.starts_with("nothing was written: unknown parameters  'k")) << error;
        EXPECT_TRUE(error.ends_with(" and 4995 more")) << error;
        EXPECT_LT(told.json.dump().size(), 1000u);
    }
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
}

// A file has "NAME#NUMBER" where the name alone is ambiguous.
TEST_F(ParameterRoutes, parameters_with_ambiguous_names_are_applied_by_name_and_number) {
    fake.parameters.push_back({0, "U8", "another", {9}});
    fake.parameters.push_back({0, "", "", {1}});
    fake.parameters.push_back({0, "", "", {2}});
    fake.parameters.push_back({0, "a\nb", "", {3}});
    const auto states = [](const json& answer) {
        std::string all;
        for (const json& row : answer.at("parameters")) all += (all.empty() ? "" : " ") + row.at("state").get<std::string>();
        return all;
    };
    const char* const values = R"({"U8#0": 7, "U8#5": 9, "#6": 1, "#7": 2, "a?b#8": 3, "I16": 1})";
    const auto same = net.ask("POST", "/devices/0xDC/apply", std::string{R"({"dry_run": true, "parameters": )"} + values + "}");
    EXPECT_EQ(same.status, 200u) << same.json;
    EXPECT_EQ(states(same.json), "unchanged unchanged unchanged unchanged unchanged unchanged");
    const auto written = net.ask("POST", "/devices/0xDC/apply", R"({"parameters": {"U8#5": 10, "#7": 11, "a?b#8": 12}})");
    EXPECT_EQ(written.status, 200u) << written.json;
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
    EXPECT_EQ(fake.parameters[5].value, Bytes{10});
    EXPECT_EQ(fake.parameters[6].value, Bytes{1});
    EXPECT_EQ(fake.parameters[7].value, Bytes{11});
    EXPECT_EQ(fake.parameters[8].value, Bytes{12});
    EXPECT_NE(net.ask("POST", "/devices/0xDC/apply", R"({"parameters": {"I16#5": 10}})").status, 200u) << "another is called so";
}

// A file of an older version has a '?' in place of characters that control or reorder a text; a new one has the name itself.
TEST_F(ParameterRoutes, parameters_with_control_characters_in_their_names_are_found_in_files_of_any_version) {
    fake.parameters.push_back({0, "P\xE2\x80\xAEX", "", {1}});
    fake.parameters.push_back({0, "\xE2\x80\x8BY\x01", "", {2}});
    fake.parameters.push_back({0, "P\xE2\x80\xADX", "", {3}});
    for (const char* const values :
         {R"({"P\u202eX": 1, "\u200bY\u0001": 2, "P\u202dX": 3})", R"({"P?X#5": 1, "?Y?#6": 2, "P?X#7": 3})"}) {
        const auto same = net.ask("POST", "/devices/0xDC/apply",
                                  std::string{R"({"dry_run": true, "parameters": )"} + values + "}");
        ASSERT_EQ(same.status, 200u) << same.json;
        for (const json& row : same.json.at("parameters")) EXPECT_EQ(row.at("state"), "unchanged") << same.json;
    }
    for (const char* const value : {R"({"P?X#6": 1})", R"({"P?#5": 1})", R"({"P?XX#5": 1})", R"({"P?X": 1})"})
        EXPECT_NE(net.ask("POST", "/devices/0xDC/apply", std::string{R"({"parameters": )"} + value + "}").status, 200u) << value;
}

TEST_F(ParameterRoutes, a_write_returns_the_stored_value) {
    EXPECT_EQ(
        net.ask("PUT", "/devices/0xDC/parameters/I16", R"({"value": -300})").json,
        json::parse(
            R"({"id": 4, "name": "I16", "type": "i16", "was": 1, "written": -300, "stored": -300, "clamped": false, "acknowledged": true})"));
    fake.parameters[0].store = [](const Bytes&) { return Bytes{100}; };
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/0", R"({"value": 200})").json.at("clamped"), true);
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/BIG", R"({"value": "9007199254740995"})").status, 200u);
    EXPECT_EQ(fake.parameters[3].value[0], 3);
}

TEST_F(ParameterRoutes, a_write_reports_that_the_device_did_not_acknowledge_it) {
    fake.instead = [&](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0xE1) return std::nullopt;
        fake.usual(f);
        return std::vector<Bytes>{};
    };
    const auto [status, written] = net.ask("PUT", "/devices/0xDC/parameters/U8", R"({"value": 9})");
    EXPECT_EQ(status, 200u) << written;
    EXPECT_EQ(written.at("stored"), 9);
    EXPECT_EQ(written.at("acknowledged"), false);
}

TEST_F(ParameterRoutes, a_value_that_does_not_fit_is_never_written) {
    for (const char* body : {R"({"value": 256})", R"({"value": 1.5})", R"({"value": "word"})"}) {
        const auto [status, error] = net.ask("PUT", "/devices/0xDC/parameters/U8", body);
        EXPECT_EQ(status, 422u) << body;
        EXPECT_EQ(error.at("what"), "invalid") << error;
    }
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/TEXT", R"({"value": "longer than it"})").status, 422u);
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/TEXT", R"({"value": "longer than it", "longer": true})").status, 200u);
    for (const char* body : {"", "{}", R"({"value": null})", R"({"value": [1]})", R"({"value": true})", R"({"value": false})",
                             R"({"value": 1, "valu": 2})", R"([1])", "{"})
        EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/U8", body).status, 400u) << body;
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
}

TEST_F(ParameterRoutes, a_write_fails_if_the_device_keeps_its_value) {
    fake.parameters[0].store = [](const Bytes&) { return Bytes{7}; };
    const auto [status, error] = net.ask("PUT", "/devices/0xDC/parameters/U8", R"({"value": 200})");
    EXPECT_EQ(status, 502u);
    EXPECT_EQ(error.at("error"), "0xDC keeps U8 at 7");
    EXPECT_EQ(error.at("what"), "refused");
}

TEST_F(ParameterRoutes, a_timeout_is_reported_with_the_number_of_requests_sent) {
    fake.deaf = true;
    const auto [status, error] = net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_EQ(status, 504u);
    EXPECT_EQ(error.at("what"), "timeout");
    EXPECT_EQ(error.at("evidence").at("sent"), 30);
    EXPECT_EQ(error.at("error"), "0xDC does not answer: device info, sent 30 times");
}

TEST_F(ParameterRoutes, apply_writes_differing_values_and_lists_each_value) {
    const json all = net.ask("POST", "/devices/0xDC/apply", R"({"U8": 7, "I16": 5, "TEXT": "new"})").json;
    EXPECT_EQ(all.at("parameters"), json::parse(R"([
        {"name": "U8", "was": 7, "written": 7, "stored": 7, "clamped": false, "state": "unchanged"},
        {"name": "I16", "was": 1, "written": 5, "stored": 5, "clamped": false, "state": "written"},
        {"name": "TEXT", "was": "abcd", "written": "new", "stored": "new", "clamped": false, "state": "written"}])"));
}

TEST_F(ParameterRoutes, a_dry_run_only_lists_the_changes) {
    const json all = net.ask("POST", "/devices/0xDC/apply", R"({"parameters": {"U8": 8, "I16": 1}, "dry_run": true})").json;
    EXPECT_EQ(all.at("parameters"), json::parse(R"([{"name": "U8", "was": 7, "written": 8, "clamped": false, "state": "differs"},
        {"name": "I16", "was": 1, "written": 1, "clamped": false, "state": "unchanged"}])"));
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
}

TEST_F(ParameterRoutes, apply_undoes_all_when_one_fails) {
    fake.parameters[4].store = [](const Bytes&) { return Bytes{1, 0}; };
    const auto [status, error] = net.ask("POST", "/devices/0xDC/apply",
                                         R"({"parameters": {"U8": 8, "I16": 5}, "rollback": true})");
    EXPECT_EQ(status, 502u);
    EXPECT_EQ(error.at("what"), "refused");
    EXPECT_EQ(error.at("result").at("parameters")[0].at("state"), "undone") << error;
    EXPECT_EQ(error.at("result").at("parameters")[1].at("state"), "failed") << error;
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
}

TEST_F(ParameterRoutes, apply_skips_a_refused_value_and_writes_the_others) {
    fake.parameters[0].store = [](const Bytes&) { return Bytes{7}; };
    const auto [status, error] = net.ask("POST", "/devices/0xDC/apply", R"({"U8": 8, "I16": 5})");
    EXPECT_EQ(status, 502u);
    EXPECT_EQ(error.at("error"), "0xDC keeps U8 at 7");
    EXPECT_EQ(error.at("result").at("parameters")[0].at("state"), "failed") << error;
    EXPECT_EQ(error.at("result").at("parameters")[1].at("state"), "written") << error;
    EXPECT_EQ(fake.parameters[4].value, (Bytes{5, 0}));
}

TEST_F(ParameterRoutes, nothing_is_applied_when_one_value_is_invalid) {
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"U8": 8, "NONE": 5})").status, 422u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"U8": 8, "I16": 70000})").status, 422u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"U8": {}})").status, 422u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"U8": true})").status, 422u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"parameters": {"U8": 8}, "rolback": true})").status, 400u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"parameters": {"U8": 8}, "rollback": 1})").status, 400u);
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
}

// The requests of `anoctl param get` and `set` to a device that was read before, with 200 ms delay each way.
struct KnownParameters : ParameterRoutes {
    KnownParameters() {
        fake.make_parameters(100);
        net.line.delay = 200ms;
        net.ask("GET", "/devices/0xDC/parameters");
        net.sent.clear();
    }
    static constexpr Duration round_trip = 400ms;
    /// The duration of `asks`.
    Duration time(const std::function<void()>& asks) {
        const TimePoint begin = net.time;
        asks();
        return net.time - begin;
    }
    json get(const std::string& query) {
        const auto [status, answer] = net.ask("GET", "/devices/0xDC/parameters?" + query);
        EXPECT_EQ(status, 200u) << answer;
        return answer;
    }
    void described() {
        EXPECT_EQ(get("values=0&known").at("known"), true);
        EXPECT_TRUE(net.sent.empty());
    }
    /// Telemetry, with a pause as after a quick restart.
    void pause() {
        stream(1s);
        net.pass(900ms);
        stream(600ms);    // its device info is requested
        net.sent.clear();
    }
    void stream(Duration time) {
        for (const TimePoint end = net.time + time; net.time < end; net.pass(100ms))
            net.passes(frame(0xDC, 0xFF, 0x03, {0, 0, 0, 0, 0, 0, 0}));
    }
    std::size_t described_again() const {
        return static_cast<std::size_t>(
            std::count_if(net.sent.begin(), net.sent.end(), [](const Bytes& f) { return f[3] == 0xE0 && f[6] == 3; }));
    }
    static std::string five(int value) {
        json parameters = json::object();
        for (const int i : {10, 20, 30, 40, 50}) parameters["PAR_" + std::to_string(i)] = value;    // all are u8
        return json{{"parameters", parameters}, {"goes_on", false}, {"also_the_same", true}}.dump();
    }
    std::size_t sent(std::uint8_t id) const {
        return static_cast<std::size_t>(
            std::count_if(net.sent.begin(), net.sent.end(), [&](const Bytes& f) { return f[3] == id; }));
    }
};

TEST_F(KnownParameters, are_read_in_one_round_trip) {
    EXPECT_EQ(time([&] {
                  const json answer = get("name=PAR_20");
                  ASSERT_EQ(answer.at("parameters").size(), 1u) << answer;
                  EXPECT_EQ(answer.at("parameters")[0].at("value"), 20);
              }),
              round_trip);
    EXPECT_EQ(net.sent.size(), 3u) << "device info, number, value";
    EXPECT_EQ(time([&] { EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/PAR_20").json.at("value"), 20); }), round_trip);
    EXPECT_EQ(time([&] {
                  const json answer = get("name=PAR_10&name=PAR_20&name=PAR_30&name=PAR_40&name=7&name=NONE");
                  EXPECT_EQ(answer.at("parameters").size(), 5u) << answer;
              }),
              round_trip);
}

TEST_F(KnownParameters, are_written_in_two_round_trips) {
    EXPECT_EQ(time([&] {
                  described();
                  const json written = net.ask("PUT", "/devices/0xDC/parameters/PAR_20", R"({"value": 99})").json;
                  EXPECT_EQ(written.at("was"), 20);
                  EXPECT_EQ(written.at("stored"), 99);
              }),
              2 * round_trip);
    EXPECT_EQ(fake.parameters[25].value, Bytes{99});
}

TEST_F(KnownParameters, are_written_in_three_round_trips_if_clamped) {
    fake.parameters[25].store = [](const Bytes&) { return Bytes{50}; };
    EXPECT_EQ(time([&] {
                  const json written = net.ask("PUT", "/devices/0xDC/parameters/PAR_20", R"({"value": 99})").json;
                  EXPECT_EQ(written.at("clamped"), true);
              }),
              3 * round_trip);
}

TEST_F(KnownParameters, five_are_written_within_four_seconds) {
    EXPECT_EQ(time([&] {
                  described();
                  const auto [status, answer] = net.ask("POST", "/devices/0xDC/apply", five(99));
                  EXPECT_EQ(status, 200u) << answer;
                  for (const json& row : answer.at("parameters")) EXPECT_EQ(row.at("state"), "written") << row;
              }),
              7 * round_trip)
        << "the last is that in which all are read once more";
    EXPECT_EQ(sent(0xE1), 5u);
    EXPECT_LT(7 * round_trip, 4s);
}

TEST_F(KnownParameters, of_a_device_that_has_fewer_now_are_read_again_before_the_write) {
    const auto old = std::exchange(fake.parameters, {{0, "OTHER", "", {7}}, {0, "PAR_20", "", {8}}});
    fake.instead = [&](ano::FrameView f) -> std::optional<std::vector<Bytes>> {    // does not crash, so that more frames are seen
        const bool asks_beyond = f.id() == 0xE0 && f.data()[0] >= 2 && f.data()[1] > 1;
        return asks_beyond ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    const auto [status, written] = net.ask("PUT", "/devices/0xDC/parameters/PAR_20", R"({"value": 99})");
    EXPECT_EQ(status, 200u) << written;
    EXPECT_EQ(written.at("id"), 1);
    EXPECT_EQ(written.at("was"), 8);
    EXPECT_EQ(fake.parameters[1].value, Bytes{99});
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
}

TEST_F(KnownParameters, of_a_device_that_paused_are_compared_without_another_round_trip) {
    pause();
    EXPECT_EQ(
        time([&] { EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/PAR_20", R"({"value": 99})").json.at("stored"), 99); }),
        2 * round_trip);
    EXPECT_EQ(described_again(), 1u);
    const auto all = net.asked("GET", "/devices/0xDC/parameters");
    for (int i = 0; i < 300 && !all->has_value(); ++i) stream(100ms);
    net.sent.clear();
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/PAR_20").status, 200u);
    EXPECT_EQ(described_again(), 0u) << "all were described since";
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/PAR_20", R"({"value": 98})").json.at("stored"), 98);
    EXPECT_EQ(described_again(), 1u) << "one that is written is compared in any case";
}

// Firmware of the same version, with as many parameters in another order.
TEST_F(KnownParameters, of_a_device_that_paused_and_has_them_in_another_order_are_read_again_before_one_is_written) {
    pause();
    std::swap(fake.parameters[25].name, fake.parameters[35].name);
    const json written = net.ask("PUT", "/devices/0xDC/parameters/PAR_20", R"({"value": 99})").json;
    EXPECT_EQ(written.at("id"), 35);
    EXPECT_EQ(fake.parameters[25].value, Bytes{20});
    EXPECT_EQ(fake.parameters[35].value, Bytes{99});

    pause();
    std::swap(fake.parameters[25].name, fake.parameters[35].name);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", five(77)).status, 200u);
    for (const std::size_t id : {15u, 25u, 35u, 45u, 55u}) EXPECT_EQ(fake.parameters[id].value, Bytes{77}) << id;
    EXPECT_GT(described_again(), 100u);

    pause();
    std::swap(fake.parameters[25].name, fake.parameters[36].name);
    EXPECT_EQ(get("").at("parameters")[25].at("name"), "PAR_31") << "the list as well";
}

TEST_F(KnownParameters, of_a_device_that_paused_and_changed_a_type_reject_values_of_the_old_type) {
    const Bytes before = fake.parameters[13].value;    // PAR_8
    pause();
    fake.parameters[13].type = 5;    // i32, was f32
    const auto [status, error] = net.ask("PUT", "/devices/0xDC/parameters/PAR_8", R"({"value": 7.5})");
    EXPECT_EQ(status, 422u) << error;
    EXPECT_EQ(fake.parameters[13].value, before);
    EXPECT_EQ(sent(0xE1), 0u);
}

// The pause is detected between two values.
TEST_F(KnownParameters, that_are_set_together_are_compared_when_the_device_pauses_meanwhile) {
    stream(1s);
    const auto answer = net.asked("POST", "/devices/0xDC/apply", five(99));
    ASSERT_TRUE(net.until([&] { return sent(0xE1) == 1; }));
    std::swap(fake.parameters[35].name, fake.parameters[36].name);
    net.pass(150ms);
    stream(100ms);
    ASSERT_TRUE(net.until([&] { return answer->has_value(); }));
    EXPECT_EQ((*answer)->status, 502u) << (*answer)->json;
    EXPECT_EQ(fake.parameters[35].value, Bytes{30});
}

TEST_F(KnownParameters, of_a_device_of_another_version_are_read_again) {
    fake.version = 101;
    std::swap(fake.parameters[25].name, fake.parameters[35].name);
    const json row = get("name=PAR_20").at("parameters")[0];
    EXPECT_EQ(row.at("id"), 35);
    EXPECT_EQ(row.at("value"), 30);
}

TEST_F(KnownParameters, of_a_device_that_was_silent_are_requested_only_after_it_reported_their_count) {
    net.pass(40s);
    fake.parameters.resize(5);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/PAR_20").status, 404u);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/I16").json.at("value"), 1);
}

TEST_F(KnownParameters, are_read_even_if_the_device_handles_one_request_at_a_time) {
    TimePoint last{};
    fake.instead = [&](ano::FrameView) -> std::optional<std::vector<Bytes>> {
        const bool is_busy = net.time - last < 1ms;
        last = net.time;
        return is_busy ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/PAR_20", R"({"value": 99})").json.at("stored"), 99);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", five(98)).status, 200u);
    EXPECT_EQ(fake.parameters[55].value, Bytes{98});
}

TEST_F(KnownParameters, that_are_set_together_stop_at_the_first_that_is_refused) {
    fake.parameters[25].store = [](const Bytes& value) { return value == Bytes{99} ? Bytes{20} : value; };
    const auto [status, error] = net.ask("POST", "/devices/0xDC/apply", five(99));
    EXPECT_EQ(status, 502u);
    EXPECT_EQ(error.at("error"), "0xDC keeps PAR_20 at 20");
    std::string states;
    for (const json& row : error.at("result").at("parameters")) states += row.at("state").get<std::string>() + " ";
    EXPECT_EQ(states, "written failed waiting waiting waiting ");
}

TEST_F(KnownParameters, are_written_over_a_line_that_loses_a_tenth) {
    net.line.loss = 0.1;
    for (int value = 100; value < 120; ++value) {
        const auto [status, answer] = net.ask("POST", "/devices/0xDC/apply", five(value));
        ASSERT_EQ(status, 200u) << answer;
        for (const std::size_t i : {15u, 25u, 35u, 45u, 55u}) ASSERT_EQ(fake.parameters[i].value[0], value);
    }
}

TEST_F(ParameterRoutes, all_are_read_when_30_percent_of_the_frames_are_lost) {
    fake.make_parameters(100);
    net.line.loss = 0.3;
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").json.at("parameters").size(), 105u);
}

// A later run of a program that opens the line itself, with a delay of 300 ms each way.
struct KeptDescriptions : testing::Test {
    static constexpr std::size_t many = 150;
    SimulatedNet first;

    KeptDescriptions() {
        first.add().make_parameters(many);
        first.service.keep_descriptions();
        EXPECT_EQ(first.ask("GET", "/devices/0xDC/parameters").status, 200u);
        EXPECT_EQ(first.cache_folder.size(), 1u);
    }
    struct Set {
        unsigned status = 0;
        ano::Duration took{};
        std::size_t descriptions = 0;    // that were requested
        Bytes stored;                    // value in the device
    };
    /// A run that has the cache sets PAR_70.
    Set set(const std::function<void(SimulatedNet&)>& change = [](SimulatedNet&) {}) const {
        SimulatedNet net;
        net.line.delay = 300ms;
        net.add().make_parameters(many);
        net.cache_folder = first.cache_folder;
        net.service.keep_descriptions();
        change(net);
        const ano::TimePoint begin = net.time;
        Set set;
        // Before `anoctl param set` writes, it looks at the type.
        const json looked = net.ask("GET", "/devices/0xDC/parameters?values=0&known&name=PAR_70").json;
        EXPECT_EQ(looked.at("parameters").size(), 1u) << looked;
        set.status = net.ask("PUT", "/devices/0xDC/parameters/PAR_70", R"({"value": 5})").status;
        set.took = net.time - begin;
        std::set<Bytes> asked;    // each once, even if repeated
        for (const Bytes& frame : net.sent)
            if (frame[3] == 0xE0 && frame[6] == 3) asked.insert(frame);
        set.descriptions = asked.size();
        for (const auto& parameter : net.fakes[0]->parameters)
            if (parameter.name == "PAR_70") set.stored = parameter.value;
        EXPECT_FALSE(net.fakes[0]->crashed);
        return set;
    }
};

TEST_F(KeptDescriptions, reduce_reading_to_the_one_description_that_is_used) {
    const Set known = set(), unknown = set([](SimulatedNet&net) { net.cache_folder.clear(); });
    EXPECT_EQ(known.status, 200u);
    EXPECT_EQ(known.stored, Bytes{5});
    EXPECT_EQ(known.descriptions, 1u) << "before anything is written";
    EXPECT_LE(known.took, 9 * 600ms) << "round trips";
    EXPECT_GE(unknown.descriptions, many);
    EXPECT_GT(unknown.took, 10s);
    RecordProperty("ms", std::to_string(known.took / 1ms));
}

TEST_F(KeptDescriptions, that_are_wrong_are_read_again) {
    const auto moved = [](SimulatedNet& net) { std::swap(net.fakes[0]->parameters[70].name, net.fakes[0]->parameters[71].name); };
    const auto of_other_type = [](SimulatedNet& net) {
        net.fakes[0]->parameters[70].type = 2;
        net.fakes[0]->parameters[70].value = {1, 2};
    };
    const auto damaged = [](SimulatedNet& net) {
        for (auto& [name, text] : net.cache_folder) text.resize(text.size() / 2);
    };
    const auto of_another_version = [](SimulatedNet& net) { ++net.fakes[0]->version; };
    const auto more = [](SimulatedNet& net) { net.fakes[0]->make_parameters(1); };
    const auto of_another_line = [](SimulatedNet& net) { net.unit.wire = "serial:/dev/other"; };
    struct Change {
        const char* what;
        std::function<void(SimulatedNet&)> makes;
        Bytes stored;
    };
    for (const Change& change : {Change{"moved", moved, {5}},
                                 {"type", of_other_type, {5, 0}},
                                 {"damaged", damaged, {5}},
                                 {"version", of_another_version, {5}},
                                 {"count", more, {5}},
                                 {"line", of_another_line, {5}}}) {
        SCOPED_TRACE(change.what);
        const Set written = set(change.makes);
        EXPECT_EQ(written.status, 200u);
        EXPECT_GE(written.descriptions, many);
        EXPECT_EQ(written.stored, change.stored);
    }
}

// A written text uses the encoding shown by the names, even if they were not read again.
TEST(KeptTexts, of_a_device_show_its_encoding) {
    const auto make = [](SimulatedNet& net) {
        net.add().parameters = {{10, "NAME", "", {'a', 'b', 'c', 'd', 'e', 'f'}}, {0, "\xB8\xDF\xB6\xC8", "", {1}}};
        net.service.keep_descriptions();
    };
    SimulatedNet first, later;
    make(first);
    make(later);
    EXPECT_EQ(first.ask("GET", "/devices/0xDC/parameters").status, 200u);
    later.cache_folder = first.cache_folder;
    EXPECT_EQ(later.ask("PUT", "/devices/0xDC/parameters/NAME", R"({"value": "起飞"})").status, 200u);
    const Bytes stored = later.fakes[0]->parameters[0].value;
    EXPECT_EQ(Bytes(stored.begin(), stored.begin() + 4), (Bytes{0xC6, 0xF0, 0xB7, 0xC9}));
}

}    // namespace
}    // namespace parameters_tests
