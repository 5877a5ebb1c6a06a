// The frames of a gateway as hosts receive them: bytes computed by hand from the protocol text.
#include <gtest/gtest.h>
#include <managed/gateway_device.hpp>

#include <support/bytes.hpp>

#include <chrono>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gateway_device_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;
using support::hex;

constexpr std::uint8_t host = 0xFE, self = 21, everybody = 0xFF;
constexpr ano::TimePoint start{1000s};
constexpr std::uint16_t forget_after = 1, en_fc = 3, en_ground = 5;

class FakeOperations final : public GatewayOperations {
public:
    void apply(const WrittenValues& written) override { applied.push_back(written); }
    std::string save(const WrittenValues& written) override { return saved.push_back(written), refusal; }
    std::string reload() override { return done("reload"); }
    std::string restart(const std::string& link) override { return done("restart " + link); }
    std::string scan() override { return done("scan"); }
    std::string pulse(std::size_t line) override { return done("pulse " + std::to_string(line)); }
    std::string start_recording() override { return done("start recording"); }
    std::string stop_recording() override { return done("stop recording"); }
    std::vector<LinkSummary> summaries() override {
        return {{LinkSummary::State::up, 0x0102030405, 2, 3}, {LinkSummary::State::waiting, 0, 0, 0}};
    }
    void refuse_ourselves(const std::string& why) override { refused.push_back(why); }
    void warn(const std::string& line) override { warnings.push_back(line); }

    std::vector<WrittenValues> applied, saved;
    std::vector<std::string> did, refused, warnings;
    std::string refusal;

private:
    std::string done(std::string what) { return did.push_back(std::move(what)), refusal; }
};

LinkSettings link(const std::string& name) {
    LinkSettings one;
    one.name = name;
    return one;
}

Bytes text(std::string_view words, std::size_t size = 0) {
    Bytes bytes(words.begin(), words.end());
    bytes.resize(std::max(size, bytes.size()));
    return bytes;
}

class GatewayAsDevice : public testing::Test {
protected:
    GatewayAsDevice() {
        file.gateway.id = self;
        file.gateway.name = "vehicle";
        file.links = {link("fc"), link("ground")};
        device.configure(file, {});
    }
    std::vector<Bytes> heard() {
        std::vector<Bytes> frames;
        while (const auto out = device.next()) {
            frames.emplace_back(out->frame.bytes().begin(), out->frame.bytes().end());
            last_link = out->link;
        }
        return frames;
    }
    std::vector<Bytes> answers(const Bytes& question, const GatewayDevice::Asker& asker, ano::TimePoint now = start) {
        device.take(ano::FrameView{question}, asker, now);
        return heard();
    }
    /// The single answer to a question on the link `fc`, which may manage.
    Bytes answer(const Bytes& question, ano::TimePoint now = start) {
        const auto all = answers(question, manager, now);
        return all.size() == 1 ? all.front() : Bytes{};
    }
    static Bytes ask(std::uint8_t id, const Bytes& data, std::uint8_t from = host) { return frame(from, self, id, data); }
    static Bytes write(std::uint16_t id, const Bytes& value) {
        Bytes data{static_cast<std::uint8_t>(id), static_cast<std::uint8_t>(id >> 8)};
        data.insert(data.end(), value.begin(), value.end());
        return ask(0xE1, data);
    }
    static Bytes says(std::uint8_t id, const Bytes& data) { return frame(self, host, id, data); }
    static Bytes acknowledges(const Bytes& question) {
        return frame(self, question[1], 0x00, {question[3], question[question.size() - 2], question.back()});
    }
    double value(std::size_t id) const { return device.values().at(id).value; }

    Settings file;
    FakeOperations operations;
    GatewayDevice device{operations};
    GatewayDevice::Asker manager{7, "fc", true, false}, stranger{8, "ground", false, false};
    GatewayDevice::Link last_link = 0;
};

