// Commands and actions through the routes.
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

// The page requests only the commands, and shows the name.
TEST_F(CommandRoutes, of_a_device_that_describes_none_still_show_its_name) {
    fake.instead = [](ano::FrameView f) { return f.id() == 0xC1 ? std::optional{std::vector<Bytes>{}} : std::nullopt; };
    net.passes(frame(0xDC, 0xFF, 0x03, {0, 0, 0, 0, 0, 0, 0}));
    EXPECT_NE(net.ask("GET", "/devices/0xDC/commands").status, 200u);
    net.pass(3s);
    EXPECT_EQ(net.ask("GET", "/devices").json.at("devices")[0].value("name", ""), fake.name);
}

TEST_F(CommandRoutes, are_called_by_name_or_number) {
    const auto [status, told] = net.ask("POST", "/devices/0xDC/commands/TAKE_OFF", R"({"values": [300]})");
    EXPECT_EQ(status, 200u);
    EXPECT_EQ(told, json::parse(R"({"id": 0, "name": "TAKE_OFF", "called": true})"));
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/1").status, 200u);
    EXPECT_EQ(calls(), 2u);
}

// A device whose commands were read before. ids_of_call() returns the ids of the frames sent for one call, in order.
struct KnownCommands : CommandRoutes {
    KnownCommands() {
        net.ask("GET", "/devices/0xDC/commands");
        net.sent.clear();
    }
    Bytes ids_of_call(const std::string& command = "LAND", const std::string& body = "") {
        net.sent.clear();
        EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/" + command, body).status, 200u) << command << ' ' << body;
        Bytes ids;
        for (const Bytes& f : net.sent) ids.push_back(f[3]);
        return ids;
    }
    void telemetry(Duration time) {
        for (const TimePoint end = net.time + time; net.time < end; net.pass(5s)) net.passes(euler());
    }
    static Bytes euler() { return frame(0xDC, 0xFF, 0x03, {0, 0, 0, 0, 0, 0, 0}); }
    const Bytes only_the_call{0xC0}, confirmed_first{0xC1, 0xC0}, asked_first{0xE0, 0xC1, 0xC0};    // device info, then the
                                                                                                    // command
    // After them its device info is requested.
    static Bytes first_three(Bytes ids) {
        ids.resize(3);
        return ids;
    }
    // Replaces the device: the same bytes have another meaning there.
    void swap_for_a_car() {
        fake.name = "CAR";
        fake.version = 7;
        fake.commands = {{{1, 0, 2}, {}, "FULL_SPEED", ""}, {{1, 0, 1}, {}, "HORN", ""}, {{9, 9, 9}, {}, "LAND", ""}};
    }
    Bytes cid_of_call() const {
        for (const Bytes& f : net.sent)
            if (f[3] == 0xC0) return {f.begin() + 6, f.begin() + 9};
        return {};
    }
    void stream(Duration time) {
        for (const TimePoint end = net.time + time; net.time < end; net.pass(100ms)) net.passes(euler());
    }
};

// Another instance of the fixture within a test.
struct Afresh final : KnownCommands {
    void TestBody() override {}
};

TEST_F(KnownCommands, are_called_with_the_first_frame_sent) {
    EXPECT_EQ(ids_of_call("LAND"), only_the_call);
    EXPECT_EQ(ids_of_call("1"), only_the_call);
    EXPECT_EQ(ids_of_call("TAKE_OFF", R"({"values": [300]})"), only_the_call);
    EXPECT_EQ(ids_of_call("1", R"({"name": "LAND"})"), only_the_call) << "as the page calls it";
    EXPECT_EQ(Bytes(net.sent[0].begin() + 6, net.sent[0].end() - 2), (Bytes{1, 0, 2}));
}

TEST_F(KnownCommands, are_listed_without_a_request_if_the_client_accepts_known_ones) {
    const json all = net.ask("GET", "/devices/0xDC/commands?known").json;
    EXPECT_EQ(all.at("commands").size(), 2u);
    EXPECT_EQ(all.at("device").at("name"), "fake");
    EXPECT_EQ(all.at("known"), true);
    EXPECT_TRUE(net.sent.empty());
    net.ask("GET", "/devices/0xDC/commands");
    EXPECT_EQ(net.sent.size(), 4u) << "two counts, two descriptions";
    net.add(0xDD).commands = fake.commands;
    net.sent.clear();
    EXPECT_EQ(net.ask("GET", "/devices/0xDD/commands?known").json.at("commands").size(), 2u);
    EXPECT_EQ(net.sent.size(), 5u) << "not known: read, and beside it the device info";
}

TEST_F(KnownCommands, are_listed_without_a_request_even_after_an_absence) {
    net.pass(40s);
    net.passes(euler());
    net.pass(1s);
    net.sent.clear();
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/commands?known").json.at("commands").size(), 2u);
    EXPECT_TRUE(net.sent.empty()) << "the call will have it confirmed";
    EXPECT_EQ(ids_of_call("1", R"({"name": "LAND"})"), asked_first);
}

TEST_F(KnownCommands, stay_known_while_the_device_is_received) {
    stream(1s);
    ids_of_call();
    stream(1min);
    telemetry(10min);
    ids_of_call();
    telemetry(10min);
    EXPECT_TRUE(net.listens);
    EXPECT_EQ(ids_of_call(), only_the_call);
    net.pass(2min);
    EXPECT_FALSE(net.listens) << "it is away";
}

