#include <gtest/gtest.h>
#include <ano/conversation.hpp>
#include <ano/messages.hpp>
#include <ano/traffic.hpp>

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace messages_tests {
namespace {

using namespace ano;

static_assert(find_message("euler")->fixed_size == 7);
static_assert(find_message("no_such_message") == nullptr);
static_assert(find_message(std::uint8_t{0x77}) == nullptr);
static_assert(layouts_of(0x77).empty());
static_assert(traffic_class_of(0xC0) == TrafficClass::urgent);

// Bytes of the fixed part, from the tables of the protocol text.
TEST(Messages, have_the_lengths_of_the_protocol_text) {
    const std::map<std::string, std::vector<unsigned>> lengths{{"check", {3}},
                                                               {"inertial", {13}},
                                                               {"compass", {9, 14}},
                                                               {"euler", {7, 8}},
                                                               {"quaternion", {9}},
                                                               {"altitude", {13, 9}},
                                                               {"mode", {5}},
                                                               {"velocity", {6}},
                                                               {"position", {12, 8}},
                                                               {"wind", {4}},
                                                               {"target_attitude", {6}},
                                                               {"target_velocity", {6}},
                                                               {"return_home", {4}},
                                                               {"power", {4, 10}},
                                                               {"module_status", {4}},
                                                               {"rgb", {4}},
                                                               {"pwm", {8, 12, 16}},
                                                               {"attitude_control", {8}},
                                                               {"gps", {23}},
                                                               {"raw_flow", {6}},
                                                               {"general_position", {12}},
                                                               {"general_velocity", {6}},
                                                               {"ranging", {5, 1, 7}},
                                                               {"image_feature", {7}},
                                                               {"remote_control", {20}},
                                                               {"realtime_control", {14}},
                                                               {"optical_flow", {5, 7, 15}},
                                                               {"waypoint_read", {1}},
                                                               {"waypoint", {22}},
                                                               {"log", {1}},
                                                               {"log_value", {4}},
                                                               {"image", {17}},
                                                               {"ip_tunnel", {10}},
                                                               {"ip_tunnel_short", {4}},
                                                               {"command", {3}},
                                                               {"command_query", {3}},
                                                               {"command_info", {33}},
                                                               {"parameter_command", {3, 3}},
                                                               {"parameter_value", {2}},
                                                               {"parameter_info", {23, 30, 34}},
                                                               {"device_info", {9}},
                                                               {"firmware", {3, 3, 5, 5, 3, 20, 3}},
                                                               {"special", {0}},
                                                               {"flexible1", {0}},
                                                               {"flexible2", {0}},
                                                               {"flexible3", {0}},
                                                               {"flexible4", {0}},
                                                               {"flexible5", {0}},
                                                               {"flexible6", {0}},
                                                               {"flexible7", {0}},
                                                               {"flexible8", {0}},
                                                               {"flexible9", {0}},
                                                               {"flexible10", {0}}};
    std::map<std::string, std::vector<unsigned>> found;
    for (const Message& row : messages) {
        found[std::string{row.name}].push_back(row.fixed_size);
        if (row.variant.length != 0) {
            EXPECT_EQ(row.variant.length, row.fixed_size) << row.name;
        }
    }
    EXPECT_EQ(found, lengths);
}

TEST(Messages, have_the_ids_of_the_protocol_text) {
    std::set<unsigned> ids;
    for (const Message& row : messages) ids.insert(row.id);
    std::set<unsigned> listed{0x20, 0x21, 0x40, 0x41, 0x51, 0x60, 0x61, 0xA0, 0xA1, 0xB0,
                              0xB1, 0xB2, 0xC0, 0xC1, 0xC2, 0xE0, 0xE1, 0xE2, 0xE3};
    for (unsigned id = 0x00; id <= 0x0F; ++id) listed.insert(id);
    for (unsigned id = 0x30; id <= 0x35; ++id) listed.insert(id);
    for (unsigned id = 0xF0; id <= 0xFB; ++id) listed.insert(id);
    EXPECT_EQ(ids, listed);
}

TEST(Messages, are_found_by_id_and_by_name) {
    for (const Message& row : messages) {
        ASSERT_NE(find_message(row.id), nullptr);
        EXPECT_EQ(find_message(row.id)->name, row.name);
        EXPECT_EQ(find_message(row.name)->id, row.id);
        EXPECT_TRUE(find_message(row.name)->is_base());
    }
}

TEST(Messages, have_the_meanings_of_their_values) {
    EXPECT_EQ(find_message("mode")->field("sflag")->meaning(2), "airborne");
    EXPECT_EQ(find_message("module_status")->field("sta_gps")->meaning(3), "good");
    EXPECT_EQ(find_message("module_status")->field("sta_g_vel")->meaning(3), "");
    EXPECT_EQ(find_message("log")->field("color")->meaning(2), "green");
    EXPECT_EQ(find_message("image")->field("color")->meaning(6), "purple");
    EXPECT_EQ(find_message("parameter_info")->field("par_type")->meaning(10), "string");
    EXPECT_EQ(find_message("ranging")->field("type")->meaning(6), "down");
    EXPECT_EQ(find_message("waypoint")->field("yaw")->meaning(400), "face the target");
    std::set<std::string_view> codes;
    for (const Message& row : layouts_of(0xF0))
        if (const Field* code = row.field("code"))
            for (const Meaning& m : code->meanings) codes.insert(m.text);
    EXPECT_EQ(codes.size(), 10u);
}

TEST(Messages, show_which_of_them_are_acknowledged) {
    std::map<std::string, Acknowledged> told;
    for (const Message& row : messages)
        if (acknowledged(row) != Acknowledged::no)
            told[std::string{row.name} + "/" + std::string{row.variant.label}] = acknowledged(row);
    const std::map<std::string, Acknowledged> expected{{"waypoint/", Acknowledged::as_write},
                                                       {"command/", Acknowledged::yes},
                                                       {"parameter_command/action", Acknowledged::yes},
                                                       {"parameter_value/", Acknowledged::as_write}};
    EXPECT_EQ(told, expected);
}

using Ids = std::set<unsigned>;

Ids with(Ids ids, unsigned first, unsigned last) {
    for (unsigned id = first; id <= last; ++id) ids.insert(id);
    return ids;
}

TEST(Traffic, classes_of_every_id_match_the_protocol_text) {
    const Ids urgent = with(with({0x00, 0x40, 0x41, 0x60, 0x61, 0xF0}, 0xC0, 0xC2), 0xE0, 0xE3);
    const Ids telemetry = with(with({0x20, 0x21, 0x51, 0xA0, 0xA1}, 0x01, 0x0F), 0x30, 0x35);
    const Ids same_id = with(with({0x20, 0x21, 0x40, 0x41}, 0x01, 0x0F), 0x30, 0x33);
    const Ids same_first_byte{0x34, 0x35, 0x51};
    for (unsigned id = 0; id < 256; ++id) {
        const Traffic traffic = traffic_of(static_cast<std::uint8_t>(id));
        const auto expected = urgent.contains(id)      ? TrafficClass::urgent
                              : telemetry.contains(id) ? TrafficClass::telemetry
                                                       : TrafficClass::bulk;
        EXPECT_EQ(traffic.traffic_class, expected) << id;
        const auto replaces = same_id.contains(id)           ? Replaces::same_id
                              : same_first_byte.contains(id) ? Replaces::same_first_byte
                                                             : Replaces::nothing;
        EXPECT_EQ(traffic.replaces, replaces) << id;
    }
}

}    // namespace
}    // namespace messages_tests
