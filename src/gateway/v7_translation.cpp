#include <gateway/v7_translation.hpp>

#include <ano/messages.hpp>
#include <ano/wire.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace anogate {
namespace {

using ano::load;
using ano::store;
namespace v7 = ano::v7;

constexpr std::uint8_t check_id = 0x00, waypoint_read = 0x60, waypoint = 0x61;    // the same in both
constexpr std::uint8_t v7_command = 0xE0, v7_read = 0xE1, v7_parameter = 0xE2;
constexpr std::uint8_t v8_command = 0xC0, v8_command_query = 0xC1, v8_command_info = 0xC2;
constexpr std::uint8_t v8_parameter_command = 0xE0, v8_value = 0xE1, v8_info = 0xE2, v8_device_info = 0xE3;

constexpr std::size_t command_size = 11;    // DATA of every V7 command (section 5)
constexpr std::uint16_t protocol_version = 700;
constexpr double cmss_per_g = 980.665;
constexpr double wire_per_dps = 32768.0 / 2000;    // gyroscope of 0x01 in V8
constexpr std::int32_t no_place = std::numeric_limits<std::int32_t>::min();
constexpr std::uint32_t no_distance = 0xFFFFFFFF;

struct Device {
    std::uint8_t v7, v8;
    std::string_view name;
};
// Section 2. The device of a V8 id comes first; 0x66 is a second address of hosts.
constexpr Device devices[] = {
    {v7::address::tuokongzhe, 0xDC, "TKZ FC (V7)"},     {v7::address::lx_imu, 0xDD, "LX IMU (V7)"},
    {v7::address::lx_mcu, 0xDB, "LX MCU (V7)"},         {v7::address::flow, 0xDE, "Flow (V7)"},
    {v7::address::data_radio, 0xE6, "Radio (V7)"},      {v7::address::host, ano::address::host, "host"},
    {v7::address::console, ano::address::host, "host"}, {v7::address::broadcast, ano::address::broadcast, "all"},
};

constexpr std::optional<std::uint8_t> v8_address(std::uint8_t destination) noexcept {
    for (const Device& device : devices)
        if (device.v7 == destination) return device.v8;
    if (destination >= 1 && destination <= 199) return destination;
    return std::nullopt;
}

constexpr const Device* device_of(std::uint8_t v8) noexcept {
    for (const Device& device : devices)
        if (device.v8 == v8) return &device;
    return nullptr;
}

enum class Values : std::uint8_t { none, u8, u16, u16_u16, u16_u16_u16, i32, i32_i32 };
struct Command {
    std::uint8_t bytes[3];
    Values values;
    std::string_view name, info;
};
// Section 5. Without 01 20 AA, which erases the firmware.
constexpr Command commands[] = {
    {{0x01, 0x00, 0x01}, Values::none, "CAL_ACC", ""},
    {{0x01, 0x00, 0x02}, Values::none, "CAL_GYR", ""},
    {{0x01, 0x00, 0x03}, Values::none, "CAL_LEVEL", ""},
    {{0x01, 0x00, 0x04}, Values::none, "CAL_MAG", ""},
    {{0x01, 0x00, 0x05}, Values::none, "CAL_ACC_6_SIDES", ""},
    {{0x01, 0x00, 0x10}, Values::none, "RESET_ATTITUDE", ""},
    {{0x01, 0x00, 0x61}, Values::none, "STORE_WAYPOINTS", ""},
    {{0x01, 0x00, 0x62}, Values::none, "CLEAR_WAYPOINTS", ""},
    {{0x01, 0x00, 0xAA}, Values::none, "DEFAULT_PID", ""},
    {{0x01, 0x00, 0xAB}, Values::none, "DEFAULT_PARAMETERS", ""},
    {{0x01, 0x00, 0xAC}, Values::none, "RESTORE_ALL", ""},
    {{0x01, 0x01, 0x01}, Values::u8, "MODE", "0 attitude, 1 + height, 2 position, 3 program"},
    {{0x10, 0x00, 0x01}, Values::none, "UNLOCK", ""},
    {{0x10, 0x00, 0x02}, Values::none, "LOCK", "emergency stop"},
    {{0x10, 0x00, 0x04}, Values::none, "HOVER", ""},
    {{0x10, 0x00, 0x05}, Values::u16, "TAKE_OFF", "cm, 0 to 500; not in mode 0"},
    {{0x10, 0x00, 0x06}, Values::none, "LAND", "not in mode 0"},
    {{0x10, 0x00, 0x07}, Values::none, "RETURN_HOME", "mode 3"},
    {{0x10, 0x00, 0x08}, Values::u16, "FLIP", "degrees, 1 to 360; mode 3"},
    {{0x10, 0x00, 0x09}, Values::none, "ORBIT", "mode 3"},
    {{0x10, 0x00, 0x0A}, Values::u8, "HEADLESS", ""},
    {{0x10, 0x00, 0x60}, Values::none, "WAYPOINTS_START", "mode 3"},
    {{0x10, 0x00, 0x61}, Values::none, "WAYPOINTS_PAUSE", "mode 3"},
    {{0x10, 0x00, 0x62}, Values::none, "WAYPOINTS_CANCEL", "mode 3"},
    {{0x10, 0x01, 0x01}, Values::i32_i32, "TARGET_XY", "cm, +-100000; mode 3"},
    {{0x10, 0x01, 0x02}, Values::i32, "TARGET_HEIGHT", "cm, +-100000; mode 3"},
    {{0x10, 0x02, 0x01}, Values::u16_u16, "UP", "cm, 0 to 10000; cm/s, 10 to 300; mode 3"},
    {{0x10, 0x02, 0x02}, Values::u16_u16, "DOWN", "cm, 0 to 10000; cm/s, 10 to 300; mode 3"},
    {{0x10, 0x02, 0x03}, Values::u16_u16_u16, "MOVE", "cm; cm/s; degrees clockwise from the nose; mode 3"},
    {{0x10, 0x02, 0x07}, Values::u16_u16, "TURN_LEFT", "degrees, 0 to 359; degrees/s, 5 to 90; mode 3"},
    {{0x10, 0x02, 0x08}, Values::u16_u16, "TURN_RIGHT", "degrees, 0 to 359; degrees/s, 5 to 90; mode 3"},
    {{0x10, 0x03, 0x01}, Values::i32_i32, "TARGET_LNG_LAT", "degrees x1e7; mode 3"},
};
constexpr Command flow_commands[] = {
    {{0x01, 0x10, 0x02}, Values::none, "RESET_ATTITUDE", ""},
    {{0x01, 0x10, 0x03}, Values::none, "RESET_MOTION", ""},
    {{0x01, 0x10, 0x04}, Values::none, "PAUSE_CORRECTION", "2 s"},
};

constexpr std::span<const Command> commands_of(std::uint8_t asked) noexcept {
    return asked == 0xDE ? std::span<const Command>{flow_commands} : std::span<const Command>{commands};
}

// val_type of 0xC2: 1 u8, 3 u16, 6 i32.
constexpr std::array<std::uint8_t, 8> value_types_of(Values values) noexcept {
    switch (values) {
    case Values::none: return {};
    case Values::u8: return {1};
    case Values::u16: return {3};
    case Values::u16_u16: return {3, 3};
    case Values::u16_u16_u16: return {3, 3, 3};
    case Values::i32: return {6};
    case Values::i32_i32: return {6, 6};
    }
    return {};
}

constexpr bool erases_firmware(std::span<const std::uint8_t> command) noexcept {
    return command.size() >= 3 && command[0] == 0x01 && command[1] == 0x20 && command[2] == 0xAA;
}

bool is_not_in_v7(std::uint8_t id) noexcept {
    return std::find(std::begin(v7::table::not_in_v7), std::end(v7::table::not_in_v7), id) != std::end(v7::table::not_in_v7);
}

std::int16_t to_i16(double value) noexcept {
    return static_cast<std::int16_t>(std::lround(std::clamp(value, -32768.0, 32767.0)));
}

// Centimetres to millimetres. What is too large becomes the largest: the smallest i32 means "no data".
std::int32_t to_mm(std::int32_t cm) noexcept {
    if (cm == no_place) return no_place;
    constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
    return static_cast<std::int32_t>(std::clamp(std::int64_t{cm} * 10, -most, most));
}

struct Direction {
    std::uint8_t direction;
    std::uint16_t angle;
    friend bool operator==(const Direction&, const Direction&) = default;
};
struct Ranging {
    std::uint8_t type;    // of 0x34 in V8
    Direction at;
};
// Section 8; `doc`: {0, 270} is to the left.
constexpr Ranging ranging_of_lx[] = {{6, {0, 270}}, {6, {1, 270}}, {0, {0, 270}}, {5, {1, 90}},
                                     {1, {0, 0}},   {2, {0, 180}}, {4, {0, 90}}};
constexpr Ranging ranging_of_doc[] = {{3, {0, 270}}, {6, {1, 270}}, {0, {1, 270}}, {5, {1, 90}},
                                      {1, {0, 0}},   {2, {0, 180}}, {4, {0, 90}}};
constexpr Ranging ranging_of_flow[] = {{6, {0, 0}}, {0, {0, 0}}, {5, {1, 0}}, {1, {2, 0}}, {2, {3, 0}}, {3, {4, 0}}, {4, {5, 0}}};
constexpr std::uint8_t scan = 100;

constexpr std::span<const Ranging> ranging_of(V7Range range) noexcept {
    switch (range) {
    case V7Range::lx: return ranging_of_lx;
    case V7Range::doc: return ranging_of_doc;
    case V7Range::flow: break;
    }
    return ranging_of_flow;
}

std::optional<std::uint8_t> ranging_type(V7Range range, Direction at) noexcept {
    if (range == V7Range::flow) at.angle = 0;
    for (const Ranging& row : ranging_of(range))
        if (row.at == at) return row.type;
    return std::nullopt;
}

void append_text(std::vector<std::uint8_t>& to, std::string_view text, std::size_t width = 0) {
    to.insert(to.end(), text.begin(), text.end());
    if (text.size() < width) to.resize(to.size() + width - text.size());
}

// Section 6.
#define PID(n, first) \
    {first, "PID" #n "_P", 1000}, {first + 1, "PID" #n "_I", 1000}, { first + 2, "PID" #n "_D", 1000 }
#define INFO \
    {1, "HW_TYPE"}, {2, "HW_VER"}, {3, "SW_VER"}, { 4, "BL_VER" }
#define CALIBRATION                                                                                                 \
    {1000, "CAL_AOFF_X", 1, true}, {1001, "CAL_AOFF_Y", 1, true}, {1002, "CAL_AOFF_Z", 1, true},                    \
        {1003, "CAL_ASEN_X", 1000, true}, {1004, "CAL_ASEN_Y", 1000, true}, {1005, "CAL_ASEN_Z", 1000, true},       \
        {1006, "CAL_AEM1_X", 100000, true}, {1007, "CAL_AEM1_Y", 100000, true}, {1008, "CAL_AEM1_Z", 100000, true}, \
        {1009, "CAL_AEM2_X", 100000, true}, {1010, "CAL_AEM2_Y", 100000, true}, {1011, "CAL_AEM2_Z", 100000, true}, \
        {1012, "CAL_AEM3_X", 100000, true}, {1013, "CAL_AEM3_Y", 100000, true}, {1014, "CAL_AEM3_Z", 100000, true}, \
        {1015, "CAL_MOFF_X", 1, true}, {1016, "CAL_MOFF_Y", 1, true}, {1017, "CAL_MOFF_Z", 1, true},                \
        {1018, "CAL_MSEN_X", 1000, true}, {1019, "CAL_MSEN_Y", 1000, true}, {                                       \
        1020, "CAL_MSEN_Z", 1000, true                                                                              \
    }

// clang-format off
constexpr V7Parameter parameters_of_lx[] = {
    INFO,
    {151, "GYR_FILTER"}, {152, "ACC_FILTER"}, {153, "FUSION_ATT"}, {154, "FUSION_MAG"}, {155, "FUSION_HOR"}, {156, "FUSION_VER"},
    {157, "FENCE_MODE"}, {158, "FENCE_RADIUS"}, {159, "FENCE_X"}, {160, "FENCE_Y"}, {161, "FENCE_HEIGHT"},
    {162, "COM1_BAUD"}, {163, "COM2_BAUD"}, {164, "COM2_MODE"}, {165, "RGB_OUT"},
    {300, "PERIOD_01"}, {301, "PERIOD_02"}, {302, "PERIOD_03"}, {303, "PERIOD_04"}, {304, "PERIOD_05"}, {305, "PERIOD_06"},
    {306, "PERIOD_07"}, {307, "PERIOD_08"}, {308, "PERIOD_09"}, {309, "PERIOD_0A"}, {310, "PERIOD_0B"}, {311, "PERIOD_0C"},
    {312, "PERIOD_0D"}, {313, "PERIOD_0E"}, {314, "PERIOD_20"}, {315, "PERIOD_21"}, {316, "PERIOD_30"}, {317, "PERIOD_32"},
    {318, "PERIOD_33"}, {319, "PERIOD_34"}, {320, "PERIOD_40"}, {321, "PERIOD_41"},
    CALIBRATION,
};
constexpr V7Parameter parameters_of_tkz[] = {
    INFO,
    PID(1, 11), PID(2, 14), PID(3, 17), PID(4, 20), PID(5, 23), PID(6, 26), PID(7, 29), PID(8, 32), PID(9, 35), PID(10, 38),
    PID(11, 41), PID(12, 44), PID(13, 47), PID(14, 50), PID(15, 53), PID(16, 56), PID(17, 59), PID(18, 62),
    {65, "GAIN1"}, {66, "GAIN2"}, {67, "GAIN3"}, {68, "PID_MODE"},
    {71, "RC_MODE"}, {72, "UNLOCK_PWM"}, {73, "UNLOCK_STICK"}, {74, "GYR_AUTO_CAL"}, {75, "CELLS"},
    {76, "LOW_VOLT_WARN", 100}, {77, "LOW_VOLT_RETURN", 100}, {78, "LOW_VOLT_LAND", 100},
    {79, "CENTER_X"}, {80, "CENTER_Y"}, {81, "CENTER_Z"}, {82, "TAKEOFF_HEIGHT"}, {83, "TAKEOFF_SPEED"},
    {84, "LAND_SPEED"}, {85, "LAND_SPEED_MAX"}, {86, "AUTO_LAND"}, {87, "HEATER_ON"}, {88, "HEATER_TEMP"},
    {89, "SPEED_HOR"}, {90, "SPEED_RC"}, {91, "SPEED_UP"}, {92, "SPEED_DOWN"}, {94, "SAFE_ATTITUDE"}, {95, "MAG_MODE"},
    {96, "RATE_LIMIT_1"}, {97, "RATE_LIMIT_2"}, {98, "RATE_LIMIT_3"}, {99, "RETURN_HEIGHT"}, {100, "RETURN_SPEED"},
    CALIBRATION,
};
// clang-format on
#undef PID
#undef INFO
#undef CALIBRATION

}    // namespace

std::span<const V7Parameter> v7_parameters_of_lx() noexcept { return parameters_of_lx; }
std::span<const V7Parameter> v7_parameters_of_tkz() noexcept { return parameters_of_tkz; }

V7Settings v7_settings_for(std::uint8_t address) noexcept {
    V7Settings s;
    s.address = address;
    if (address == 0xDD) {
        s.acceleration = v7_acceleration_of_lx;
        s.parameters = parameters_of_lx;
    } else if (address == 0xDE) {
        s.acceleration = v7_acceleration_of_flow;
        s.range = V7Range::flow;
    } else if (address == 0xDC) {
        s.acceleration = {V7Acceleration::Unit::cmss, 0};
        s.parameters = parameters_of_tkz;
    }
    for (const unsigned id : {0x00u, 0x30u, 0x32u, 0x33u, 0x34u, 0x40u, 0x41u, 0x51u, 0x60u, 0x61u, 0xA0u, 0xC0u, 0xE0u, 0xE1u})
        s.down.set(id);
    for (unsigned id = ano::first_flexible; id <= ano::last_flexible; ++id) s.down.set(id);
    return s;
}

void V7Translation::SentFrames::put(const Sent& sent) noexcept {
    all_[next_] = sent;
    next_ = (next_ + 1) % all_.size();
}

std::optional<V7Translation::Sent> V7Translation::SentFrames::take(std::uint8_t id, ano::Checks checks,
                                                                   ano::TimePoint now) noexcept {
    for (std::size_t i = 0; i < all_.size(); ++i) {
        Sent& sent = all_[(next_ + i) % all_.size()];    // the oldest first
        if (sent.id == 0 || sent.id != id || sent.checks != checks || now - sent.at > memory) continue;
        const Sent found = sent;
        sent = {};
        return found;
    }
    return std::nullopt;
}

V7Translation::V7Translation(const V7Settings& settings) : settings_{settings} {
    ids_.set(settings.address);
    for (const std::uint8_t source : settings.sources)
        if (source != 0) ids_.set(source);
    to_device_.reserve(4096);
    to_hosts_.reserve(4096);
}

// ---- From the device

void V7Translation::receive(v7::FrameView frame, ano::TimePoint now) {
    heard_at_ = now;
    switch (frame.id()) {
    case check_id: return up_check(frame, now);
    case 0x01: return up_inertial(frame);
    case 0x02: return up_compass(frame, now);
    case 0x05: return up_altitude(frame, now);
    case 0x08: return up_position(frame);
    case 0x32: return up_place(frame);
    case 0x34: return up_ranging(frame);
    case waypoint_read:
    case waypoint: return up_waypoint(frame, now);
    case 0xA1: return up_log_value(frame);
    case v7_command: return up_command(frame, now);
    case v7_read:
        if (frame.data().size() != 2) return count(&V7Counters::up_malformed);
        up(frame, v8_parameter_command, std::array<std::uint8_t, 3>{2, frame.data()[0], frame.data()[1]});
        return;
    case v7_parameter: return up_parameter(frame, now);
    case 0xFB: return count(&V7Counters::up_no_counterpart);
    default:
        if (is_not_in_v7(frame.id())) return count(&V7Counters::up_no_counterpart);
        up(frame, frame.id(), frame.data());
    }
}

std::optional<ano::FrameView> V7Translation::up(v7::FrameView frame, std::uint8_t id, Data data) {
    const auto destination = v8_address(frame.destination());
    if (!destination) {
        count(&V7Counters::up_no_address);
        return std::nullopt;
    }
    const std::uint8_t source = settings_.sources[frame.id()];
    return put_to_hosts(source != 0 ? source : settings_.address, *destination, id, data);
}

ano::FrameView V7Translation::put_to_hosts(std::uint8_t source, std::uint8_t destination, std::uint8_t id, Data data) {
    const std::size_t before = to_hosts_.size();
    to_hosts_.resize(before + ano::overhead + data.size());
    const auto out = std::span{to_hosts_}.subspan(before);
    ano::encode(out, source, destination, id, data);
    ++counters_.translated_up;
    return ano::FrameView{out};
}

void V7Translation::up_inertial(v7::FrameView frame) {
    if (frame.data().size() != 13) return count(&V7Counters::up_malformed);
    std::array<std::uint8_t, 13> data;
    std::copy(frame.data().begin(), frame.data().end(), data.begin());
    const auto scale = [&](std::size_t first, double factor) {
        for (std::size_t at = first; at < first + 6; at += 2) store(&data[at], to_i16(load<std::int16_t>(&data[at]) * factor));
    };
    if (settings_.acceleration.unit == V7Acceleration::Unit::per_g) scale(0, cmss_per_g / settings_.acceleration.per_g);
    if (settings_.acceleration.unit == V7Acceleration::Unit::cmss) scale(6, wire_per_dps);
    up(frame, frame.id(), data);
}

void V7Translation::up_compass(v7::FrameView frame, ano::TimePoint now) {
    const Data data = frame.data();
    if (data.size() != 14) return count(&V7Counters::up_malformed);
    alt_bar_ = load<std::int32_t>(&data[6]);
    alt_bar_at_ = now;
    if (settings_.keeps_layout) {
        up(frame, frame.id(), data);
        return;
    }
    std::array<std::uint8_t, 9> out;
    std::copy_n(data.begin(), 6, out.begin());
    store(&out[6], to_i16(load<std::int16_t>(&data[10]) * 10.0 / settings_.temperature));
    out[8] = data[13];
    up(frame, frame.id(), out);
}

void V7Translation::up_altitude(v7::FrameView frame, ano::TimePoint now) {
    const Data data = frame.data();
    if (data.size() != 9) return count(&V7Counters::up_malformed);
    alt_fu_ = load<std::int32_t>(&data[0]);
    if (settings_.keeps_layout || !alt_bar_ || now - alt_bar_at_ >= alt_bar_age) {
        up(frame, frame.id(), data);
        return;
    }
    std::array<std::uint8_t, 13> out;
    store(&out[0], *alt_bar_);
    store(&out[4], load<std::int32_t>(&data[4]));
    store(&out[8], *alt_fu_);
    out[12] = data[8];
    up(frame, frame.id(), out);
}

void V7Translation::up_position(v7::FrameView frame) {
    const Data data = frame.data();
    if (data.size() != 8) return count(&V7Counters::up_malformed);
    std::array<std::uint8_t, 12> out;
    std::copy(data.begin(), data.end(), out.begin());
    const bool has_height = alt_fu_ && !settings_.keeps_layout;
    if (has_height) store(&out[8], *alt_fu_);
    up(frame, frame.id(), std::span{out}.first(has_height ? 12u : 8u));
}

void V7Translation::up_place(v7::FrameView frame) {
    if (frame.data().size() != 12) return count(&V7Counters::up_malformed);
    std::array<std::uint8_t, 12> out;
    for (std::size_t at = 0; at < 12; at += 4) store(&out[at], to_mm(load<std::int32_t>(&frame.data()[at])));
    up(frame, frame.id(), out);
}

void V7Translation::up_ranging(v7::FrameView frame) {
    const Data data = frame.data();
    if (data.size() != 7) return count(&V7Counters::up_malformed);
    if (settings_.keeps_layout) {
        up(frame, frame.id(), data);
        return;
    }
    const Direction at{data[0], load<std::uint16_t>(&data[1])};
    const auto cm = load<std::uint32_t>(&data[3]);
    if (cm == no_distance) return count(&V7Counters::up_no_distance);
    std::array<std::uint8_t, 5> out;
    if (const auto type = ranging_type(settings_.range, at)) {
        if (cm > std::numeric_limits<std::int32_t>::max() / 10) return count(&V7Counters::up_no_distance);
        out[0] = *type;
        store(&out[1], static_cast<std::int32_t>(cm * 10));
    } else if (settings_.range != V7Range::flow && at.direction == 0 && at.angle < 360 && cm <= 0xFFFF) {
        out[0] = scan;
        store(&out[1], static_cast<std::uint16_t>(at.angle * 100));
        store(&out[3], static_cast<std::uint16_t>(cm));
    } else {
        return count(&V7Counters::up_no_distance);
    }
    up(frame, frame.id(), out);
}

void V7Translation::up_log_value(v7::FrameView frame) {
    if (frame.data().size() < 4) return count(&V7Counters::up_malformed);
    std::array<std::uint8_t, v7::max_len> out;
    std::copy(frame.data().begin(), frame.data().end(), out.begin());
    store(&out[0], static_cast<float>(load<std::int32_t>(&out[0])));
    up(frame, frame.id(), std::span{out}.first(frame.data().size()));
}

// A command of a panel on the line.
void V7Translation::up_command(v7::FrameView frame, ano::TimePoint now) {
    if (frame.data().size() < 3) return count(&V7Counters::up_malformed);
    if (erases_firmware(frame.data())) return count(&V7Counters::up_no_counterpart);
    const auto sent = up(frame, v8_command, frame.data());
    if (!sent) return;
    sent_up_.put({now, v8_command, sent->checks(), frame.id(), frame.checks(), sent->source(), sent->destination()});
}

void V7Translation::up_parameter(v7::FrameView frame, ano::TimePoint now) {
    const Data data = frame.data();
    if (data.size() != 6) return count(&V7Counters::up_malformed);
    const auto number = load<std::uint16_t>(&data[0]);
    const auto wire = load<std::int32_t>(&data[2]);
    if (number >= 2 && number <= 4) versions_[number - 2u] = static_cast<std::uint16_t>(wire);
    const auto question = answered(v7_read, number, now);
    const auto index = question ? std::optional{question->index} : index_of(number);
    if (!index) return count(&V7Counters::up_unknown_parameter);
    std::array<std::uint8_t, 6> out;
    store(&out[0], *index);
    store(&out[2], wire);
    const V7Parameter* const row = parameter(*index);
    if (row != nullptr && row->is_real) store(&out[2], static_cast<float>(wire / static_cast<double>(row->scale)));
    if (question) put_to_hosts(question->asked, question->requester, v8_value, out);
    else put_to_hosts(settings_.address, ano::address::host, v8_value, out);
}

void V7Translation::up_waypoint(v7::FrameView frame, ano::TimePoint now) {
    if (frame.data().size() != (frame.id() == waypoint ? 22u : 1u)) return count(&V7Counters::up_malformed);
    const std::uint8_t number = frame.id() == waypoint ? frame.data()[0] : 0xFF;
    if (const auto question = answered(waypoint_read, number, now))
        put_to_hosts(question->asked, question->requester, frame.id(), frame.data());
    else up(frame, frame.id(), frame.data());
}

void V7Translation::up_check(v7::FrameView frame, ano::TimePoint now) {
    const Data data = frame.data();
    if (data.size() != 3) return count(&V7Counters::up_malformed);
    const auto sent = sent_down_.take(data[0], {data[1], data[2]}, now);
    if (!sent) return count(&V7Counters::up_unmatched_check);
    put_to_hosts(sent->asked, sent->requester, check_id,
                 std::array{sent->original_id, sent->original_checks.sum, sent->original_checks.add});
}

// ---- To the device

bool V7Translation::is_ours(std::uint8_t destination) const noexcept {
    return ids_[destination] || destination == ano::address::broadcast || (settings_.port != 0 && destination == settings_.port);
}

std::uint8_t V7Translation::asked_by(std::uint8_t destination) const noexcept {
    return ids_[destination] ? destination : settings_.address;
}

std::uint8_t V7Translation::destination_of(std::uint8_t id, std::uint8_t asked) const noexcept {
    if (settings_.destination) return *settings_.destination;
    const Device* const device = id == v7_read || id == v7_parameter ? device_of(asked) : nullptr;
    return device != nullptr ? device->v7 : v7::address::broadcast;
}

void V7Translation::put_to_device(std::uint8_t destination, std::uint8_t id, Data data) {
    const std::size_t before = to_device_.size();
    to_device_.resize(before + v7::overhead + data.size());
    v7::encode(std::span{to_device_}.subspan(before), destination, id, data);
    ++counters_.translated_down;
}

void V7Translation::send(ano::FrameView frame, ano::TimePoint now) {
    const std::uint8_t id = frame.id();
    if (!is_ours(frame.destination())) return count(&V7Counters::down_not_ours);
    if (v7_is_own_sensor(id)) return count(&V7Counters::down_not_allowed);
    if (id == v8_command_query) return down_command_query(frame, now);    // answered by the gateway
    if ((is_not_in_v7(id) && id != v8_command) || id == v8_info || id == 0xFB) return count(&V7Counters::down_no_counterpart);
    if (!settings_.down[id]) return count(&V7Counters::down_not_allowed);
    switch (id) {
    case check_id: return down_check(frame, now);
    case 0x32: return down_place(frame, now);
    case 0x34: return down_ranging(frame, now);
    case waypoint_read:
        if (frame.data().size() != 1) return count(&V7Counters::down_malformed);
        return ask({waypoint_read, frame.data()[0], 0, frame.source(), asked_by(frame.destination())}, now);
    case waypoint: down(frame, id, frame.data(), now, true); return;
    case 0xA1: return down_log_value(frame, now);
    case v8_command: return down_command(frame, frame.data(), now);
    case v8_parameter_command: return down_parameter_command(frame, now);
    case v8_value: return down_parameter_write(frame, now);
    default: down(frame, id, frame.data(), now);
    }
}

bool V7Translation::down(ano::FrameView original, std::uint8_t id, Data data, ano::TimePoint now, bool acknowledged) {
    if (data.empty() || data.size() > settings_.max_data) {
        count(data.empty() ? &V7Counters::down_no_counterpart : &V7Counters::down_too_long);
        return false;
    }
    const std::uint8_t asked = asked_by(original.destination());
    put_to_device(destination_of(id, asked), id, data);
    if (!acknowledged) return true;
    if (settings_.acknowledges_sent) {
        acknowledge(original);
    } else {
        const v7::FrameView sent{std::span{to_device_}.last(v7::overhead + data.size())};
        sent_down_.put({now, id, sent.checks(), original.id(), original.checks(), original.source(), asked});
    }
    return true;
}

void V7Translation::acknowledge(ano::FrameView frame) {
    put_to_hosts(asked_by(frame.destination()), frame.source(), check_id,
                 std::array{frame.id(), frame.checks().sum, frame.checks().add});
}

void V7Translation::down_command(ano::FrameView original, Data command, ano::TimePoint now) {
    if (command.size() < 3 || command.size() > command_size) return count(&V7Counters::down_malformed);
    if (erases_firmware(command)) return count(&V7Counters::down_refused);
    std::array<std::uint8_t, command_size> data{};
    std::copy(command.begin(), command.end(), data.begin());
    down(original, v7_command, data, now, true);
}

void V7Translation::down_place(ano::FrameView frame, ano::TimePoint now) {
    if (frame.data().size() != 12) return count(&V7Counters::down_malformed);
    std::array<std::uint8_t, 12> out;
    for (std::size_t at = 0; at < 12; at += 4) {
        const auto mm = load<std::int32_t>(&frame.data()[at]);
        store(&out[at], mm == no_place ? no_place : mm / 10);
    }
    down(frame, frame.id(), out, now);
}

void V7Translation::down_ranging(ano::FrameView frame, ano::TimePoint now) {
    const Data data = frame.data();
    if (!data.empty() && data[0] == scan) return down_scan(frame, now);
    if (data.size() != 5) return count(&V7Counters::down_malformed);
    const auto mm = load<std::int32_t>(&data[1]);
    if (mm < 0) return count(&V7Counters::down_malformed);
    for (const Ranging& row : ranging_of(settings_.range)) {
        if (row.type != data[0]) continue;
        std::array<std::uint8_t, 7> out;
        out[0] = row.at.direction;
        store(&out[1], row.at.angle);
        store(&out[3], static_cast<std::uint32_t>(mm / 10));
        down(frame, frame.id(), out, now);
        return;
    }
    count(&V7Counters::down_no_counterpart);
}

void V7Translation::down_scan(ano::FrameView frame, ano::TimePoint now) {
    const Data pairs = frame.data().subspan(1);
    if (settings_.range == V7Range::flow) return count(&V7Counters::down_no_counterpart);
    if (pairs.empty() || pairs.size() % 4 != 0 || pairs.size() > 4 * 64) return count(&V7Counters::down_malformed);
    for (std::size_t at = 0; at < pairs.size(); at += 4) {
        const auto angle = static_cast<std::uint16_t>((load<std::uint16_t>(&pairs[at]) + 50) / 100 % 360);
        if (settings_.range == V7Range::lx && angle == 270) {    // the LX code takes it for "down"
            count(&V7Counters::down_no_counterpart);
            continue;
        }
        std::array<std::uint8_t, 7> out{};
        store(&out[1], angle);
        store(&out[3], std::uint32_t{load<std::uint16_t>(&pairs[at + 2])});
        down(frame, frame.id(), out, now);
    }
}

void V7Translation::down_log_value(ano::FrameView frame, ano::TimePoint now) {
    if (frame.data().size() < 4) return count(&V7Counters::down_malformed);
    if (frame.data().size() > settings_.max_data) return count(&V7Counters::down_too_long);
    const float value = load<float>(frame.data().data());
    if (!(std::fabs(value) < 2147483648.0f)) return count(&V7Counters::down_malformed);    // NaN as well
    std::array<std::uint8_t, v7::max_len> out;
    std::copy(frame.data().begin(), frame.data().end(), out.begin());
    store(&out[0], static_cast<std::int32_t>(std::lround(value)));
    down(frame, frame.id(), std::span{out}.first(frame.data().size()), now);
}

// Acknowledges a command of a panel on the line.
void V7Translation::down_check(ano::FrameView frame, ano::TimePoint now) {
    const Data data = frame.data();
    if (data.size() != 3) return count(&V7Counters::down_malformed);
    const auto sent = sent_up_.take(data[0], {data[1], data[2]}, now);
    if (!sent) return count(&V7Counters::down_no_counterpart);
    down(frame, check_id, std::array{sent->original_id, sent->original_checks.sum, sent->original_checks.add}, now);
}

void V7Translation::answer(ano::FrameView question, std::uint8_t id, Data data, ano::TimePoint now) {
    if (!heard_at_ || now - *heard_at_ > heard_within) return count(&V7Counters::down_not_answered);
    put_to_hosts(asked_by(question.destination()), question.source(), id, data);
}

void V7Translation::down_command_query(ano::FrameView frame, ano::TimePoint now) {
    const Data data = frame.data();
    if (data.size() < 3 || data[0] > 1) return count(&V7Counters::down_malformed);
    const auto list = commands_of(asked_by(frame.destination()));
    const auto index = load<std::uint16_t>(&data[1]);
    if (data[0] == 0) {
        std::array<std::uint8_t, 3> out{};
        store(&out[1], static_cast<std::uint16_t>(list.size()));
        return answer(frame, v8_command_query, out, now);
    }
    if (index >= list.size()) return count(&V7Counters::down_no_counterpart);
    const Command& command = list[index];
    std::vector<std::uint8_t> out(5);
    store(&out[0], index);
    std::copy_n(command.bytes, 3, &out[2]);
    for (const std::uint8_t type : value_types_of(command.values)) out.push_back(type);
    append_text(out, command.name, 20);
    append_text(out, command.info);
    answer(frame, v8_command_info, out, now);
}

const V7Parameter* V7Translation::parameter(std::uint16_t index) const noexcept {
    return index < settings_.parameters.size() ? &settings_.parameters[index] : nullptr;
}

std::optional<std::uint16_t> V7Translation::index_of(std::uint16_t number) const noexcept {
    if (settings_.parameters.empty()) return number;
    for (std::size_t i = 0; i < settings_.parameters.size(); ++i)
        if (settings_.parameters[i].number == number) return static_cast<std::uint16_t>(i);
    return std::nullopt;
}

void V7Translation::down_parameter_command(ano::FrameView frame, ano::TimePoint now) {
    const Data data = frame.data();
    if (data.size() < 3) return count(&V7Counters::down_malformed);
    const auto value = load<std::uint16_t>(&data[1]);
    const V7Parameter* const row = parameter(value);
    switch (data[0]) {
    case 0: return answer_info(frame, now);
    case 1: {
        std::array<std::uint8_t, 3> out{1};
        store(&out[1], static_cast<std::uint16_t>(settings_.parameters.size()));
        return answer(frame, v8_parameter_command, out, now);
    }
    case 2:
        if (row == nullptr && !settings_.parameters.empty()) return count(&V7Counters::down_no_counterpart);
        return ask({v7_read, row != nullptr ? row->number : value, value, frame.source(), asked_by(frame.destination())}, now);
    case 3: return answer_description(frame, value, now);
    case 0x10: return down_parameter_action(frame, now);
    default: return count(&V7Counters::down_no_counterpart);
    }
}

void V7Translation::answer_info(ano::FrameView question, ano::TimePoint now) {
    const std::uint8_t asked = asked_by(question.destination());
    const Device* const device = device_of(asked);
    std::vector<std::uint8_t> out(9);
    out[0] = asked;
    for (std::size_t i = 0; i < versions_.size(); ++i)
        store(&out[1 + 2 * i], asked == settings_.address ? versions_[i] : std::uint16_t{});
    store(&out[7], protocol_version);
    append_text(out, device != nullptr ? device->name : "V7 device");
    answer(question, v8_device_info, out, now);
}

void V7Translation::answer_description(ano::FrameView question, std::uint16_t index, ano::TimePoint now) {
    const V7Parameter* const row = parameter(index);
    if (row == nullptr) return count(&V7Counters::down_no_counterpart);
    std::vector<std::uint8_t> out(3);
    store(&out[0], index);
    out[2] = row->is_real ? 8 : 5;    // f32, i32
    append_text(out, row->name, 20);
    append_text(out, std::to_string(row->number));
    if (!row->is_real && row->scale != 1) {
        append_text(out, ", x");
        append_text(out, std::to_string(row->scale));
    }
    answer(question, v8_info, out, now);
}

// Section 8: what the device has a command for; all else it stores by itself.
void V7Translation::down_parameter_action(ano::FrameView frame, ano::TimePoint now) {
    switch (load<std::uint16_t>(&frame.data()[1])) {
    case 0xAA: return down_command(frame, std::array<std::uint8_t, 3>{0x01, 0x00, 0xAC}, now);
    case 0x20: return down_command(frame, std::array<std::uint8_t, 3>{0x01, 0x30, 0x01}, now);
    case 0x30: return down_command(frame, std::array<std::uint8_t, 3>{0x01, 0x30, 0x02}, now);
    case 0xAB:
    case 0x21:
    case 0x31: return answer(frame, check_id, std::array{frame.id(), frame.checks().sum, frame.checks().add}, now);
    default: return count(&V7Counters::down_no_counterpart);
    }
}

void V7Translation::down_parameter_write(ano::FrameView frame, ano::TimePoint now) {
    const Data data = frame.data();
    if (data.size() != 6) return count(&V7Counters::down_malformed);
    const auto index = load<std::uint16_t>(&data[0]);
    const V7Parameter* const row = parameter(index);
    if (row == nullptr && !settings_.parameters.empty()) return count(&V7Counters::down_no_counterpart);
    std::array<std::uint8_t, 6> out;
    store(&out[0], row != nullptr ? row->number : index);
    std::copy_n(&data[2], 4, &out[2]);
    if (row != nullptr && row->is_real) {
        const double wire = double{load<float>(&data[2])} * row->scale;
        if (!(std::fabs(wire) < 2147483647.5)) return count(&V7Counters::down_malformed);
        store(&out[2], static_cast<std::int32_t>(std::lround(wire)));
    }
    down(frame, v7_parameter, out, now, true);
}

// ---- Questions for values

void V7Translation::ask(const Question& question, ano::TimePoint now) {
    const auto end = questions_.begin() + static_cast<std::ptrdiff_t>(question_count_);
    if (std::find(questions_.begin(), end, question) != end) return count(&V7Counters::down_asked_already);
    if (question_count_ == questions_.size()) return count(&V7Counters::down_busy);
    questions_[question_count_++] = question;
    if (question_count_ > 1) return;
    question_sends_ = 0;
    send_question(now);
}

void V7Translation::send_question(ano::TimePoint now) {
    const Question& question = questions_[0];
    std::array<std::uint8_t, 2> data;
    store(&data[0], question.number);
    put_to_device(destination_of(question.id, question.asked), question.id,
                  std::span{data}.first(question.id == v7_read ? 2u : 1u));
    ++question_sends_;
    question_at_ = now;
}

std::optional<ano::TimePoint> V7Translation::deadline() const noexcept {
    if (question_count_ == 0) return std::nullopt;
    return question_at_ + repeat_after;
}

void V7Translation::repeat(ano::TimePoint now) {
    if (question_count_ == 0 || now < question_at_ + repeat_after) return;
    if (settings_.repeats && question_sends_ < sends) {
        count(&V7Counters::repeated);
        return send_question(now);
    }
    count(&V7Counters::unanswered);
    answered(questions_[0].id, questions_[0].number, now);    // the next one
}

// Removes the oldest question that this answers, and sends the next one if it was under way.
std::optional<V7Translation::Question> V7Translation::answered(std::uint8_t id, std::uint16_t number, ano::TimePoint now) {
    const auto end = questions_.begin() + static_cast<std::ptrdiff_t>(question_count_);
    const auto found = std::find_if(questions_.begin(), end, [&](const Question& q) { return q.id == id && q.number == number; });
    if (found == end) return std::nullopt;
    const Question question = *found;
    const bool was_under_way = found == questions_.begin();
    std::move(found + 1, end, found);
    --question_count_;
    if (was_under_way && question_count_ > 0) {
        question_sends_ = 0;
        send_question(now);
    }
    return question;
}

void V7Translation::forget() noexcept {
    to_device_.clear();
    to_hosts_.clear();
    sent_down_.clear();
    sent_up_.clear();
    question_count_ = 0;
    heard_at_.reset();
    alt_bar_.reset();
    alt_fu_.reset();
}

}    // namespace anogate