TEST_F(KnownCommands, of_a_device_that_was_absent_are_confirmed_by_one_request) {
    net.pass(40s);
    EXPECT_EQ(first_three(ids_of_call()), asked_first);
    net.pass(1s);
    EXPECT_EQ(ids_of_call(), only_the_call);
    net.pass(29s);
    EXPECT_EQ(ids_of_call(), only_the_call) << "it sends nothing unasked: its silence shows nothing";
    net.pass(31s);
    net.passes(euler());
    EXPECT_EQ(first_three(ids_of_call()), asked_first) << "it is back, and may be another one";
    net.pass(3min);
    EXPECT_EQ(first_three(ids_of_call()), asked_first) << "meanwhile nothing was listened to";
}

TEST_F(KnownCommands, of_a_device_whose_link_was_down_match_the_device_that_is_now_present) {
    stream(1s);
    net.service.link_was_down(0xDC);
    swap_for_a_car();
    stream(300ms);
    ids_of_call();
    EXPECT_EQ(cid_of_call(), (Bytes{9, 9, 9}));
    EXPECT_EQ(net.ask("GET", "/devices").json.at("devices")[0].at("name"), "CAR") << "its name was asked for as well";
}

TEST_F(KnownCommands, of_a_device_whose_link_was_down_are_confirmed_once) {
    stream(1s);
    net.service.link_was_down(0xDC);
    stream(300ms);
    EXPECT_EQ(ids_of_call(), confirmed_first);
    EXPECT_EQ(ids_of_call(), only_the_call);
    EXPECT_EQ(ids_of_call("TAKE_OFF", R"({"values": [300]})"), confirmed_first) << "another table may share one of them";
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [1, 0, 2]})").status, 200u);
}

TEST_F(KnownCommands, are_not_sent_while_the_link_is_down_or_later) {
    stream(1s);
    net.service.link_was_down(0xDC);
    net.is_down = true;
    net.sent.clear();
    const TimePoint begin = net.time;
    for (const std::string call : {"LAND", "by-cid"}) {
        const auto refused = net.ask("POST", "/devices/0xDC/commands/" + call, call == "LAND" ? "" : R"({"cid": [1, 0, 2]})");
        EXPECT_EQ(refused.status, 503u) << refused.json;
        EXPECT_EQ(refused.json.at("error"), "not sent: the link 'fc' is down");
        EXPECT_EQ(refused.json.at("evidence").at("sent"), 0) << refused.json;
    }
    EXPECT_LE(net.time - begin, 200ms);
    net.is_down = false;
    stream(10s);
    EXPECT_EQ(calls(), 0u);
}

// It waited in the queue of a link that is too slow.
TEST_F(KnownCommands, dropped_before_they_were_sent_are_reported_as_not_sent) {
    stream(1s);
    fake.deaf = true;
    const auto land = net.asked("POST", "/devices/0xDC/commands/LAND");
    ASSERT_TRUE(net.until([&] { return !net.sent.empty() && net.sent.back()[3] == 0xC0; }, 1s));
    ASSERT_FALSE(land->has_value());
    net.service.not_sent(ano::FrameView{net.sent.back()}, {{"other", "not sent: it waited too long"}, true}, net.time);
    ASSERT_TRUE(net.until([&] { return land->has_value(); }, 100ms));
    EXPECT_EQ((*land)->status, 503u);
    EXPECT_EQ((*land)->json.at("error"), "not sent: it waited too long");
    fake.deaf = false;
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/LAND").status, 200u) << "the acknowledgement is of this one";
    fake.deaf = true;

    net.sent.clear();
    const auto repeated = net.asked("POST", "/devices/0xDC/commands/LAND", R"({"repeat": true})");
    const auto sent = [&] {
        return std::count_if(net.sent.begin(), net.sent.end(), [](const Bytes& f) { return f[3] == 0xC0; });
    };
    ASSERT_TRUE(net.until([&] { return sent() == 2; }, 10s));
    net.service.not_sent(ano::FrameView{net.sent.back()}, {{"other", "not sent: it waited too long"}, true}, net.time);
    EXPECT_FALSE(net.until([&] { return repeated->has_value(); }, 100ms)) << "the first one was sent";
}

// The questions for the call are sent while the link is down; `up` later the device that is there then is heard.
TEST_F(KnownCommands, of_a_device_whose_link_comes_up_meanwhile_match_the_device_that_is_then_present) {
    for (Duration up{}; up < 700ms; up += 50ms) {
        stream(1s);
        net.service.link_was_down(0xDC);
        fake.deaf = true;
        net.sent.clear();
        const auto land = net.asked("POST", "/devices/0xDC/commands/LAND");
        net.pass(up);
        std::swap(fake.commands[0].cid, fake.commands[1].cid);
        fake.deaf = false;
        ASSERT_TRUE(net.until([&] { return land->has_value(); }));
        EXPECT_EQ((*land)->status, 200u) << (*land)->json;
        EXPECT_EQ(cid_of_call(), (Bytes{1, 0, fake.commands[1].cid[2]})) << up / 1ms << " ms";
    }
}

