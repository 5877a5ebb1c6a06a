// Parameters by the routes: read, written, applied; what is told when that fails.
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

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

TEST_F(ParameterRoutes, one_of_a_device_that_has_fewer_meanwhile_is_told_as_gone) {
    int asked = 0;
    fake.instead = [&](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0 && f.data()[0] == 1) fake.says_count = static_cast<std::uint16_t>(++asked <= 2 ? 5 : 1);
        return std::nullopt;
    };
    const auto [status, answer] = net.ask("GET", "/devices/0xDC/parameters/I16");
    EXPECT_EQ(status, 502u);
    EXPECT_EQ(answer.at("error"), "the device changed while it was asked: it no longer has I16");
}

TEST_F(ParameterRoutes, without_values_only_descriptions_are_read) {
    const json all = net.ask("GET", "/devices/220/parameters?values=0").json;
    EXPECT_EQ(all.at("parameters")[0], json::parse(R"({"id": 0, "name": "U8", "type": "u8", "text": "a byte"})"));
}

TEST_F(ParameterRoutes, a_device_is_called_by_its_own_name_as_well) {
    EXPECT_EQ(net.ask("GET", "/devices/fake/parameters").status, 404u) << "nobody has asked for it yet";
    net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_EQ(net.ask("GET", "/devices/fake/parameters").status, 200u);
    net.add(0xDD);
    net.ask("GET", "/devices/0xDD/parameters");
    EXPECT_EQ(net.ask("GET", "/devices/fake/parameters").status, 409u) << "two are called so";
}

TEST_F(ParameterRoutes, what_did_not_come_is_told_as_missing) {
    fake.instead = [](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0 && f.data()[0] == 2 && f.data()[1] == 3) return std::vector<Bytes>{};
        return std::nullopt;
    };
    const auto [status, all] = net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_EQ(status, 200u);
    EXPECT_EQ(all.at("incomplete"), "parameter 3 did not come whole");
    EXPECT_EQ(all.at("parameters")[3], json::parse(R"({"id": 3, "name": "BIG", "type": "u64", "missing": true})"));
}

TEST_F(ParameterRoutes, one_is_read_by_name_or_number) {
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/F32").json.at("value"), 0.1);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/4").json.at("name"), "I16");
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/F33").status, 404u);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters/5").status, 404u) << "an id at the count is never sent";
}

TEST_F(ParameterRoutes, a_name_that_several_have_is_ambiguous_and_their_numbers_are_told) {
    fake.parameters.push_back({0, "U8", "another", {9}});
    const json wrong = json::parse(
        R"({"error": "several parameters are called 'U8': say which by its number, 0, 5", "what": "ambiguous"})");
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

TEST_F(ParameterRoutes, a_write_says_what_was_stored) {
    EXPECT_EQ(
        net.ask("PUT", "/devices/0xDC/parameters/I16", R"({"value": -300})").json,
        json::parse(
            R"({"id": 4, "name": "I16", "type": "i16", "was": 1, "written": -300, "stored": -300, "clamped": false, "acknowledged": true})"));
    fake.parameters[0].store = [](const Bytes&) { return Bytes{100}; };
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/0", R"({"value": 200})").json.at("clamped"), true);
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/BIG", R"({"value": "9007199254740995"})").status, 200u);
    EXPECT_EQ(fake.parameters[3].value[0], 3);
}

TEST_F(ParameterRoutes, a_write_that_the_device_did_not_acknowledge_says_so) {
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

TEST_F(ParameterRoutes, what_does_not_fit_is_never_written) {
    for (const char* body : {R"({"value": 256})", R"({"value": 1.5})", R"({"value": "word"})"}) {
        const auto [status, error] = net.ask("PUT", "/devices/0xDC/parameters/U8", body);
        EXPECT_EQ(status, 422u) << body;
        EXPECT_EQ(error.at("what"), "invalid") << error;
    }
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/TEXT", R"({"value": "longer than it"})").status, 422u);
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/TEXT", R"({"value": "longer than it", "longer": true})").status, 200u);
    for (const char* body : {"", "{}", R"({"value": null})", R"({"value": [1]})", R"({"value": 1, "valu": 2})", R"([1])", "{"})
        EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/U8", body).status, 400u) << body;
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
}

TEST_F(ParameterRoutes, a_device_that_keeps_its_value_refuses) {
    fake.parameters[0].store = [](const Bytes&) { return Bytes{7}; };
    const auto [status, error] = net.ask("PUT", "/devices/0xDC/parameters/U8", R"({"value": 200})");
    EXPECT_EQ(status, 502u);
    EXPECT_EQ(error.at("error"), "0xDC keeps U8 at 7");
    EXPECT_EQ(error.at("what"), "refused");
}

TEST_F(ParameterRoutes, silence_is_told_with_the_evidence) {
    fake.deaf = true;
    const auto [status, error] = net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_EQ(status, 504u);
    EXPECT_EQ(error.at("what"), "timeout");
    EXPECT_EQ(error.at("evidence").at("sent"), 5);
    EXPECT_EQ(error.at("error"), "0xDC does not answer: device info, sent 5 times");
}

TEST_F(ParameterRoutes, apply_writes_what_differs_and_lists_each) {
    const json all = net.ask("POST", "/devices/0xDC/apply", R"({"U8": 7, "I16": 5, "TEXT": "new"})").json;
    EXPECT_EQ(all.at("parameters"), json::parse(R"([
        {"name": "U8", "was": 7, "written": 7, "stored": 7, "clamped": false, "state": "unchanged"},
        {"name": "I16", "was": 1, "written": 5, "stored": 5, "clamped": false, "state": "written"},
        {"name": "TEXT", "was": "abcd", "written": "new", "stored": "new", "clamped": false, "state": "written"}])"));
}

TEST_F(ParameterRoutes, a_dry_run_only_says_what_would_change) {
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

TEST_F(ParameterRoutes, apply_leaves_out_what_is_refused_and_writes_the_others) {
    fake.parameters[0].store = [](const Bytes&) { return Bytes{7}; };
    const auto [status, error] = net.ask("POST", "/devices/0xDC/apply", R"({"U8": 8, "I16": 5})");
    EXPECT_EQ(status, 502u);
    EXPECT_EQ(error.at("error"), "0xDC keeps U8 at 7");
    EXPECT_EQ(error.at("result").at("parameters")[0].at("state"), "failed") << error;
    EXPECT_EQ(error.at("result").at("parameters")[1].at("state"), "written") << error;
    EXPECT_EQ(fake.parameters[4].value, (Bytes{5, 0}));
}

TEST_F(ParameterRoutes, nothing_is_applied_when_one_can_not_be) {
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"U8": 8, "NONE": 5})").status, 422u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"U8": 8, "I16": 70000})").status, 422u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"U8": {}})").status, 422u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"parameters": {"U8": 8}, "rolback": true})").status, 400u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/apply", R"({"parameters": {"U8": 8}, "rollback": 1})").status, 400u);
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
}

TEST_F(ParameterRoutes, at_a_loss_of_a_third_all_is_read) {
    fake.make_parameters(100);
    net.line.loss = 0.3;
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").json.at("parameters").size(), 105u);
}

}    // namespace
}    // namespace parameters_tests