TEST_F(GatewayAsDevice, reports_its_device_information_to_a_host_that_follows_the_protocol_text) {
    // AB, from 254 to 21, 0xE0, LEN 3: cmd 0, val 0; and 0xE3: dev_id 21, hw 100, sw 100, bl 0, pt 800, the name.
    EXPECT_EQ(answer(hex("AB FE 15 E0 03 00 00 00 00 A1 D5")),
              hex("AB 15 FE E3 10 00 15 64 00 64 00 00 00 20 03 76 65 68 69 63 6C 65 "
                  "91 5E"));
    EXPECT_EQ(last_link, 7u) << "by the link that asked";
    EXPECT_EQ(answer(hex("AB FE FF E0 03 00 00 00 00 8B 3B")).size(), 24u) << "everybody is asked";
}

TEST_F(GatewayAsDevice, reports_count_descriptions_and_values_of_its_parameters) {
    EXPECT_EQ(answer(ask(0xE0, {1, 0, 0})), says(0xE0, {1, 7, 0}));
    EXPECT_EQ(answer(ask(0xE0, {2, 0, 0})), says(0xE1, {0, 0, 2}));
    EXPECT_EQ(answer(ask(0xE0, {2, 1, 0})), says(0xE1, {1, 0, 0x30, 0x75, 0, 0}));
    Bytes described{3, 0, 0};
    for (const Bytes& part : {text("EN_fc", 20), text("the link fc: 1 enabled, 0 disabled")})
        described.insert(described.end(), part.begin(), part.end());
    EXPECT_EQ(answer(ask(0xE0, {3, 3, 0})), says(0xE2, described));
    EXPECT_TRUE(answer(ask(0xE0, {2, 7, 0})).empty()) << "there are seven";
}

TEST_F(GatewayAsDevice, stores_written_values_within_their_limits) {
    const Bytes question = write(forget_after, {0x88, 0x13, 0, 0});
    EXPECT_EQ(answer(question), acknowledges(question));
    EXPECT_EQ(value(forget_after), 5000);
    ASSERT_EQ(operations.applied.size(), 1u);
    EXPECT_EQ(operations.applied[0].applied(file).gateway.forget_after, 5s);
    answer(write(forget_after, {1, 0, 0, 0}));
    EXPECT_EQ(answer(ask(0xE0, {2, 1, 0})), says(0xE1, {1, 0, 0xE8, 3, 0, 0})) << "at least a second";
    answer(write(forget_after, {0xE8, 3, 0, 0}));
    EXPECT_EQ(operations.applied.size(), 2u) << "what holds already changes nothing";
}