TEST_F(KnownCommands, of_a_device_that_paused_right_after_the_list_are_confirmed) {
    net.pass(1100ms);
    stream(500ms);
    EXPECT_EQ(ids_of_call(), confirmed_first) << "how often it sends was not known yet";
    EXPECT_EQ(ids_of_call(), only_the_call);
}

TEST_F(KnownCommands, of_a_device_that_restarted_right_after_the_list_are_confirmed) {
    net.pass(1s);
    net.passes(frame(0xDC, 0xFE, 0xE3, {0xDC, 100, 0, 100, 0, 0, 0, 32, 3, 'f', 'a', 'k', 'e'}));
    EXPECT_EQ(ids_of_call(), confirmed_first) << "so late it is no answer to what was asked before the list";
}

// Its telemetry arrives as `frames` together, once per `interval`, and the first call at `after`.
TEST_F(KnownCommands, of_a_device_that_sends_rarely_are_called_with_the_first_frame_sent) {
    const Duration all[] = {500ms, 700ms, 1s, 2s, 5s};
    for (const Duration interval : all) {
        for (const int frames : {1, 4}) {
            for (const Duration after : {2800ms, 4700ms, 10000ms, 26000ms}) {
                Afresh other;
                const TimePoint end = other.net.time + after;
                for (other.net.pass(interval * 2 / 5); other.net.time < end;) {
                    for (int i = 0; i < frames; ++i, other.net.pass(5ms)) other.net.passes(euler());
                    other.net.pass(std::min(interval - frames * 5ms, std::max<Duration>(end - other.net.time, 1ms)));
                }
                EXPECT_EQ(other.ids_of_call(), only_the_call)
                    << std::chrono::duration<double>(interval).count() << " s, " << frames << " frames, after "
                    << std::chrono::duration<double>(after).count() << " s";
            }
        }
    }
}

TEST_F(KnownCommands, of_a_device_that_replaced_a_rarely_sending_one_are_confirmed) {
    for (int slow = 0; slow < 4; ++slow) {    // frames of the previous device
        Afresh other;
        for (int i = 0; i < slow; ++i, other.net.pass(1s)) other.net.passes(euler());
        other.net.pass(3s);
        other.swap_for_a_car();
        other.stream(300ms);
        other.ids_of_call();
        EXPECT_EQ(other.cid_of_call(), (Bytes{9, 9, 9})) << slow;
    }
}

// A quick restart without an announcement, with another table of as many commands.
TEST_F(KnownCommands, of_a_device_that_paused_are_confirmed) {
    stream(2s);
    EXPECT_EQ(ids_of_call(), only_the_call);
    std::swap(fake.commands[0].cid, fake.commands[1].cid);
    net.pass(900ms);
    stream(300ms);
    ids_of_call();
    EXPECT_EQ(cid_of_call(), (Bytes{1, 0, 1}));
    net.pass(900ms);
    EXPECT_EQ(ids_of_call(), asked_first) << "it pauses now";
}

// The question for its description is sent before all other requests.
// The pace of its telemetry was observed before the first question to it.
TEST_F(CommandRoutes, of_a_device_that_paused_soon_after_the_first_list_are_confirmed) {
    for (const auto& [interval, silence] : {std::pair<Duration, Duration>{100ms, 2s}, {200ms, 1500ms}, {1s, 4s}, {2s, 6s}}) {
        SimulatedNet own;
        FakeDevice& device = own.add();
        device.commands = fake.commands;
        for (const TimePoint end = own.time + 20s; own.time < end; own.pass(interval))
            own.service.record_telemetry(0xDC, 0x03, own.time);
        own.service.record_telemetry(0xDC, 0x03, own.time);
        own.ask("GET", "/devices/0xDC/commands");
        own.pass(silence);
        own.sent.clear();
        device.name = "CAR";
        device.commands = {{{1, 0, 2}, {}, "FULL_SPEED", ""}};
        static_cast<void>(own.ask("POST", "/devices/0xDC/commands/LAND"));
        ASSERT_FALSE(own.sent.empty());
        EXPECT_EQ(own.sent.front()[3], 0xE0) << interval / 1ms;
        for (const Bytes& one : own.sent) EXPECT_NE(one[3], 0xC0) << interval / 1ms;
    }
}

// Replaced or upgraded before the order, so no earlier data is used.
TEST_F(KnownCommands, called_by_their_bytes_are_sent_to_the_device_that_is_present) {
    stream(2s);
    net.service.link_was_down(0xDC);
    swap_for_a_car();
    net.pass(300ms);
    net.sent.clear();
    const auto said = net.ask("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [1, 0, 2]})");
    EXPECT_EQ(said.status, 200u) << said.json;
    ASSERT_EQ(net.sent.size(), 1u);
    EXPECT_EQ(net.sent[0][3], 0xC0);
    EXPECT_EQ(calls(), 1u);
    net.service.link_was_down(0xDC);
    fake.version = 8;
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", R"({"action": "save"})").status, 200u);
}

TEST_F(KnownCommands, overtake_a_long_job) {
    fake.make_parameters(200);
    net.line.delay = 30ms;
    stream(2s);
    net.service.link_was_down(0xDC);
    const auto list = net.asked("GET", "/devices/0xDC/parameters");
    ASSERT_TRUE(net.until([&] { return fake.heard.size() > 60; }));
    net.sent.clear();
    const auto land = net.asked("POST", "/devices/0xDC/commands/LAND");
    ASSERT_TRUE(net.until([&] { return calls() == 1; }, 3s));
    EXPECT_LE(net.sent.size(), 20u) << "those on their way, the question and the command";
    ASSERT_TRUE(net.until([&] { return land->has_value() && list->has_value(); }));
}

