#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ros/standard_types.hpp>
#include <ros2/topic_table.hpp>

#include <array>
#include <vector>

namespace anogate {
namespace {

using ano::id_of;

constexpr std::uint8_t inertial[] = {id_of<"inertial">}, compass[] = {id_of<"compass">},
                       attitude[] = {id_of<"quaternion">, id_of<"euler">}, velocity[] = {id_of<"velocity">},
                       position[] = {id_of<"position">}, power[] = {id_of<"power">}, gps[] = {id_of<"gps">},
                       external_position[] = {id_of<"general_position">}, external_velocity[] = {id_of<"general_velocity">},
                       ranging[] = {id_of<"ranging">}, image[] = {id_of<"image">}, sticks[] = {id_of<"remote_control">},
                       log_lines[] = {id_of<"log">, id_of<"log_value">};

}    // namespace

std::span<const TopicRow> topic_table() {
    const auto& t = standard_types();
    static const std::array<TopicRow, device_topics> rows{{
        {"imu/data", t.imu, inertial, ""},
        {"mag", t.magnetic_field, compass, ""},
        {"temperature", t.temperature, compass, ""},
        {"orientation", t.quaternion_stamped, attitude, "quaternions of a length near 1"},
        {"velocity", t.vector3_stamped, velocity, ""},
        {"position", t.point_stamped, position, "a height"},
        {"odom", t.odometry, position, "a height, and an attitude (0x03, 0x04) and a velocity (0x07) of the last second"},
        {"battery", t.battery_state, power, ""},
        {"fix", t.nav_sat_fix, gps, ""},
        {"fix_velocity", t.vector3_stamped, gps, "a fix"},
        {"external/position", t.point_stamped, external_position, "x, y and z"},
        {"external/velocity", t.vector3_stamped, external_velocity, "x, y and z"},
        {"scan", t.point_cloud, ranging, "type 100"},
        {"image", t.image, image, "all frames of an image"},
        {"range/down", t.range, ranging, "type 0 or 6"},
        {"range/forward", t.range, ranging, "type 1"},
        {"range/back", t.range, ranging, "type 2"},
        {"range/left", t.range, ranging, "type 3"},
        {"range/right", t.range, ranging, "type 4"},
        {"range/up", t.range, ranging, "type 5"},
        {"joy", t.joy, sticks, "that joy is not accepted as input"},
        {"log", t.log, log_lines, ""},
    }};
    return rows;
}

std::span<const std::string_view> topic_names() {
    static const std::vector<std::string_view> names = [] {
        std::vector<std::string_view> all;
        for (const TopicRow& row : topic_table()) all.push_back(row.name);
        for (const std::string_view other : {"raw", "tf", "diagnostics"}) all.push_back(other);
        return all;
    }();
    return names;
}

std::string format_sources(const TopicRow& row) {
    std::string text;
    for (const std::uint8_t id : row.sources)
        text += (text.empty() ? "" : ", ") + ano::hex_byte(id) + ' ' + std::string{ano::find_message(id)->name};
    return text;
}

}    // namespace anogate
