// Every message of the protocol (protocol text, section 4). No other file defines payloads: encoding, decoding, JSON, text, the
// reference and the Wireshark dissector are loops over these rows.
#pragma once
#include <ano/schema.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace ano {
namespace table {

inline constexpr Shape u8{Type::u8}, i8{Type::i8}, u16{Type::u16}, i16{Type::i16}, u32{Type::u32}, i32{Type::i32};
inline constexpr Shape f32{Type::f32}, ip{Type::ip};
inline constexpr Shape text{Type::text, 0}, bytes{Type::bytes, 0}, frames{Type::frames, 0}, list{Type::list, 0};

inline constexpr Traffic urgent{TrafficClass::urgent, Replaces::nothing};
inline constexpr Traffic sticks{TrafficClass::urgent, Replaces::same_id};
inline constexpr Traffic sensor{TrafficClass::telemetry, Replaces::same_id};
inline constexpr Traffic sensor_by_kind{TrafficClass::telemetry, Replaces::same_first_byte};
inline constexpr Traffic report{TrafficClass::telemetry, Replaces::nothing};
inline constexpr Traffic bulk{TrafficClass::bulk, Replaces::nothing};

inline constexpr Meaning sflags[]{{0, "locked"}, {1, "unlocked"}, {2, "airborne"}};
inline constexpr Meaning attitude_modes[]{{1, "Euler angles"}};
inline constexpr Meaning module_states[]{{0, "no data"}, {1, "unusable"}, {2, "normal"}};
inline constexpr Meaning gps_states[]{{0, "no data"}, {1, "unusable"}, {2, "normal"}, {3, "good"}};
inline constexpr Meaning directions[]{{0, "down"},  {1, "forward"}, {2, "back"}, {3, "left"},
                                      {4, "right"}, {5, "up"},      {6, "down"}};
inline constexpr Meaning scans[]{{100, "scan"}};
inline constexpr Meaning flow_modes[]{{0, "raw"}, {1, "fused"}, {2, "fused with inertia"}};
inline constexpr Meaning flow_states[]{{0, "invalid"}, {1, "valid"}};
inline constexpr Meaning nothing_found[]{{255, "nothing found"}};
inline constexpr Meaning no_link[]{{0, "no link"}};
inline constexpr Meaning unreliable[]{{200, "unreliable"}};
inline constexpr Meaning waypoint_requests[]{{255, "how many"}};
inline constexpr Meaning home[]{{0, "HOME"}};
inline constexpr Meaning headings[]{{400, "face the target"}};
inline constexpr Meaning command_queries[]{{0, "how many"}, {1, "describe"}};
inline constexpr Meaning value_types[]{{0, "none"}, {1, "u8"},  {2, "i8"},  {3, "u16"}, {4, "i16"}, {5, "u32"},
                                       {6, "i32"},  {7, "f32"}, {8, "i64"}, {9, "f32"}, {10, "f64"}};
inline constexpr Meaning parameter_queries[]{{0, "device info"}, {1, "how many"}, {2, "value"}, {3, "description"}};
inline constexpr Meaning parameter_action[]{{0x10, "action"}};
inline constexpr Meaning actions[]{{0xAA, "restore defaults"},
                                   {0xAB, "save"},
                                   {0x20, "clear accelerometer calibration"},
                                   {0x21, "accelerometer calibration sent"},
                                   {0x30, "clear compass calibration"},
                                   {0x31, "store compass calibration"}};
inline constexpr Meaning parameter_types[]{{0, "u8"},  {1, "i8"},  {2, "u16"}, {3, "i16"}, {4, "u32"},    {5, "i32"},
                                           {6, "u64"}, {7, "i64"}, {8, "f32"}, {9, "f64"}, {10, "string"}};
inline constexpr Meaning firmware_commands[]{{0x00, "command"}, {0x01, "info"}, {0x10, "image"}};
inline constexpr Meaning firmware_codes[]{{0x0101, "info refused"},
                                          {0x0102, "info accepted"},
                                          {0x0110, "erase"},
                                          {0x0111, "erase failed"},
                                          {0x0112, "erased"},
                                          {0x1010, "all sent"},
                                          {0x1011, "image check failed"},
                                          {0x1012, "image check passed"}};
inline constexpr Meaning firmware_frame_codes[]{{0x1001, "frame failed"}, {0x1002, "frame written"}};
inline constexpr Meaning log_colors[]{{0, "default"}, {1, "red"}, {2, "green"}, {3, "blue"}};
inline constexpr Meaning image_colors[]{{0, "grey"}, {1, "mono"},   {2, "red"},   {3, "green"},
                                        {4, "blue"}, {5, "yellow"}, {6, "purple"}};
inline constexpr Meaning default_port[]{{0, "default"}};

// clang-format off
inline constexpr Message messages[] = {
    // id, name, description, traffic, fields, variant

    {0x00, "check", "Acknowledges a frame by its check bytes", urgent, {
        {"id_get", u8, Role::code}, {"sc_get", u8, Role::code}, {"ac_get", u8, Role::code}}},
    {0x01, "inertial", "Accelerometer and gyroscope", sensor, {
        {"acc_x", i16, "cm/s²"}, {"acc_y", i16, "cm/s²"}, {"acc_z", i16, "cm/s²"},
        {"gyr_x", i16, times(32768, 2000), "°/s"}, {"gyr_y", i16, times(32768, 2000), "°/s"},
        {"gyr_z", i16, times(32768, 2000), "°/s"}, {"shock_sta", u8}}},
    {0x02, "compass", "Magnetometer and temperature", sensor, {
        {"mag_x", i16}, {"mag_y", i16}, {"mag_z", i16}, {"tmp", i16, times(10), "°C"}, {"mag_sta", u8}},
        exactly(9)},
    {0x02, "compass", "Magnetometer, barometric altitude and temperature", sensor, {
        {"mag_x", i16}, {"mag_y", i16}, {"mag_z", i16}, {"alt_bar", i32, "cm"}, {"tmp", i16, times(10), "°C"},
        {"bar_sta", u8}, {"mag_sta", u8}}, Variant{"field", 14}},
    {0x03, "euler", "Attitude as Euler angles", sensor, {
        {"rol", i16, times(100), "°"}, {"pit", i16, times(100), "°"}, {"yaw", i16, times(100), "°"}, {"fusion_sta", u8}},
        exactly(7)},
    {0x03, "euler", "Attitude as Euler angles, with a mode", sensor, {
        {"mode", u8, only(1), attitude_modes}, {"rol", i16, times(100), "°"}, {"pit", i16, times(100), "°"},
        {"yaw", i16, times(100), "°"}, {"fusion_sta", u8}}, Variant{"field", 8}},
    {0x04, "quaternion", "Attitude as a quaternion", sensor, {
        {"v0", i16, times(10000)}, {"v1", i16, times(10000)}, {"v2", i16, times(10000)}, {"v3", i16, times(10000)},
        {"fusion_sta", u8}}},
    {0x05, "altitude", "Altitude by barometer, by the additional sensor, fused", sensor, {
        {"alt_bar", i32, "cm"}, {"alt_add", i32, "cm"}, {"alt_fu", i32, "cm"}, {"alt_sta", u8}},
        exactly(13)},
    {0x05, "altitude", "Altitude fused and by the additional sensor", sensor, {
        {"alt_fu", i32, "cm"}, {"alt_add", i32, "cm"}, {"alt_sta", u8}}, Variant{"field", 9}},
    {0x06, "mode", "Flight mode, and the command being executed", sensor, {
        {"mode", u8}, {"sflag", u8, sflags}, {"cid", u8}, {"cmd0", u8}, {"cmd1", u8}}},
    {0x07, "velocity", "Flight velocity", sensor, {
        {"speed_x", i16, "cm/s"}, {"speed_y", i16, "cm/s"}, {"speed_z", i16, "cm/s"}}},
    {0x08, "position", "Position relative to the take-off point", sensor, {
        {"pos_x", i32, "cm"}, {"pos_y", i32, "cm"}, {"pos_z", i32, "cm"}}},
    {0x08, "position", "Position relative to the take-off point, without height", sensor, {
        {"pos_x", i32, "cm"}, {"pos_y", i32, "cm"}}, Variant{"field", 8}},
    {0x09, "wind", "Estimated wind", sensor, {
        {"wind_x", i16, "cm/s"}, {"wind_y", i16, "cm/s"}}},
    {0x0A, "target_attitude", "Target attitude", sensor, {
        {"tar_rol", i16, times(100), "°"}, {"tar_pit", i16, times(100), "°"}, {"tar_yaw", i16, times(100), "°"}}},
    {0x0B, "target_velocity", "Target velocity", sensor, {
        {"tar_speed_x", i16, "cm/s"}, {"tar_speed_y", i16, "cm/s"}, {"tar_speed_z", i16, "cm/s"}}},
    {0x0C, "return_home", "Direction and distance of home", sensor, {
        {"r_a", i16, times(10), "°", range(-180, 180)}, {"r_d", u16, "m"}}},
    {0x0D, "power", "Supply voltage and current", sensor, {
        {"voltage", u16, times(100), "V"}, {"current", u16, times(100), "A"}}},
    {0x0D, "power", "Voltage and current of the battery and of the controller's supply", sensor, {
        {"voltage", u16, times(100), "V", label("battery")}, {"current", u16, times(100), "A", label("battery")},
        {"voltage2", u16, times(100), "V", label("controller supply")},
        {"current2", u16, times(100), "A", label("controller supply")}, {"reserved", u16}}, Variant{"field", 10}},
    {0x0E, "module_status", "State of the external modules", sensor, {
        {"sta_g_vel", u8, module_states}, {"sta_g_pos", u8, module_states}, {"sta_gps", u8, gps_states},
        {"sta_alt_add", u8, module_states}}},
    {0x0F, "rgb", "Brightness of the indicator lights", sensor, {
        {"bri_r", u8, range(0, 20)}, {"bri_g", u8, range(0, 20)}, {"bri_b", u8, range(0, 20)},
        {"bri_a", u8, range(0, 20)}}},
    {0x20, "pwm", "Motor outputs of 4 axes", sensor, {
        {"pwm1", u16, times(100), "%", range(0, 100)}, {"pwm2", u16, times(100), "%", range(0, 100)},
        {"pwm3", u16, times(100), "%", range(0, 100)}, {"pwm4", u16, times(100), "%", range(0, 100)}}},
    {0x20, "pwm", "Motor outputs of 6 axes", sensor, {
        {"pwm1", u16, times(100), "%", range(0, 100)}, {"pwm2", u16, times(100), "%", range(0, 100)},
        {"pwm3", u16, times(100), "%", range(0, 100)}, {"pwm4", u16, times(100), "%", range(0, 100)},
        {"pwm5", u16, times(100), "%", range(0, 100)}, {"pwm6", u16, times(100), "%", range(0, 100)}},
        Variant{"axes6", 12}},
    {0x20, "pwm", "Motor outputs of 8 axes", sensor, {
        {"pwm1", u16, times(100), "%", range(0, 100)}, {"pwm2", u16, times(100), "%", range(0, 100)},
        {"pwm3", u16, times(100), "%", range(0, 100)}, {"pwm4", u16, times(100), "%", range(0, 100)},
        {"pwm5", u16, times(100), "%", range(0, 100)}, {"pwm6", u16, times(100), "%", range(0, 100)},
        {"pwm7", u16, times(100), "%", range(0, 100)}, {"pwm8", u16, times(100), "%", range(0, 100)}},
        Variant{"axes8", 16}},
    {0x21, "attitude_control", "Attitude control outputs", sensor, {
        {"ctrl_rol", i16, range(-5000, 5000)}, {"ctrl_pit", i16, range(-5000, 5000)}, {"ctrl_thr", i16, range(0, 10000)},
        {"ctrl_yaw", i16, range(-5000, 5000)}}},

    {0x30, "gps", "Satellite positioning", sensor, {
        {"fix_sta", u8, note("as UBX gives it")}, {"s_num", u8, note("satellites")}, {"lng", i32, times(1e7), "°"},
        {"lat", i32, times(1e7), "°"}, {"alt_gps", i32, "cm"}, {"n_spe", i16, "cm/s"}, {"e_spe", i16, "cm/s"},
        {"d_spe", i16, "cm/s"}, {"pdop", u8, range(0, 200), unreliable}, {"sacc", u8, times(1, 100), "mm/s"},
        {"vacc", u8, times(1, 100), "mm"}}},
    {0x31, "raw_flow", "Raw optical flow", sensor, {
        {"type", u8, note("model of the sensor")}, {"dx", i16, "px"}, {"dy", i16, "px"},
        {"qua", u8, note("0 is invalid, more is better")}}},
    {0x32, "general_position", "Position by an external sensor; X forward and Y left at unlock", sensor, {
        {"pos_x", i32, "mm", NoData{INT32_MIN}}, {"pos_y", i32, "mm", NoData{INT32_MIN}},
        {"pos_z", i32, "mm", NoData{INT32_MIN}}}},
    {0x33, "general_velocity", "Velocity by an external sensor; X forward, Y left", sensor, {
        {"speed_x", i16, "cm/s", NoData{INT16_MIN}}, {"speed_y", i16, "cm/s", NoData{INT16_MIN}},
        {"speed_z", i16, "cm/s", NoData{INT16_MIN}}}},
    {0x34, "ranging", "Distance in one direction", sensor_by_kind, {
        {"type", u8, only(0, 6), directions}, {"dist", i32, "mm"}}, exactly(5)},
    {0x34, "ranging", "Distances all round", sensor_by_kind, {
        {"type", u8, only(100), scans}, {"points", list},
        {"angle", u16, times(100), "°", range(0, 360), note("clockwise from the nose")}, {"dist", u16, "cm"}},
        Variant{"scan"}},
    {0x34, "ranging", "Distance at an angle", sensor_by_kind, {
        {"direction", u8, directions}, {"angle", u16, times(100), "°"}, {"dist", i32, "cm"}}, Variant{"field", 7}},
    {0x35, "image_feature", "A feature found in the image", sensor_by_kind, {
        {"id", u8, nothing_found}, {"x", i16, range(-1000, 1000), note("from the centre, right is positive")},
        {"y", i16, range(-1000, 1000), note("from the centre, up is positive")},
        {"angle", u16, "°", note("clockwise from up")}}},
    {0x40, "remote_control", "Remote control channels", sticks, {
        {"rol", i16, range(1000, 2000), no_link}, {"pit", i16, range(1000, 2000), no_link},
        {"thr", i16, range(1000, 2000), no_link}, {"yaw", i16, range(1000, 2000), no_link},
        {"aux1", i16, range(1000, 2000), no_link}, {"aux2", i16, range(1000, 2000), no_link},
        {"aux3", i16, range(1000, 2000), no_link}, {"aux4", i16, range(1000, 2000), no_link},
        {"aux5", i16, range(1000, 2000), no_link}, {"aux6", i16, range(1000, 2000), no_link}}},
    {0x41, "realtime_control", "Control in real time; the flight mode decides which fields count", sticks, {
        {"ctrl_rol", i16, times(100), "°", range(-90, 90)}, {"ctrl_pit", i16, times(100), "°", range(-90, 90)},
        {"ctrl_thr", i16, times(10), "%", range(0, 100)}, {"ctrl_yaw_dps", i16, "°/s", range(-200, 200)},
        {"ctrl_spd_x", i16, "cm/s"}, {"ctrl_spd_y", i16, "cm/s"}, {"ctrl_spd_z", i16, "cm/s"}}},
    {0x51, "optical_flow", "Raw optical flow", sensor_by_kind, {
        {"mode", u8, only(0), flow_modes}, {"state", u8, flow_states}, {"dx_0", i8, "px/20 ms"}, {"dy_0", i8, "px/20 ms"},
        {"quality", u8}}},
    {0x51, "optical_flow", "Optical flow over ground", sensor_by_kind, {
        {"mode", u8, only(1), flow_modes}, {"state", u8, flow_states}, {"dx_1", i16, "cm/s"}, {"dy_1", i16, "cm/s"},
        {"quality", u8}}, Variant{"mode1"}},
    {0x51, "optical_flow", "Optical flow over ground, fused with inertia", sensor_by_kind, {
        {"mode", u8, only(2), flow_modes}, {"state", u8, flow_states}, {"dx_2", i16, "cm/s"}, {"dy_2", i16, "cm/s"},
        {"dx_fix", i16, "cm/s"}, {"dy_fix", i16, "cm/s"}, {"integ_x", i16, "cm", note("wraps")},
        {"integ_y", i16, "cm", note("wraps")}, {"quality", u8}}, Variant{"mode2"}},

    {0x60, "waypoint_read", "Requests a waypoint or their number, or reports the number", urgent, {
        {"num", u8, waypoint_requests}}},
    {0x61, "waypoint", "One waypoint", urgent, {
        {"num", u8, home}, {"lng", i32, times(1e7), "°"}, {"lat", i32, times(1e7), "°"}, {"alt", i32, "cm"},
        {"spd", u16, "cm/s"}, {"yaw", u16, "°", range(0, 359), headings, note("from north")}, {"fun", u8},
        {"cmd1", u8}, {"cmd2", u8}, {"cmd3", u8}, {"cmd4", u8}}},

    {0xA0, "log", "A line of text", report, {{"color", u8, log_colors}, {"str", text}}},
    {0xA1, "log_value", "A number and a line of text", report, {{"val", f32}, {"str", text}}},
    {0xB0, "image", "Rows of an image", bulk, {
        {"flag", u16}, {"color", u8, image_colors}, {"width", u16, "px"}, {"height", u16, "px"},
        {"val", bytes[10], note("the sender's own")},
        {"pixels", bytes, note("whole rows; grey: a byte a pixel, else a bit a pixel")}}},
    {0xB1, "ip_tunnel", "Frames for another address of an IP network", bulk, {
        {"src_ip", ip, note("filled in by the radio")}, {"dst_ip", ip}, {"port", u16, default_port}, {"frames", frames}}},
    {0xB2, "ip_tunnel_short", "Frames for another address of the sender's own IP network", bulk, {
        {"src", u8, note("last byte, filled in by the radio")}, {"dst", u8, note("last byte")}, {"port", u16, default_port},
        {"frames", frames}}},

    {0xC0, "command", "Runs a command", urgent, {
        {"cid0", u8}, {"cid1", u8}, {"cid2", u8}, {"values", bytes, Role::values, note("types as described by command_info")}}},
    {0xC1, "command_query", "Requests commands, or reports their number", urgent, {
        {"cmd", u8, command_queries}, {"val", u16}}},
    {0xC2, "command_info", "Describes a command", urgent, {
        {"cmd_id", u16}, {"cid0", u8}, {"cid1", u8}, {"cid2", u8}, {"val_type", u8[8], value_types, Role::value_types, note("7 is u64 on current devices")}, {"name", text[20]},
        {"info", text}}},
    {0xE0, "parameter_command", "Requests parameters, or reports their number", urgent, {
        {"cmd", u8, parameter_queries}, {"val", u16}}},
    {0xE0, "parameter_command", "Acts on all parameters", urgent, {
        {"cmd", u8, only(0x10), parameter_action}, {"val", u16, actions}}, Variant{"action"}},
    {0xE1, "parameter_value", "The value of a parameter", urgent, {
        {"par_id", u16}, {"value", bytes, Role::value, note("type as described by parameter_info")}}},
    {0xE2, "parameter_info", "Describes a parameter", urgent, {
        {"par_id", u16}, {"par_type", u8, parameter_types, range(0, 10)}, {"name", text[20]}, {"info", text}}},
    {0xE2, "parameter_info", "Describes a parameter of an old device, which sends every value as i32", urgent, {
        {"par_id", u16}, {"min", i32}, {"max", i32}, {"name", text[20]}, {"info", text}}, Variant{"old", 0, true}},
    {0xE2, "parameter_info", "Describes a parameter of a device that sends every value as i32, multiplied by mul", urgent, {
        {"par_id", u16}, {"min", i32}, {"max", i32}, {"mul", i32, range(0, 10'000'000), note("the value is that of parameter_value / mul; 0: not scaled")},
        {"name", text[20]}, {"info", text}}, Variant{"scaled", 0, true}},
    {0xE3, "device_info", "Who a device is", urgent, {
        {"dev_id", u8, Role::code}, {"hw_ver", u16}, {"sw_ver", u16}, {"bl_ver", u16}, {"pt_ver", u16}, {"name", text}}},

    {0xF0, "firmware", "A step of a firmware upgrade", urgent, {
        {"iap_cmd", u8, only(0x00), firmware_commands}, {"code", u16, firmware_codes}}},
    // Some devices send codes high byte first. 01 10 is "erase" in this order, and "frame failed" in the other: the length
    // decides.
    {0xF0, "firmware", "A step of a firmware upgrade, with the code high byte first", urgent, {
        {"iap_cmd", u8, only(0x00), firmware_commands}, {"code", u16, ByteOrder::big, only(0x0102, 0x0112), firmware_codes}},
        Variant{"reading", 3}},
    {0xF0, "firmware", "What became of a frame of the image", urgent, {
        {"iap_cmd", u8, only(0x00), firmware_commands}, {"code", u16, only(0x1001, 0x1002), firmware_frame_codes},
        {"frame_num", u16}}, Variant{"written"}},
    {0xF0, "firmware", "What became of a frame of the image, with the code high byte first", urgent, {
        {"iap_cmd", u8, only(0x00), firmware_commands},
        {"code", u16, ByteOrder::big, only(0x1001, 0x1002), firmware_frame_codes}, {"frame_num", u16}},
        Variant{"reading_written", 5}},
    {0xF0, "firmware", "The check of the image, with the code high byte first", urgent, {
        {"iap_cmd", u8, only(0x00), firmware_commands}, {"code", u16, ByteOrder::big, only(0x1011, 0x1012), firmware_codes}},
        Variant{"reading_check", 3}},
    {0xF0, "firmware", "Describes the image", urgent, {
        {"iap_cmd", u8, only(0x01), firmware_commands}, {"bin_len", u32}, {"frame_len", u16}, {"bin_crc", u16},
        {"bin_ver", u16}, {"hw_type", u8}, {"hw_ver_min", u16}, {"hw_ver_max", u16}, {"cmd", u32}}, Variant{"info"}},
    {0xF0, "firmware", "A frame of the image", urgent, {
        {"iap_cmd", u8, only(0x10), firmware_commands}, {"frame_num", u16}, {"data", bytes}}, Variant{"image"}},

    // Their layouts are configured: see flexible.hpp.
    {0xF1, "flexible1", "Values the user defines", bulk, {}},
    {0xF2, "flexible2", "Values the user defines", bulk, {}},
    {0xF3, "flexible3", "Values the user defines", bulk, {}},
    {0xF4, "flexible4", "Values the user defines", bulk, {}},
    {0xF5, "flexible5", "Values the user defines", bulk, {}},
    {0xF6, "flexible6", "Values the user defines", bulk, {}},
    {0xF7, "flexible7", "Values the user defines", bulk, {}},
    {0xF8, "flexible8", "Values the user defines", bulk, {}},
    {0xF9, "flexible9", "Values the user defines", bulk, {}},
    {0xFA, "flexible10", "Values the user defines", bulk, {}},
    {0xFB, "special", "The vendor's own", bulk, {{"data", bytes}}},
};
// clang-format on

inline constexpr MessageIndex index = index_messages(messages);

}    // namespace table