// Another device has the address, and the answer that shows this is lost.
TEST_F(KnownCommands, of_a_device_that_was_absent_are_confirmed_although_requests_are_lost) {
    for (const unsigned lost : {1u, 2u}) {
        net.pass(32s);
        std::swap(fake.commands[0].cid, fake.commands[1].cid);
        fake.version += 1;
        const Bytes land = {1, 0, fake.commands[1].cid[2]};
        unsigned left = lost;
        fake.instead = [&](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
            if (f.id() != 0xC1 || left == 0) return std::nullopt;
            --left;
            return std::vector<Bytes>{};
        };
        const TimePoint begin = net.time;
        ids_of_call();
        EXPECT_EQ(cid_of_call(), land) << lost;
        EXPECT_LE(net.time - begin, 1500ms) << lost;
        fake.instead = {};
    }
}

TEST_F(KnownCommands, of_a_device_that_is_back_and_confirms_none_are_not_sent) {
    net.pass(32s);
    fake.instead = [](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        return f.id() == 0xC1 || f.id() == 0xE0 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    stream(300ms);
    net.sent.clear();
    const auto land = net.asked("POST", "/devices/0xDC/commands/LAND");
    const TimePoint end = net.time + 60s;
    while (!land->has_value() && net.time < end) stream(100ms);
    ASSERT_TRUE(land->has_value());
    EXPECT_EQ((*land)->status, 504u) << (*land)->json;
    EXPECT_EQ(calls(), 0u);
}

TEST_F(KnownCommands, that_are_not_confirmed_in_time_are_sent) {
    fake.instead = [](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        return f.id() == 0xC1 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    for (const auto& [delay, longest] : {std::pair{10ms, 500ms}, {50ms, 600ms}, {110ms, 1s}, {400ms, 1s}}) {
        net.line.delay = delay;
        for (int i = 0; i < 30; ++i) EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 200u);
        for (int i = 0; i < 2; ++i) {    // the second directly after the first
            stream(1s);
            net.service.link_was_down(0xDC);
            stream(300ms);
            const TimePoint begin = net.time;
            Bytes ids = ids_of_call();
            std::erase(ids, std::uint8_t{0xE0});    // its device info is requested as well
            EXPECT_EQ(ids, (Bytes{0xC1, 0xC1, 0xC1, 0xC0}));
            EXPECT_LE(net.time - begin, longest + 2 * delay);
            EXPECT_GE(net.time - begin, 490ms + 2 * delay);
        }
    }
}

TEST_F(KnownCommands, that_an_answer_contradicts_are_not_sent) {
    stream(1s);
    net.service.link_was_down(0xDC);
    stream(300ms);
    fake.commands = {{{1, 0, 1}, {3}, "TAKE_OFF", ""}, {{1, 0, 2}, {}, "FULL_SPEED", ""}};
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/LAND").status, 404u);
    EXPECT_EQ(calls(), 0u);
}

// It receives, but its frames do not arrive any more.
TEST_F(KnownCommands, of_a_device_silent_for_long_are_sent_to_the_link_where_it_was_last_heard) {
    net.pass(31s);
    net.where[0xDC] = {.was_heard = true};
    fake.instead = [](ano::FrameView) { return std::vector<Bytes>{}; };
    net.sent.clear();
    TimePoint begin = net.time;
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/commands?known").json.at("known"), true);
    EXPECT_EQ(net.time, begin) << "anoctl asks so before it calls one";
    const auto land = net.asked("POST", "/devices/0xDC/commands/LAND");
    ASSERT_TRUE(net.until([&] { return calls() == 1; }, 3s));
    EXPECT_LE(net.time - begin, 510ms);
    ASSERT_TRUE(net.until([&] { return land->has_value(); }));
    EXPECT_EQ((*land)->json.at("what"), "unknown") << (*land)->json;

    begin = net.time;
    const auto by_cid = net.asked("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [1, 0, 1], "values": [{"u16": 3}]})");
    ASSERT_TRUE(net.until([&] { return calls() == 2; }, 3s));
    EXPECT_LE(net.time - begin, 510ms) << "it is asked who it is, and does not answer";
    ASSERT_TRUE(net.until([&] { return by_cid->has_value(); }));
    EXPECT_EQ((*by_cid)->status, 504u);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 404u);
}

TEST_F(KnownCommands, of_a_device_that_reports_another_version_are_read_again) {
    fake.commands = {{{7, 7, 7}, {}, "LAND", ""}};
    net.passes(frame(0xDC, 0xFF, 0xE3, {0xDC, 100, 0, 101, 0, 0, 0, 32, 3, 'f', 'a', 'k', 'e'}));
    EXPECT_EQ(ids_of_call()[0], 0xC1);
    EXPECT_EQ(Bytes(net.sent.back().begin() + 6, net.sent.back().end() - 2), (Bytes{7, 7, 7}));
}

