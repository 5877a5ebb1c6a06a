// The parameter protocol, with a device that answers when the test lets it.
#include <mavlink/parameter_server.hpp>

#include <gtest/gtest.h>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <cmath>
#include <set>

namespace mavlink_parameters_tests {
namespace {

using namespace anogate::mavlink;
using ano::Type;
using support::Bytes;

template <class D>
Bytes packet_of(const D& draft, Origin from = {255, 190}) {
    Bytes bytes(max_packet);
    bytes.resize(encode(bytes, Version::v2, from, 0, draft.row, draft.payload()));
    return bytes;
}

TEST(ShortNames, are_stable_and_without_collisions) {
    const std::vector<std::string> names{"SHORT", "EXACTLY_16_CHARS", "CALIBRATION_OFFSET_X", "CALIBRATION_OFFSET_Y"};
    const auto ids = short_names(names);
    EXPECT_EQ(ids[0], names[0]);
    EXPECT_EQ(ids[1], names[1]);
    EXPECT_EQ(ids[2].size(), 16u);
    EXPECT_EQ(ids[2].substr(0, 12), "CALIBRATION~");
    EXPECT_NE(ids[2], ids[3]);
    EXPECT_EQ(short_names(std::vector<std::string>{"ANOTHER", names[3], names[2]})[1], ids[3]);
    std::vector<std::string> many;
    for (int i = 0; i < 20'000; ++i) many.push_back("THE_SAME_BEGINNING_" + std::to_string(i));
    const auto all = short_names(many);
    EXPECT_EQ(std::set(all.begin(), all.end()).size(), many.size());
}

TEST(Bytewise, carries_every_type_of_32_bits_or_less) {
    for (const auto& [type, value] :
         {std::pair{Type::u8, std::int64_t{200}}, std::pair{Type::i8, std::int64_t{-100}},
          std::pair{Type::u16, std::int64_t{65'535}}, std::pair{Type::i16, std::int64_t{-32'768}},
          std::pair{Type::u32, std::int64_t{4'294'967'295}}, std::pair{Type::i32, std::int64_t{-1}}}) {
        const auto bytes = bytewise(type, value);
        ASSERT_TRUE(bytes);
        EXPECT_EQ(value_of(type, *bytes), ano::Number{value});
    }
    EXPECT_EQ(value_of(Type::f32, *bytewise(Type::f32, 1.5)), ano::Number{1.5});
    EXPECT_FALSE(bytewise(Type::f64, 1.5));
    EXPECT_FALSE(bytewise(Type::u64, std::int64_t{1}));
    EXPECT_FALSE(bytewise(Type::u8, std::int64_t{256}));
}

class Parameters : public testing::Test {
protected:
    void receive(const Bytes& packet) { server.receive(PacketView{packet}); }
    void ask_list(Origin from = {255, 190}) { receive(packet_of(Draft<"PARAM_REQUEST_LIST">{}, from)); }
    void ask(int index, Origin from = {255, 190}) {
        Draft<"PARAM_REQUEST_READ"> draft;
        receive(packet_of(draft.set<"param_index">(index), from));
    }
    void set(const char* id, std::uint8_t type, float value) {
        Draft<"PARAM_SET"> draft;
        receive(packet_of(draft.set_text<"param_id">(id).set<"param_type">(type).set<"param_value">(value)));
    }
    std::vector<View<"PARAM_VALUE">> all(Origin from = {255, 190}) {
        std::vector<View<"PARAM_VALUE">> values;
        while (const auto payload = server.next(from)) values.emplace_back(payload->payload());
        return values;
    }

    std::vector<DeviceParameter> device{{"SIM_MODE", Type::u8, std::int64_t{2}},
                                        {"SIM_NOTE", Type::text, std::nullopt},
                                        {"SIM_WIND", Type::f32, 1.25},
                                        {"SIM_BORN", Type::i64, std::int64_t{5}},
                                        {"A_NAME_OF_20_LETTERS", Type::i16, std::int64_t{-7}}};
    int reads = 0;
    std::vector<std::pair<std::string, ano::Number>> writes;
    std::vector<std::string> reports;
    std::vector<View<"PARAM_VALUE">> sent_to_all;
    std::optional<ano::Number> stored = std::int64_t{3};
    std::string error;
    ParameterServer server{{[this](const auto& done) {
                                ++reads;
                                done(device, error);
                            },
                            [this](const std::string& name, const ano::Number& value, const auto& done) {
                                writes.emplace_back(name, value);
                                done(stored, error);
                            },
                            [this](Severity, const std::string& text) { reports.push_back(text); },
                            [this](const Payload& payload) { sent_to_all.emplace_back(payload.payload()); }}};
};

TEST_F(Parameters, lists_what_mavlink_can_carry_and_reports_the_rest_once) {
    for (int i = 0; i < 2; ++i) {
        ask_list();
        const auto values = all();
        ASSERT_EQ(values.size(), 3u);
        EXPECT_EQ(values[0].get<"param_id">(), "SIM_MODE");
        EXPECT_EQ(values[0].get<"param_type">(), 1);
        EXPECT_EQ(values[0].get<"param_count">(), 3);
        EXPECT_EQ(values[1].get<"param_id">(), "SIM_WIND");
        EXPECT_EQ(values[1].get<"param_value">(), 1.25F);
        EXPECT_EQ(values[2].get<"param_index">(), 2);
        EXPECT_EQ(values[2].get<"param_id">().size(), 16u);
    }
    EXPECT_EQ(reports, std::vector<std::string>{"not shown, because MAVLink can't carry them: SIM_NOTE, SIM_BORN"});
}

TEST_F(Parameters, sends_single_values_by_number_and_by_name) {
    ask(1);
    EXPECT_TRUE(all().empty());    // it is being read: the station asks again
    ask(1);
    ask(1);
    ASSERT_EQ(all().size(), 1u);
    Draft<"PARAM_REQUEST_READ"> by_name;
    receive(packet_of(by_name.set<"param_index">(-1).set_text<"param_id">("SIM_WIND")));
    EXPECT_EQ(all().at(0).get<"param_index">(), 1);
    ask(77);
    EXPECT_FALSE(server.waits({255, 190}));
}

TEST_F(Parameters, writes_and_sends_what_the_device_stored) {
    ask_list();
    all();
    set("SIM_MODE", 1, *bytewise(Type::u8, std::int64_t{9}));
    EXPECT_EQ(writes, (std::vector<std::pair<std::string, ano::Number>>{{"SIM_MODE", std::int64_t{9}}}));
    ASSERT_EQ(sent_to_all.size(), 1u);
    EXPECT_EQ(value_of(Type::u8, sent_to_all[0].get<"param_value">()), ano::Number{std::int64_t{3}});
    set("A_NAME_OF_2", 1, 0);
    EXPECT_EQ(writes.size(), 1u);
}

TEST_F(Parameters, a_value_that_was_not_written_is_reported_and_the_old_one_sent) {
    ask_list();
    all();
    stored.reset();
    error = "not acknowledged";
    set("SIM_WIND", 9, 5);
    EXPECT_EQ(reports.back(), "SIM_WIND: not acknowledged");
    EXPECT_EQ(sent_to_all.back().get<"param_value">(), 1.25F);
    set("SIM_WIND", 6, 5);
    EXPECT_EQ(writes.size(), 1u);
    EXPECT_EQ(reports.back(), "SIM_WIND: wrong type of value");
}

TEST_F(Parameters, stations_get_their_own_lists) {
    ask_list({255, 190});
    ask_list({254, 190});
    EXPECT_EQ(all({254, 190}).size(), 3u);
    EXPECT_EQ(all({255, 190}).size(), 3u);
    for (int i = 0; i < 100; ++i) ask_list({static_cast<std::uint8_t>(i), 1});
    EXPECT_FALSE(server.waits({99, 1}));
}

// A station asks for what is missing, as QGroundControl does, after a pause; the time is counted in packets.
TEST_F(Parameters, a_list_with_losses_needs_at_most_two_and_a_half_times_the_packets) {
    device.clear();
    for (int i = 0; i < 150; ++i) device.push_back({"P" + std::to_string(i), Type::u16, std::int64_t{i}});
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        support::Random random{seed};
        std::set<int> missing;
        for (int i = 0; i < 150; ++i) missing.insert(i);
        std::size_t packets = 0;
        ask_list();
        for (int round = 0; round < 20 && !missing.empty(); ++round) {
            for (const auto& value : all()) {
                ++packets;
                if (!random.one_in(10)) missing.erase(value.get<"param_index">());
            }
            for (const int index : missing)
                if (!random.one_in(10)) ask(index);
        }
        EXPECT_TRUE(missing.empty());
        EXPECT_LE(packets, 375u);
    }
}

}    // namespace
}    // namespace mavlink_parameters_tests