TEST_F(GatewayAsDevice, answers_requests_on_every_link_but_acts_only_on_links_that_may_manage) {
    EXPECT_EQ(answers(ask(0xE0, {1, 0, 0}), stranger).size(), 1u);
    EXPECT_EQ(answers(ask(0xC1, {0, 0, 0}), stranger).size(), 1u);
    std::uint64_t refused = 0;
    for (const Bytes& act : {write(forget_after, {0x88, 0x13, 0, 0}), ask(0xC0, {1, 0, 1}), ask(0xE0, {0x10, 0xAB, 0}),
                             ask(0xE0, {0x10, 0xAA, 0}), ask(0xE0, {0x77, 0, 0})}) {
        for (const Bytes& said : answers(act, stranger)) EXPECT_EQ(said[3], 0xA0) << "a line of words at most";
        EXPECT_EQ(device.counters().not_managed, ++refused);
    }
    EXPECT_EQ(value(forget_after), 30'000);
    EXPECT_TRUE(operations.applied.empty() && operations.did.empty() && operations.saved.empty());
}

TEST_F(GatewayAsDevice, reports_to_a_host_why_it_refuses_but_not_each_time) {
    const auto first = answers(ask(0xC0, {1, 0, 1}), stranger);
    ASSERT_EQ(first.size(), 1u);
    EXPECT_EQ(
        first[0], says(0xA0, [] {
            Bytes data{1};
            const Bytes words = text("refused a request of 0xFE to the gateway: received on ground, which has no manage=yes");
            data.insert(data.end(), words.begin(), words.end());
            return data;
        }()));
    EXPECT_TRUE(answers(ask(0xC0, {1, 0, 1}), stranger, start + 4s).empty());
    EXPECT_EQ(operations.warnings.size(), 1u);
    EXPECT_EQ(answers(ask(0xC0, {1, 0, 1}), stranger, start + 5s).size(), 1u);
    EXPECT_TRUE(operations.warnings.back().ends_with("(1 more since the last)")) << operations.warnings.back();
    EXPECT_TRUE(answers(ask(0xC0, {1, 0, 1}, 0x21), stranger, start + 20s).empty()) << "a device does not read";
}

TEST_F(GatewayAsDevice, ignores_broadcast_actions) {
    EXPECT_TRUE(answer(frame(host, everybody, 0xE1, {3, 0, 0})).empty());
    EXPECT_TRUE(answer(frame(host, everybody, 0xE0, {0x10, 0xAA, 0})).empty());
    EXPECT_EQ(device.counters().to_everybody, 2u);
    EXPECT_TRUE(operations.applied.empty());
}

TEST_F(GatewayAsDevice, does_not_let_a_writer_close_the_link_it_uses) {
    const auto said = answers(write(en_fc, {0}), manager);
    ASSERT_EQ(said.size(), 1u);
    EXPECT_EQ(said[0][3], 0xA0) << "no acknowledgement";
    EXPECT_EQ(value(en_fc), 1);
    EXPECT_EQ(device.counters().would_lock_out, 1u);
    const Bytes other = write(en_ground, {0});
    EXPECT_EQ(answer(other), acknowledges(other));
    EXPECT_EQ(value(en_ground), 0);
}

TEST_F(GatewayAsDevice, does_not_let_two_hosts_close_each_others_links) {
    const GatewayDevice::Asker ground{8, "ground", true, false};
    const Bytes close_ground = write(en_ground, {0}), close_fc = write(en_fc, {0}), open_ground = write(en_ground, {1});
    EXPECT_EQ(answer(close_ground), acknowledges(close_ground));
    const auto said = answers(close_fc, ground);    // sent before its link was closed
    ASSERT_EQ(said.size(), 1u);
    EXPECT_EQ(said[0][3], 0xA0);
    EXPECT_EQ(value(en_fc), 1);
    EXPECT_EQ(answers(open_ground, ground), std::vector<Bytes>{acknowledges(open_ground)});
}

TEST_F(GatewayAsDevice, does_not_restore_a_value_that_would_close_the_link_of_the_request) {
    file.links[0].enabled = false;    // and a parameter opened it
    device.configure(file, {});
    answers(write(en_fc, {1}), {9, "control", true, true});
    ASSERT_EQ(value(en_fc), 1);
    const auto said = answers(ask(0xE0, {0x10, 0xAA, 0}), manager);
    ASSERT_EQ(said.size(), 1u);
    EXPECT_EQ(said[0][3], 0xA0);
    EXPECT_EQ(value(en_fc), 1);
    const Bytes restore = ask(0xE0, {0x10, 0xAA, 0});
    EXPECT_EQ(answers(restore, {9, "control", true, true}), std::vector<Bytes>{acknowledges(restore)});
    EXPECT_EQ(value(en_fc), 0) << "who comes by another way may";
}

TEST_F(GatewayAsDevice, reports_to_the_control_interface_why_it_refuses) {
    answers(ask(0xC0, {1, 0, 3, 77}), manager);
    EXPECT_TRUE(operations.refused.empty()) << "a link hears it by a line";
    for (int i = 0; i < 2; ++i) answers(ask(0xC0, {1, 0, 3, 77}), {9, "control", true, true});
    EXPECT_EQ(operations.refused,
              (std::vector<std::string>{"RESTART_LINK: there is no link 77", "RESTART_LINK: there is no link 77"}));
}

TEST_F(GatewayAsDevice, acknowledges_a_save_when_it_is_on_the_disk) {
    answer(write(forget_after, {0x88, 0x13, 0, 0}));
    const Bytes save = ask(0xE0, {0x10, 0xAB, 0});
    EXPECT_TRUE(answers(save, manager).empty());
    ASSERT_EQ(operations.saved.size(), 1u);
    EXPECT_EQ(operations.saved[0].applied(file).gateway.forget_after, 5s);
    device.saved("", start + 20ms);
    EXPECT_EQ(heard(), std::vector<Bytes>{acknowledges(save)});
    EXPECT_EQ(last_link, 7u);
    answers(save, manager);
    device.saved("the disk is full", start + 30ms);
    const auto said = heard();
    ASSERT_EQ(said.size(), 1u);
    EXPECT_EQ(said[0][3], 0xA0);
    answers(save, manager);
    device.forget(7);
    device.saved("", start + 1s);
    EXPECT_TRUE(heard().empty()) << "who asked is gone";
}

TEST_F(GatewayAsDevice, describes_and_executes_its_commands) {
    EXPECT_EQ(answer(ask(0xC1, {0, 0, 0})), says(0xC1, {0, 6, 0}));
    Bytes described{2, 0, 1, 0, 3, 1, 0, 0, 0, 0, 0, 0, 0};
    for (const Bytes& part : {text("RESTART_LINK", 20), text("the number of the link: 0 fc 1 ground")})
        described.insert(described.end(), part.begin(), part.end());
    EXPECT_EQ(answer(ask(0xC1, {1, 2, 0})), says(0xC2, described));
    for (const Bytes& command :
         {ask(0xC0, {1, 0, 1}), ask(0xC0, {1, 0, 2}), ask(0xC0, {1, 0, 3, 1}), ask(0xC0, {1, 0, 6}), ask(0xC0, {1, 0, 7})})
        EXPECT_EQ(answer(command), acknowledges(command));
    EXPECT_EQ(operations.did,
              (std::vector<std::string>{"reload", "scan", "restart ground", "start recording", "stop recording"}));
    for (const Bytes& said : answers(ask(0xC0, {1, 0, 3, 2}), manager)) EXPECT_EQ(said[3], 0xA0);
    EXPECT_EQ(device.counters().refused, 1u) << "there is no link 2";
    EXPECT_TRUE(answer(ask(0xC0, {9, 9, 9})).empty());
}

TEST_F(GatewayAsDevice, pulses_the_lines_that_allow_it) {
    GpioSettings lamp, reset;
    lamp.use = GpioUse::link_up;
    reset.use = GpioUse::reset;
    reset.link = "fc";
    file.gpio = {lamp, reset};
    device.configure(file, {});
    EXPECT_EQ(answer(ask(0xC1, {0, 0, 0})), says(0xC1, {0, 7, 0}));
    const Bytes command = ask(0xC0, {1, 0, 5, 0});
    EXPECT_EQ(answer(command), acknowledges(command));
    EXPECT_EQ(operations.did, std::vector<std::string>{"pulse 0"});
    operations.refusal = "it was reset less than a minute ago";
    for (const Bytes& said : answers(command, manager)) EXPECT_EQ(said[3], 0xA0) << "not acknowledged";
}

TEST_F(GatewayAsDevice, sends_link_summaries_once_a_second_until_they_are_switched_off) {
    const Bytes begin = ask(0xC0, {1, 0, 4, 2});
    EXPECT_EQ(answer(begin), acknowledges(begin));
    ASSERT_EQ(device.due(), start);
    device.run(start);
    EXPECT_EQ(heard(), (std::vector<Bytes>{says(0xF2, {0, 2, 5, 4, 3, 2, 2, 0, 0, 0, 3, 0, 0, 0}),
                                           says(0xF2, {1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0})}));
    EXPECT_EQ(device.due(), start + 1s);
    device.run(start + 10s);
    EXPECT_EQ(heard().size(), 2u) << "what was missed is not made up for";
    EXPECT_EQ(device.due(), start + 10s);
    device.run(start + 10s);
    heard();
    answer(ask(0xC0, {1, 0, 4, 0}));
    EXPECT_EQ(device.due(), std::nullopt);
    answer(begin);
    device.forget(7);
    EXPECT_EQ(device.due(), std::nullopt) << "who listened is gone";
}

TEST_F(GatewayAsDevice, sends_events_to_hosts_in_a_limited_number_of_lines) {
    for (int i = 0; i < 15; ++i) device.log("fc: up", GatewayDevice::LogColor::green, start + i * 1ms);
    const auto lines = heard();
    ASSERT_EQ(lines.size(), 10u);
    EXPECT_EQ(lines[0], says(0xA0, hex("02 66 63 3A 20 75 70")));
    EXPECT_EQ(last_link, ano::device::every_link);
    ASSERT_EQ(device.due(), start + 5s);
    device.run(start + 5s);
    const auto rest = heard();
    ASSERT_EQ(rest.size(), 1u);
    EXPECT_EQ(rest[0][3], 0xA1);
    EXPECT_EQ(Bytes(rest[0].begin() + 6, rest[0].begin() + 10), hex("00 00 A0 40")) << "5, as f32";
    EXPECT_EQ(device.counters().lines_left_out, 5u);
}

TEST_F(GatewayAsDevice, does_not_exist_without_an_id_or_with_the_id_of_hosts) {
    for (const int id : {0, 0xFE, 0xD2}) {
        file.gateway.id = static_cast<std::uint8_t>(id);
        device.configure(file, {});
        EXPECT_FALSE(device.is_there());
        EXPECT_TRUE(answer(frame(host, everybody, 0xE0, {0, 0, 0})).empty());
        device.log("fc: up", GatewayDevice::LogColor::green, start);
        EXPECT_TRUE(heard().empty());
    }
}

TEST_F(GatewayAsDevice, keeps_written_values_when_its_links_change) {
    answer(write(forget_after, {0x88, 0x13, 0, 0}));
    file.links.push_back(link("radio"));
    device.configure(file, device.written());
    EXPECT_EQ(answer(ask(0xE0, {1, 0, 0})), says(0xE0, {1, 9, 0}));
    EXPECT_EQ(value(forget_after), 5000);
}

TEST_F(GatewayAsDevice, accepts_writes_on_a_link_that_the_configuration_closes_anyway) {
    file.links[0].enabled = false;
    device.configure(file, {});
    const Bytes question = write(forget_after, {0x88, 0x13, 0, 0});
    EXPECT_EQ(answer(question), acknowledges(question));
}

TEST_F(GatewayAsDevice, loses_no_response_when_a_new_configuration_does_not_change_it) {
    const Bytes question = ask(0xE0, {1, 0, 0});
    device.take(ano::FrameView{question}, manager, start);
    file.gateway.forget_after = 60s;
    device.configure(file, {});
    EXPECT_EQ(heard(), std::vector<Bytes>{says(0xE0, {1, 7, 0})});
    EXPECT_EQ(value(forget_after), 60'000);
}

// Each receives all frames of the other; the first frame is a question with the address of the other.
TEST_F(GatewayAsDevice, does_not_exchange_frames_with_another_gateway_endlessly) {
    for (const std::uint8_t other_id : {std::uint8_t{22}, self}) {
        Settings others = file;
        others.gateway.id = other_id;
        FakeOperations its_operations;
        GatewayDevice other{its_operations};
        other.configure(others, {});
        const GatewayDevice::Asker from_here{1, "way", true, false};
        for (const std::uint8_t to : {self, everybody})
            for (const Bytes& data : std::vector<Bytes>{{0, 0, 0}, {1, 0, 0}, {2, 1, 0}, {3, 1, 0}, {0x10, 0xAA, 0}})
                for (const std::uint8_t id : Bytes{0xE0, 0xC1}) {
                    std::vector<Bytes> on_the_way{frame(other_id, to, id, data)};
                    std::size_t said = 0;
                    while (!on_the_way.empty() && said < 10) {
                        const Bytes next = on_the_way.back();
                        on_the_way.pop_back();
                        for (GatewayDevice* one : {&device, &other}) {
                            if (next[1] == (one == &device ? self : other_id)) continue;
                            if (next[2] != everybody && next[2] != (one == &device ? self : other_id)) continue;
                            one->take(ano::FrameView{next}, from_here, start);
                            while (const auto out = one->next()) {
                                on_the_way.emplace_back(out->frame.bytes().begin(), out->frame.bytes().end());
                                ++said;
                            }
                        }
                    }
                    EXPECT_LE(said, 2u) << int{to} << ' ' << int{id} << ' ' << int{data[0]};
                }
        EXPECT_EQ(operations.applied.size() + its_operations.applied.size(), 0u);
    }
}

}    // namespace
}    // namespace gateway_device_tests