// A device that restarted has the same name and versions, and perhaps another list: the bytes of its old list must not be sent.
TEST_F(KnownCommands, of_a_device_that_announces_itself_are_read_again) {
    const Bytes info = frame(0xDC, 0xFF, 0xE3, {0xDC, 100, 0, 100, 0, 0, 0, 32, 3, 'f', 'a', 'k', 'e'});
    net.pass(10s);
    net.passes(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    net.passes(info);
    EXPECT_EQ(ids_of_call(), only_the_call) << "another host asked for it";
    net.pass(10s);
    net.service.sent_by_others(ano::FrameView{frame(0xFE, 0xFF, 0xE0, {0, 0, 0})}, net.time);
    net.passes(info);
    EXPECT_EQ(ids_of_call(), only_the_call) << "a hello asked for it";
    net.pass(10s);
    fake.commands = {{{7, 7, 7}, {}, "LAND", ""}, fake.commands[0]};
    net.passes(info);
    EXPECT_EQ(ids_of_call()[0], 0xC1);
    EXPECT_EQ(Bytes(net.sent.back().begin() + 6, net.sent.back().end() - 2), (Bytes{7, 7, 7}));
}

// Each of the three questions of a scan has one answer, and so has the question of a job.
TEST_F(KnownCommands, of_a_device_that_announces_itself_soon_after_a_scan_are_read_again) {
    const Bytes info = frame(0xDC, 0xFF, 0xE3, {0xDC, 100, 0, 100, 0, 0, 0, 32, 3, 'f', 'a', 'k', 'e'});
    net.pass(10s);
    const auto all = net.asked("POST", "/devices/scan");
    net.pass(2s);
    EXPECT_TRUE(all->has_value());
    EXPECT_EQ(ids_of_call(), only_the_call);
    fake.commands = {{{7, 7, 7}, {}, "LAND", ""}, fake.commands[0]};
    net.passes(info);
    EXPECT_EQ(ids_of_call()[0], 0xC1);
}

TEST_F(KnownCommands, of_a_device_that_reports_another_number_of_them_are_read_again) {
    net.passes(frame(0xDC, 0xFD, 0xC1, {0, 3, 0}));
    EXPECT_EQ(ids_of_call()[0], 0xC1);
}

TEST_F(KnownCommands, are_read_again_after_an_upgrade_by_another_host) {
    net.passes(frame(0xFD, 0xDC, 0xF0, {0, 0x10, 0x01}));
    net.pass(3s);
    EXPECT_EQ(ids_of_call()[0], 0xC1);
}

TEST_F(KnownCommands, whose_number_now_belongs_to_another_command_are_not_called) {
    std::swap(fake.commands[0], fake.commands[1]);
    net.pass(40s);
    const auto [status, error] = net.ask("POST", "/devices/0xDC/commands/0", R"({"name": "TAKE_OFF", "values": [300]})");
    EXPECT_EQ(status, 409u);
    EXPECT_EQ(error.at("error"), "command 0 is not 'TAKE_OFF' any more: read the commands again");
    EXPECT_EQ(error.at("what"), "commands_changed") << "a client may read them and call again by itself";
    EXPECT_EQ(calls(), 0u);
}

TEST_F(KnownCommands, that_lack_a_requested_name_are_read_again) {
    fake.commands.push_back({{1, 0, 3}, {}, "HOVER", ""});
    EXPECT_EQ(ids_of_call("HOVER"), (Bytes{0xC1, 0xC1, 0xC1, 0xC1, 0xC1, 0xC0}));
}

TEST_F(CommandRoutes, are_called_by_their_three_bytes_without_a_prior_request) {
    const auto [status, told] = net.ask("POST", "/devices/0xDC/commands/by-cid",
                                        R"({"cid": [1, 0, 1], "values": [{"u16": 300}]})");
    EXPECT_EQ(status, 200u) << told;
    EXPECT_EQ(told, json::parse(R"({"cid": [1, 0, 1], "called": true})"));
    ASSERT_EQ(net.sent.size(), 1u);
    EXPECT_EQ(Bytes(net.sent[0].begin() + 3, net.sent[0].end() - 2), (Bytes{0xC0, 5, 0, 1, 0, 1, 0x2C, 1}));
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [1, 0, 2]})").status, 200u);
    const auto unknown = net.ask("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [9, 0, 2]})");
    EXPECT_EQ(unknown.json.at("error"), "no answer to command 0x09 0x00 0x02: it may have been carried out") << unknown.json;
    const auto repeated = net.ask("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [9, 0, 2], "repeat": true})");
    EXPECT_EQ(repeated.json.at("error"), "0xDC does not answer: command 0x09 0x00 0x02, sent 5 times") << repeated.json;
    const auto misfit = net.ask("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [9, 0, 2], "values": [{"u8": 300}]})");
    EXPECT_EQ(misfit.json.at("error"), "command 0x09 0x00 0x02: value 1, 300, is out of range for u8") << misfit.json;
}