inline constexpr std::span<const Message> messages{table::messages};

/// Every layout of a message, the base layout first; empty for an id that is not listed.
constexpr std::span<const Message> layouts_of(std::uint8_t id) noexcept {
    return messages.subspan(table::index.first[id], table::index.count[id]);
}

/// The base layout of a message; nullptr for an id that is not listed.
constexpr const Message* find_message(std::uint8_t id) noexcept {
    return table::index.count[id] == 0 ? nullptr : &messages[table::index.first[id]];
}

/// The base layout of the message with this name; nullptr: there is none.
constexpr const Message* find_message(std::string_view name) noexcept {
    for (const Message& row : messages)
        if (row.name == name) return &row;
    return nullptr;
}

namespace table {

constexpr std::uint8_t id_called(std::string_view name) {
    for (const Message& row : messages)
        if (row.name == name) return row.id;
    table_error::no_message_has_this_name();
    return 0;
}

}    // namespace table

/// The id of a message, computed at compile time: id_of<"command">. An unknown name does not compile.
template <Name M>
inline constexpr std::uint8_t id_of = table::id_called(M.view());

inline constexpr std::uint8_t first_flexible = 0xF1;
inline constexpr std::uint8_t last_flexible = 0xFA;
constexpr bool is_flexible(std::uint8_t id) noexcept { return id >= first_flexible && id <= last_flexible; }

}    // namespace ano
