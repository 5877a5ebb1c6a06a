// Every MAVLink message that anogate-mavlink sends or understands, by the definitions of the dialect "common". No other file defines
// payloads.
#pragma once
#include <mavlink/schema.hpp>

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

namespace anogate::mavlink {
namespace table {

inline constexpr ano::Shape u8{ano::Type::u8}, i8{ano::Type::i8}, u16{ano::Type::u16}, i16{ano::Type::i16}, u32{ano::Type::u32},
    i32{ano::Type::i32}, u64{ano::Type::u64}, i64{ano::Type::i64}, f32{ano::Type::f32}, text{ano::Type::text, 0};

// clang-format off
inline constexpr Message messages[] = {
    // id, name, CRC_EXTRA, fields, extensions; ordered by id
    {0, "HEARTBEAT", 50, {
        {"type", u8}, {"autopilot", u8}, {"base_mode", u8}, {"custom_mode", u32}, {"system_status", u8}, {"mavlink_version", u8}}},
    {1, "SYS_STATUS", 124, {
        {"onboard_control_sensors_present", u32}, {"onboard_control_sensors_enabled", u32}, {"onboard_control_sensors_health", u32},
        {"load", u16}, {"voltage_battery", u16}, {"current_battery", i16}, {"battery_remaining", i8}, {"drop_rate_comm", u16},
        {"errors_comm", u16}, {"errors_count1", u16}, {"errors_count2", u16}, {"errors_count3", u16}, {"errors_count4", u16}}, {
        {"onboard_control_sensors_present_extended", u32}, {"onboard_control_sensors_enabled_extended", u32},
        {"onboard_control_sensors_health_extended", u32}}},
    {2, "SYSTEM_TIME", 137, {{"time_unix_usec", u64}, {"time_boot_ms", u32}}},
    {4, "PING", 237, {{"time_usec", u64}, {"seq", u32}, {"target_system", u8}, {"target_component", u8}}},
    {8, "LINK_NODE_STATUS", 117, {
        {"timestamp", u64}, {"tx_buf", u8}, {"rx_buf", u8}, {"tx_rate", u32}, {"rx_rate", u32}, {"rx_parse_err", u16},
        {"tx_overflows", u16}, {"rx_overflows", u16}, {"messages_sent", u32}, {"messages_received", u32}, {"messages_lost", u32}}},
    {11, "SET_MODE", 89, {{"target_system", u8}, {"base_mode", u8}, {"custom_mode", u32}}},
    {20, "PARAM_REQUEST_READ", 214, {
        {"target_system", u8}, {"target_component", u8}, {"param_id", text[16]}, {"param_index", i16}}},
    {21, "PARAM_REQUEST_LIST", 159, {{"target_system", u8}, {"target_component", u8}}},
    {22, "PARAM_VALUE", 220, {
        {"param_id", text[16]}, {"param_value", f32}, {"param_type", u8}, {"param_count", u16}, {"param_index", u16}}},
    {23, "PARAM_SET", 168, {
        {"target_system", u8}, {"target_component", u8}, {"param_id", text[16]}, {"param_value", f32}, {"param_type", u8}}},
    {24, "GPS_RAW_INT", 24, {
        {"time_usec", u64}, {"fix_type", u8}, {"lat", i32}, {"lon", i32}, {"alt", i32}, {"eph", u16}, {"epv", u16}, {"vel", u16},
        {"cog", u16}, {"satellites_visible", u8}}, {
        {"alt_ellipsoid", i32}, {"h_acc", u32}, {"v_acc", u32}, {"vel_acc", u32}, {"hdg_acc", u32}, {"yaw", u16}}},
    {26, "SCALED_IMU", 170, {
        {"time_boot_ms", u32}, {"xacc", i16}, {"yacc", i16}, {"zacc", i16}, {"xgyro", i16}, {"ygyro", i16}, {"zgyro", i16},
        {"xmag", i16}, {"ymag", i16}, {"zmag", i16}}, {{"temperature", i16}}},
    {27, "RAW_IMU", 144, {
        {"time_usec", u64}, {"xacc", i16}, {"yacc", i16}, {"zacc", i16}, {"xgyro", i16}, {"ygyro", i16}, {"zgyro", i16},
        {"xmag", i16}, {"ymag", i16}, {"zmag", i16}}, {{"id", u8}, {"temperature", i16}}},
    {30, "ATTITUDE", 39, {
        {"time_boot_ms", u32}, {"roll", f32}, {"pitch", f32}, {"yaw", f32}, {"rollspeed", f32}, {"pitchspeed", f32},
        {"yawspeed", f32}}},
    {31, "ATTITUDE_QUATERNION", 246, {
        {"time_boot_ms", u32}, {"q1", f32}, {"q2", f32}, {"q3", f32}, {"q4", f32}, {"rollspeed", f32}, {"pitchspeed", f32},
        {"yawspeed", f32}}, {{"repr_offset_q", f32[4]}}},
    {32, "LOCAL_POSITION_NED", 185, {
        {"time_boot_ms", u32}, {"x", f32}, {"y", f32}, {"z", f32}, {"vx", f32}, {"vy", f32}, {"vz", f32}}},
    {33, "GLOBAL_POSITION_INT", 104, {
        {"time_boot_ms", u32}, {"lat", i32}, {"lon", i32}, {"alt", i32}, {"relative_alt", i32}, {"vx", i16}, {"vy", i16},
        {"vz", i16}, {"hdg", u16}}},
    {36, "SERVO_OUTPUT_RAW", 222, {
        {"time_usec", u32}, {"port", u8}, {"servo1_raw", u16}, {"servo2_raw", u16}, {"servo3_raw", u16}, {"servo4_raw", u16},
        {"servo5_raw", u16}, {"servo6_raw", u16}, {"servo7_raw", u16}, {"servo8_raw", u16}}, {
        {"servo9_raw", u16}, {"servo10_raw", u16}, {"servo11_raw", u16}, {"servo12_raw", u16}, {"servo13_raw", u16},
        {"servo14_raw", u16}, {"servo15_raw", u16}, {"servo16_raw", u16}}},
    {37, "MISSION_REQUEST_PARTIAL_LIST", 212, {
        {"target_system", u8}, {"target_component", u8}, {"start_index", i16}, {"end_index", i16}}, {{"mission_type", u8}}},
    {38, "MISSION_WRITE_PARTIAL_LIST", 9, {
        {"target_system", u8}, {"target_component", u8}, {"start_index", i16}, {"end_index", i16}}, {{"mission_type", u8}}},
    {39, "MISSION_ITEM", 254, {
        {"target_system", u8}, {"target_component", u8}, {"seq", u16}, {"frame", u8}, {"command", u16}, {"current", u8},
        {"autocontinue", u8}, {"param1", f32}, {"param2", f32}, {"param3", f32}, {"param4", f32}, {"x", f32}, {"y", f32},
        {"z", f32}}, {{"mission_type", u8}}},
    {40, "MISSION_REQUEST", 230, {{"target_system", u8}, {"target_component", u8}, {"seq", u16}}, {{"mission_type", u8}}},
    {41, "MISSION_SET_CURRENT", 28, {{"target_system", u8}, {"target_component", u8}, {"seq", u16}}},
    {42, "MISSION_CURRENT", 28, {{"seq", u16}}, {
        {"total", u16}, {"mission_state", u8}, {"mission_mode", u8}, {"mission_id", u32}, {"fence_id", u32},
        {"rally_points_id", u32}}},
    {43, "MISSION_REQUEST_LIST", 132, {{"target_system", u8}, {"target_component", u8}}, {{"mission_type", u8}}},
    {44, "MISSION_COUNT", 221, {{"target_system", u8}, {"target_component", u8}, {"count", u16}}, {
        {"mission_type", u8}, {"opaque_id", u32}}},
    {45, "MISSION_CLEAR_ALL", 232, {{"target_system", u8}, {"target_component", u8}}, {{"mission_type", u8}}},
    {46, "MISSION_ITEM_REACHED", 11, {{"seq", u16}}},
    {47, "MISSION_ACK", 153, {{"target_system", u8}, {"target_component", u8}, {"type", u8}}, {
        {"mission_type", u8}, {"opaque_id", u32}}},
    {51, "MISSION_REQUEST_INT", 196, {{"target_system", u8}, {"target_component", u8}, {"seq", u16}}, {{"mission_type", u8}}},
    {62, "NAV_CONTROLLER_OUTPUT", 183, {
        {"nav_roll", f32}, {"nav_pitch", f32}, {"nav_bearing", i16}, {"target_bearing", i16}, {"wp_dist", u16}, {"alt_error", f32},
        {"aspd_error", f32}, {"xtrack_error", f32}}},
    {65, "RC_CHANNELS", 118, {
        {"time_boot_ms", u32}, {"chancount", u8}, {"chan1_raw", u16}, {"chan2_raw", u16}, {"chan3_raw", u16}, {"chan4_raw", u16},
        {"chan5_raw", u16}, {"chan6_raw", u16}, {"chan7_raw", u16}, {"chan8_raw", u16}, {"chan9_raw", u16}, {"chan10_raw", u16},
        {"chan11_raw", u16}, {"chan12_raw", u16}, {"chan13_raw", u16}, {"chan14_raw", u16}, {"chan15_raw", u16},
        {"chan16_raw", u16}, {"chan17_raw", u16}, {"chan18_raw", u16}, {"rssi", u8}}},
    {66, "REQUEST_DATA_STREAM", 148, {
        {"target_system", u8}, {"target_component", u8}, {"req_stream_id", u8}, {"req_message_rate", u16}, {"start_stop", u8}}},
    {69, "MANUAL_CONTROL", 243, {
        {"target", u8}, {"x", i16}, {"y", i16}, {"z", i16}, {"r", i16}, {"buttons", u16}}, {
        {"buttons2", u16}, {"enabled_extensions", u8}, {"s", i16}, {"t", i16}, {"aux1", i16}, {"aux2", i16}, {"aux3", i16},
        {"aux4", i16}, {"aux5", i16}, {"aux6", i16}}},
    {70, "RC_CHANNELS_OVERRIDE", 124, {
        {"target_system", u8}, {"target_component", u8}, {"chan1_raw", u16}, {"chan2_raw", u16}, {"chan3_raw", u16},
        {"chan4_raw", u16}, {"chan5_raw", u16}, {"chan6_raw", u16}, {"chan7_raw", u16}, {"chan8_raw", u16}}, {
        {"chan9_raw", u16}, {"chan10_raw", u16}, {"chan11_raw", u16}, {"chan12_raw", u16}, {"chan13_raw", u16},
        {"chan14_raw", u16}, {"chan15_raw", u16}, {"chan16_raw", u16}, {"chan17_raw", u16}, {"chan18_raw", u16}}},
    {73, "MISSION_ITEM_INT", 38, {
        {"target_system", u8}, {"target_component", u8}, {"seq", u16}, {"frame", u8}, {"command", u16}, {"current", u8},
        {"autocontinue", u8}, {"param1", f32}, {"param2", f32}, {"param3", f32}, {"param4", f32}, {"x", i32}, {"y", i32},
        {"z", f32}}, {{"mission_type", u8}}},
    {74, "VFR_HUD", 20, {
        {"airspeed", f32}, {"groundspeed", f32}, {"heading", i16}, {"throttle", u16}, {"alt", f32}, {"climb", f32}}},
    {75, "COMMAND_INT", 158, {
        {"target_system", u8}, {"target_component", u8}, {"frame", u8}, {"command", u16}, {"current", u8}, {"autocontinue", u8},
        {"param1", f32}, {"param2", f32}, {"param3", f32}, {"param4", f32}, {"x", i32}, {"y", i32}, {"z", f32}}},
    {76, "COMMAND_LONG", 152, {
        {"target_system", u8}, {"target_component", u8}, {"command", u16}, {"confirmation", u8}, {"param1", f32}, {"param2", f32},
        {"param3", f32}, {"param4", f32}, {"param5", f32}, {"param6", f32}, {"param7", f32}}},
    {77, "COMMAND_ACK", 143, {{"command", u16}, {"result", u8}}, {
        {"progress", u8}, {"result_param2", i32}, {"target_system", u8}, {"target_component", u8}}},
    {80, "COMMAND_CANCEL", 14, {{"target_system", u8}, {"target_component", u8}, {"command", u16}}},
    {82, "SET_ATTITUDE_TARGET", 49, {
        {"time_boot_ms", u32}, {"target_system", u8}, {"target_component", u8}, {"type_mask", u8}, {"q", f32[4]},
        {"body_roll_rate", f32}, {"body_pitch_rate", f32}, {"body_yaw_rate", f32}, {"thrust", f32}}, {{"thrust_body", f32[3]}}},
    {84, "SET_POSITION_TARGET_LOCAL_NED", 143, {
        {"time_boot_ms", u32}, {"target_system", u8}, {"target_component", u8}, {"coordinate_frame", u8}, {"type_mask", u16},
        {"x", f32}, {"y", f32}, {"z", f32}, {"vx", f32}, {"vy", f32}, {"vz", f32}, {"afx", f32}, {"afy", f32}, {"afz", f32},
        {"yaw", f32}, {"yaw_rate", f32}}},
    {100, "OPTICAL_FLOW", 175, {
        {"time_usec", u64}, {"sensor_id", u8}, {"flow_x", i16}, {"flow_y", i16}, {"flow_comp_m_x", f32}, {"flow_comp_m_y", f32},
        {"quality", u8}, {"ground_distance", f32}}, {{"flow_rate_x", f32}, {"flow_rate_y", f32}}},
    {111, "TIMESYNC", 34, {{"tc1", i64}, {"ts1", i64}}, {{"target_system", u8}, {"target_component", u8}}},
    {132, "DISTANCE_SENSOR", 85, {
        {"time_boot_ms", u32}, {"min_distance", u16}, {"max_distance", u16}, {"current_distance", u16}, {"type", u8}, {"id", u8},
        {"orientation", u8}, {"covariance", u8}}, {
        {"horizontal_fov", f32}, {"vertical_fov", f32}, {"quaternion", f32[4]}, {"signal_quality", u8}}},
    {141, "ALTITUDE", 47, {
        {"time_usec", u64}, {"altitude_monotonic", f32}, {"altitude_amsl", f32}, {"altitude_local", f32},
        {"altitude_relative", f32}, {"altitude_terrain", f32}, {"bottom_clearance", f32}}},
    {147, "BATTERY_STATUS", 154, {
        {"id", u8}, {"battery_function", u8}, {"type", u8}, {"temperature", i16}, {"voltages", u16[10]}, {"current_battery", i16},
        {"current_consumed", i32}, {"energy_consumed", i32}, {"battery_remaining", i8}}, {
        {"time_remaining", i32}, {"charge_state", u8}, {"voltages_ext", u16[4]}, {"mode", u8}, {"fault_bitmask", u32}}},
    {148, "AUTOPILOT_VERSION", 178, {
        {"capabilities", u64}, {"flight_sw_version", u32}, {"middleware_sw_version", u32}, {"os_sw_version", u32},
        {"board_version", u32}, {"flight_custom_version", u8[8]}, {"middleware_custom_version", u8[8]},
        {"os_custom_version", u8[8]}, {"vendor_id", u16}, {"product_id", u16}, {"uid", u64}}, {{"uid2", u8[18]}}},
    {231, "WIND_COV", 105, {
        {"time_usec", u64}, {"wind_x", f32}, {"wind_y", f32}, {"wind_z", f32}, {"var_horiz", f32}, {"var_vert", f32},
        {"wind_alt", f32}, {"horiz_accuracy", f32}, {"vert_accuracy", f32}}},
    {242, "HOME_POSITION", 104, {
        {"latitude", i32}, {"longitude", i32}, {"altitude", i32}, {"x", f32}, {"y", f32}, {"z", f32}, {"q", f32[4]},
        {"approach_x", f32}, {"approach_y", f32}, {"approach_z", f32}}, {{"time_usec", u64}}},
    {244, "MESSAGE_INTERVAL", 95, {{"message_id", u16}, {"interval_us", i32}}},
    {245, "EXTENDED_SYS_STATE", 130, {{"vtol_state", u8}, {"landed_state", u8}}},
    {251, "NAMED_VALUE_FLOAT", 170, {{"time_boot_ms", u32}, {"name", text[10]}, {"value", f32}}},
    {253, "STATUSTEXT", 83, {{"severity", u8}, {"text", text[50]}}, {{"id", u16}, {"chunk_seq", u8}}},
    {256, "SETUP_SIGNING", 71, {
        {"target_system", u8}, {"target_component", u8}, {"secret_key", u8[32]}, {"initial_timestamp", u64}}},
    {300, "PROTOCOL_VERSION", 217, {
        {"version", u16}, {"min_version", u16}, {"max_version", u16}, {"spec_version_hash", u8[8]},
        {"library_version_hash", u8[8]}}},
    {330, "OBSTACLE_DISTANCE", 23, {
        {"time_usec", u64}, {"sensor_type", u8}, {"distances", u16[72]}, {"increment", u8}, {"min_distance", u16},
        {"max_distance", u16}}, {{"increment_f", f32}, {"angle_offset", f32}, {"frame", u8}}},
    {350, "DEBUG_FLOAT_ARRAY", 232, {{"time_usec", u64}, {"name", text[10]}, {"array_id", u16}}, {{"data", f32[58]}}},
};
// clang-format on

constexpr bool crc_extras_are_published() noexcept {
    return std::all_of(std::begin(messages), std::end(messages),
                       [](const Message& row) { return row.computed_crc_extra() == row.crc_extra; });
}
static_assert(crc_extras_are_published(), "a row differs from the definition that everybody else uses");
static_assert(std::is_sorted(std::begin(messages), std::end(messages),
                             [](const Message& a, const Message& b) { return a.id < b.id; }));

constexpr const Message& row_called(std::string_view name) {
    for (const Message& row : messages)
        if (row.name == name) return row;
    table_error::no_message_has_this_name();
    return messages[0];
}

// By value: under UBSan, GCC 12 does not compare an address with null in a constant expression.
constexpr Field field_called(const Message& row, std::string_view name) {
    for (const Field& field : row.fields())
        if (field.name == name) return field;
    table_error::the_message_has_no_such_field();
    return {};
}

}    // namespace table

inline constexpr std::span<const Message> messages{table::messages};

/// nullptr: the table has no such message.
constexpr const Message* find_message(std::uint32_t id) noexcept {
    const auto at = std::lower_bound(messages.begin(), messages.end(), id,
                                     [](const Message& row, std::uint32_t i) { return row.id < i; });
    return at != messages.end() && at->id == id ? &*at : nullptr;
}

/// The id of a message: id_of<"HEARTBEAT">.
template <ano::Name message>
inline constexpr std::uint32_t id_of = table::row_called(message.view()).id;

}    // namespace anogate::mavlink