// An acknowledgement, or none, shows whether it is there.
TEST_F(CommandRoutes, called_by_their_bytes_are_the_first_frame_to_a_device_that_was_never_heard) {
    net.add(0xDD).commands = {{{1, 0, 2}, {}, "LAND", ""}};
    net.where[0xDD] = {};
    net.sent.clear();
    const TimePoint begin = net.time;
    const auto there = net.ask("POST", "/devices/0xDD/commands/by-cid", R"({"cid": [1, 0, 2]})");
    EXPECT_EQ(there.status, 200u) << there.json;
    EXPECT_LE(net.time - begin, 50ms);
    ASSERT_FALSE(net.sent.empty());
    EXPECT_EQ(net.sent[0][3], 0xC0);
    net.sent.clear();
    const auto absent = net.ask("POST", "/devices/0xDE/commands/by-cid", R"({"cid": [1, 0, 2]})");
    EXPECT_EQ(absent.status, 504u) << absent.json;
    EXPECT_EQ(absent.json.at("error"), "no answer to command 0x01 0x00 0x02: it may have been carried out");
    ASSERT_EQ(net.sent.size(), 1u);
    EXPECT_EQ(net.sent[0][3], 0xC0);
}

TEST_F(CommandRoutes, called_by_their_bytes_that_no_link_may_carry_are_refused_at_once) {
    net.refuses[0xC0] = "commands and writes to 0xDE are not sent";
    const TimePoint begin = net.time;
    const auto refused = net.ask("POST", "/devices/0xDE/commands/by-cid", R"({"cid": [1, 0, 2]})");
    EXPECT_EQ(refused.status, 403u) << refused.json;
    EXPECT_EQ(refused.json.at("error"), "commands and writes to 0xDE are not sent");
    EXPECT_LE(net.time - begin, 50ms);
    EXPECT_TRUE(net.sent.empty());
}

TEST_F(CommandRoutes, called_by_their_bytes_need_types_unless_they_were_read) {
    const std::string call = R"({"cid": [1, 0, 1], "values": [300]})";
    const auto [status, error] = net.ask("POST", "/devices/0xDC/commands/by-cid", call);
    EXPECT_EQ(status, 422u);
    EXPECT_EQ(error.at("error"), "each value needs a type, as in {\"u16\": 150}: the command is unknown");
    EXPECT_TRUE(net.sent.empty());
    net.ask("GET", "/devices/0xDC/commands");
    net.sent.clear();
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/by-cid", call).status, 200u);
    EXPECT_EQ(net.sent.size(), 1u);
}

TEST_F(CommandRoutes, with_bad_bytes_or_values_are_never_sent) {
    for (const char* body :
         {"", R"({"cid": [1, 2]})", R"({"cid": [1, 2, 256]})", R"({"cid": [1, 2, -1]})", R"({"cid": "1 2 3"})",
          R"({"cid": [1, 2, 3], "values": 5})", R"({"cid": [1, 2, 3], "name": "LAND"})", R"({"cid": [1, 2, 3], "repeat": 1})"})
        EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/by-cid", body).status, 400u) << body;
    for (const char* values : {R"([{"u16": 70000}])", R"([{"u17": 1}])", R"([{"text": 1}])", R"([{"u8": 1, "i8": 1}])", R"([{}])",
                               R"([{"u8": "x"}])", R"([null])", R"([1,2,3,4,5,6,7,8,9])", R"([{"u8": 1}, 2])"})
        EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [1, 0, 1], "values": )" + std::string{values} + "}")
                      .status,
                  422u)
            << values;
    EXPECT_TRUE(net.sent.empty());
}

// The user learns this at once, not when the command times out.
TEST_F(KnownCommands, to_a_link_that_accepts_nothing_report_this_while_they_wait) {
    fake.deaf = true;
    net.stopped = "the link 'fc' takes nothing";
    const auto land = net.asked("POST", "/devices/0xDC/commands/LAND");
    net.pass(300ms);
    const json job = net.ask("GET", "/jobs").json.at("jobs").back();
    EXPECT_EQ(job.at("stopped"), net.stopped) << job;
    EXPECT_EQ(job.at("message"), "calling LAND; the link 'fc' takes nothing");
    ASSERT_TRUE(net.until([&] { return land->has_value(); }));
    const auto error = (*land)->json.at("error").get<std::string>();
    EXPECT_TRUE(error.ends_with("; the link 'fc' takes nothing")) << error;
    EXPECT_FALSE(net.ask("GET", "/jobs").json.at("jobs").back().contains("stopped"));
}

// Value type 7 on a device whose descriptions do not show its meaning.
struct OpenTypes : CommandRoutes {
    OpenTypes() { fake.commands = {{{1, 0, 7}, {7}, "SEVEN", ""}, {{1, 0, 2}, {}, "LAND", ""}}; }
    SimulatedNet::Answer call(const std::string& more = "") {
        net.sent.clear();
        return net.ask("POST", "/devices/0xDC/commands/SEVEN", R"({"values": [2])" + more + "}");
    }
    Bytes values_sent() const {
        const Bytes& last = net.sent.back();
        EXPECT_EQ(last[3], 0xC0);
        return {last.begin() + 9, last.end() - 2};
    }
    std::string listed() {
        return net.ask("GET", "/devices/0xDC/commands").json.at("commands")[0].at("values")[0].get<std::string>();
    }
    const Bytes as_u64{2, 0, 0, 0, 0, 0, 0, 0}, as_f32{0, 0, 0, 0x40};
};

