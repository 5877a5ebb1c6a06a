// Commands and actions by the routes.
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

namespace commands_tests {
namespace {

using namespace support;
using json = nlohmann::ordered_json;

struct CommandRoutes : testing::Test {
    SimulatedNet net;
    FakeDevice& fake = net.add();

    CommandRoutes() { fake.commands = {{{1, 0, 1}, {3}, "TAKE_OFF", "height"}, {{1, 0, 2}, {}, "LAND", ""}}; }
    std::size_t calls() const {
        return static_cast<std::size_t>(
            std::count_if(fake.heard.begin(), fake.heard.end(), [](const Bytes& f) { return f[3] == 0xC0; }));
    }
};

TEST_F(CommandRoutes, are_listed) {
    const json all = net.ask("GET", "/devices/0xDC/commands").json;
    EXPECT_EQ(all.at("device").at("address"), "0xDC");
    EXPECT_EQ(all.at("commands")[0], json::parse(R"({"id": 0, "name": "TAKE_OFF", "text": "height", "values": ["u16"]})")) << all;
    EXPECT_EQ(all.at("commands")[1], json::parse(R"({"id": 1, "name": "LAND", "values": []})"));
}

TEST_F(CommandRoutes, are_called_by_name_or_number) {
    const auto [status, told] = net.ask("POST", "/devices/0xDC/commands/TAKE_OFF", R"({"values": [300]})");
    EXPECT_EQ(status, 200u);
    EXPECT_EQ(told, json::parse(R"({"id": 0, "name": "TAKE_OFF", "called": true})"));
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/1").status, 200u);
    EXPECT_EQ(calls(), 2u);
}

TEST_F(CommandRoutes, that_do_not_fit_are_never_sent) {
    for (const char* body :
         {R"({"values": [70000]})", R"({"values": [1, 2]})", "", R"({"values": ["high"]})", R"({"values": [null]})"})
        EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/TAKE_OFF", body).status, 422u) << body;
    for (const char* body : {R"({"values": 5})", R"({"repeat": 1})", R"({"value": [5]})"})
        EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/TAKE_OFF", body).status, 400u) << body;
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/FLY").status, 404u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/2").status, 404u);
    EXPECT_EQ(calls(), 0u);
}

TEST_F(CommandRoutes, without_an_answer_are_sent_once_and_their_outcome_is_not_known) {
    fake.instead = [](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        return f.id() == 0xC0 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    const auto [status, error] = net.ask("POST", "/devices/0xDC/commands/LAND");
    EXPECT_EQ(status, 504u);
    EXPECT_EQ(error.at("what"), "unknown");
    EXPECT_EQ(calls(), 1u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/LAND", R"({"repeat": true})").json.at("what"), "timeout");
    EXPECT_EQ(calls(), 6u);
}

TEST_F(CommandRoutes, actions_are_acknowledged) {
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", R"({"action": "save"})").json,
              json::parse(R"({"action": "save", "done": true})"));
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", R"({"action": "explode"})").status, 400u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", "{}").status, 400u);
}

// It is listened first, for long enough to hear whether it flies.
TEST_F(CommandRoutes, defaults_are_not_restored_in_the_air) {
    const std::string restore = R"({"action": "restore_defaults"})";
    const auto asked = net.asked("POST", "/devices/0xDC/actions", restore);
    net.pass(1s);
    net.passes(frame(0xDC, 0xFF, 0x06, {1, 2, 0, 0, 0}));    // it is unlocked
    net.pass(2s);
    ASSERT_TRUE(asked->has_value());
    EXPECT_EQ((*asked)->status, 409u);
    EXPECT_EQ((*asked)->json.at("what"), "refused");
    EXPECT_TRUE(net.sent.empty());
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", restore).status, 409u) << "at once, now that it is known";
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions?force", restore).status, 200u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", R"({"action": "save"})").status, 200u) << "that may be done in the air";
    net.passes(frame(0xDC, 0xFF, 0x06, {1, 0, 0, 0, 0}));
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", restore).status, 200u);
    net.where[0xDC].in_conflict = true;
    const auto which = net.ask("POST", "/devices/0xDC/actions?force", restore);
    EXPECT_EQ(which.status, 409u);
    EXPECT_EQ(which.json.at("error"),
              "several devices have the address 0xDC (heard by fc and radio): which of them is meant is not known; when only one "
              "is left, anoctl routes --forget 0xDC");
    net.where[0xDC] = {.is_known = true, .on_several_channels = true};
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions?force", restore).status, 409u);
}

}    // namespace
}    // namespace commands_tests