TEST_F(OpenTypes, are_refused_until_the_user_states_their_meaning) {
    EXPECT_EQ(listed(), "f32|u64");
    const auto [status, error] = call();
    EXPECT_EQ(status, 422u);
    EXPECT_EQ(error.at("what"), "invalid");
    EXPECT_NE(error.at("error").get<std::string>().find("state it once (type7)"), std::string::npos);
    EXPECT_EQ(calls(), 0u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/LAND").status, 200u) << "it has no such value";
    EXPECT_EQ(call(R"(, "type7": "u16")").status, 400u);
    EXPECT_EQ(call(R"(, "type7": "u64")").status, 200u);
    EXPECT_EQ(values_sent(), as_u64);
    EXPECT_EQ(call().status, 200u) << "it is kept";
    EXPECT_EQ(net.sent.size(), 1u);
    EXPECT_EQ(values_sent(), as_u64);
    EXPECT_EQ(listed(), "u64");
    const auto other = call(R"(, "type7": "f32")");
    EXPECT_EQ(other.status, 200u);
    EXPECT_EQ(other.json.value("note", ""), "value type 7 of this device is f32 from now on; it was stored as u64");
    EXPECT_EQ(values_sent(), as_f32);
    EXPECT_FALSE(call(R"(, "type7": "f32")").json.contains("note"));
}

// The next call may be made before the note is on disk, and the disk may be full.
TEST_F(OpenTypes, use_a_stated_meaning_from_that_call_on) {
    for (const bool is_slow : {true, false}) {
        net.is_disk_slow = is_slow;
        net.keep_fault = "no space left";
        const char* const seven = is_slow ? "u64" : "f32";
        EXPECT_EQ(call(R"(, "type7": ")" + std::string{seven} + "\"").status, 200u);
        EXPECT_EQ(call().status, 200u) << seven;
        EXPECT_EQ(values_sent(), is_slow ? as_u64 : as_f32);
    }
}

TEST_F(OpenTypes, keep_their_meaning_after_a_restart_and_only_for_this_device) {
    ASSERT_EQ(net.kept.size(), 0u);
    call(R"(, "type7": "u64")");
    ASSERT_EQ(net.kept.size(), 1u);
    const auto [name, text] = *net.kept.begin();
    EXPECT_TRUE(name.starts_with("type7-0xDC-")) << name;
    EXPECT_TRUE(anogate::is_note(name));
    EXPECT_FALSE(net.ask("GET", "/devices").json.at("devices")[0].contains("kept")) << "it is no unfinished work";

    struct Other {
        const char* what;
        std::function<void(SimulatedNet&)> becomes;
    };
    for (const Other& other : {Other{"", [](SimulatedNet&) {}},
                               {"name", [](SimulatedNet& to) { to.fakes[0]->name = "another"; }},
                               {"version", [](SimulatedNet& to) { ++to.fakes[0]->version; }},
                               {"gateway", [](SimulatedNet& to) { to.unit.gateway = "/run/other.sock"; }},
                               {"link", [](SimulatedNet& to) { to.unit.link = "radio"; }},
                               {"wire", [](SimulatedNet& to) { to.unit.wire = "serial:/dev/other"; }}}) {
        SCOPED_TRACE(other.what);
        SimulatedNet again;
        again.add().commands = fake.commands;
        other.becomes(again);
        EXPECT_TRUE(again.service.remember(name, text));
        const bool is_same = *other.what == '\0';
        EXPECT_EQ(again.ask("POST", "/devices/0xDC/commands/SEVEN", R"({"values": [2]})").status, is_same ? 200u : 422u);
    }
}

TEST_F(OpenTypes, have_the_meaning_that_is_set_on_the_link) {
    net.link_limits.value_type_7 = ano::ValueType7::f32;
    EXPECT_EQ(call().status, 200u);
    EXPECT_EQ(values_sent(), as_f32);
    const auto [status, error] = call(R"(, "type7": "u64")");
    EXPECT_EQ(status, 422u);
    EXPECT_EQ(error.at("error"), "value type 7 is f32 on this link (value_type_7 or profile): change it there");
    EXPECT_EQ(calls(), 1u);
}

TEST_F(OpenTypes, have_the_meaning_that_the_device_shows) {
    fake.commands.push_back({{1, 0, 9}, {9}, "NINE", ""});
    EXPECT_EQ(listed(), "u64");
    EXPECT_EQ(call().status, 200u);
    EXPECT_EQ(values_sent(), as_u64);
    EXPECT_EQ(call(R"(, "type7": "u64")").status, 200u);
    const std::size_t before = calls();
    const auto [status, error] = call(R"(, "type7": "f32")");
    EXPECT_EQ(status, 422u) << "it is not taken silently";
    EXPECT_NE(error.at("error").get<std::string>().find("is u64, as its descriptions show, not f32"), std::string::npos) << error;
    EXPECT_EQ(calls(), before);
}

TEST_F(OpenTypes, by_cid_need_no_meaning_where_a_type_is_given) {
    const auto by_cid = [&](const char* value) {
        net.sent.clear();
        return net.ask("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [1, 0, 7], "values": [)" + std::string{value} + "]}")
            .status;
    };
    EXPECT_EQ(by_cid(R"({"u64": 2})"), 200u);
    EXPECT_EQ(values_sent(), as_u64);
    listed();
    EXPECT_EQ(by_cid("2"), 422u);
    EXPECT_EQ(by_cid(R"({"f32": 2})"), 200u);
    EXPECT_EQ(values_sent(), as_f32);
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

TEST_F(CommandRoutes, an_acknowledgement_that_may_be_of_an_earlier_call_is_no_success) {
    fake.instead = [](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        return f.id() == 0xC0 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/LAND").status, 504u);
    fake.instead = nullptr;
    const auto [status, error] = net.ask("POST", "/devices/0xDC/commands/LAND");
    EXPECT_EQ(status, 504u) << error;
    EXPECT_EQ(error.at("what"), "unknown");
    EXPECT_EQ(error.at("error"),
              "0xDC acknowledged LAND, which was sent more than once: the acknowledgement does not show which of "
              "them was carried out");
    EXPECT_EQ(error.at("evidence").at("ambiguous"), true);
    net.pass(4s);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/LAND").status, 200u) << "no other one waits";
}

// The user presses LAND while another request to the device is not answered.
TEST_F(KnownCommands, are_called_at_once_while_another_one_is_not_answered) {
    fake.instead = [](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        const bool is_take_off = f.id() == 0xC0 && f.data()[2] == 1;
        return is_take_off ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    const auto waits = net.asked("POST", "/devices/0xDC/commands/TAKE_OFF", R"({"values": [300]})");
    net.pass(300ms);
    ASSERT_FALSE(waits->has_value());
    const TimePoint pressed = net.time;
    EXPECT_EQ(ids_of_call("LAND"), only_the_call);
    EXPECT_LE(net.time - pressed, 50ms);
    EXPECT_FALSE(waits->has_value());
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/0", R"({"value": 1})").status, 409u) << "writes wait for their turn";
    net.pass(3s);
    ASSERT_TRUE(waits->has_value());
    EXPECT_EQ((*waits)->json.at("what"), "unknown");
}

TEST_F(KnownCommands, refused_by_the_rules_do_not_end_other_work) {
    fake.make_parameters(3);
    net.ask("GET", "/devices/0xDC/parameters");
    fake.instead = [](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        return f.id() == 0xE0 && f.data()[0] == 0x10 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
    };
    const auto saving = net.asked("POST", "/devices/0xDC/actions", R"({"action": "save"})");
    net.pass(300ms);
    net.refuses[0xC0] = "the rules do not let this pass";
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/LAND").status, 403u);
    EXPECT_FALSE(saving->has_value());
    fake.instead = nullptr;
    net.pass(20s);
    ASSERT_TRUE(saving->has_value());
    EXPECT_EQ((*saving)->status, 200u);
}

TEST_F(CommandRoutes, actions_are_acknowledged) {
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", R"({"action": "save"})").json,
              json::parse(R"({"action": "save", "done": true})"));
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", R"({"action": "explode"})").status, 400u);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", "{}").status, 400u);
}

// The service first listens long enough to learn whether the device flies.
// Telemetry paused and returned: the gateway asks for the device info too.
TEST_F(CommandRoutes, are_sent_within_600_ms_to_a_device_that_no_longer_answers_info_requests) {
    net.flush_takes = 27ms;
    net.ask("GET", "/devices/0xDC/parameters");
    net.ask("GET", "/devices/0xDC/commands");
    const auto telemetry = [&](int count) {
        for (int i = 0; i < count; ++i) {
            net.pass(50ms);
            net.passes(frame(0xDC, 0xFF, 0x03, {0, 0, 0, 0, 0, 0, 0}));
        }
    };
    for (const bool is_by_cid : {false, true}) {
        SCOPED_TRACE(is_by_cid);
        fake.instead = nullptr;
        net.ask("POST", "/devices/0xDC/commands/LAND");
        telemetry(100);
        fake.instead = [](ano::FrameView f) {
            return f.id() == 0xE0 && f.data()[0] == 0 ? std::optional{std::vector<Bytes>{}} : std::nullopt;
        };
        net.pass(800ms);
        telemetry(6);
        const std::size_t before = calls();
        const TimePoint asked_at = net.now();
        const auto land = is_by_cid ? net.asked("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [1, 0, 2]})")
                                    : net.asked("POST", "/devices/0xDC/commands/LAND");
        while (calls() == before && net.now() - asked_at < 3s) telemetry(1);
        EXPECT_LE(net.now() - asked_at, is_by_cid ? 100ms : 650ms);    // a question may be in flight
    }
}

TEST_F(CommandRoutes, do_not_wait_for_other_jobs) {
    net.ask("GET", "/devices/0xDC/commands");
    for (const std::string action : {"restore_defaults", "save"}) {
        const auto job = net.asked("POST", "/devices/0xDC/actions", R"({"action": ")" + action + R"("})");
        EXPECT_FALSE(job->has_value()) << action;
        EXPECT_EQ(net.ask("POST", "/devices/0xDC/commands/LAND").status, 200u) << action;
        ASSERT_TRUE(net.until([&] { return job->has_value(); })) << action;
        EXPECT_EQ((*job)->status, 200u) << action;
    }
}

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
              "several devices have the address 0xDC (seen on fc and radio): it is unclear which one is meant; when only one is "
              "left, run anoctl routes --forget 0xDC");
    net.where[0xDC] = {.is_known = true, .on_several_channels = true};
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions?force", restore).status, 409u);
}

}    // namespace
}    // namespace commands_tests
