#include "v7_tables.hpp"

#include <gateway/v7_translation.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <set>
#include <string>
#include <system_error>
#include <utility>

namespace anogate {
namespace {

// clang-format off
// Not among them: 01 20 AA, which erases the firmware of an LX IMU.
constexpr V7Command v7_command_rows[] = {
    {{0x01, 0x00, 0x01}, {0, 0, 0}, "CALIBRATE_ACC", "Keep the device level and still"},
    {{0x01, 0x00, 0x02}, {0, 0, 0}, "CALIBRATE_GYRO", "Keep the device still"},
    {{0x01, 0x00, 0x03}, {0, 0, 0}, "CALIBRATE_LEVEL", "Keep the device level and still"},
    {{0x01, 0x00, 0x04}, {0, 0, 0}, "CALIBRATE_COMPASS", "Turn the device around all axes"},
    {{0x01, 0x00, 0x05}, {0, 0, 0}, "CALIBRATE_ACC_6_SIDE", "Place the device on each of its six sides"},
    {{0x01, 0x00, 0x10}, {0, 0, 0}, "RESET_ATTITUDE", ""},
    {{0x01, 0x00, 0x61}, {0, 0, 0}, "STORE_WAYPOINTS", ""},
    {{0x01, 0x00, 0x62}, {0, 0, 0}, "CLEAR_WAYPOINTS", ""},
    {{0x01, 0x00, 0xAA}, {0, 0, 0}, "DEFAULT_PID", ""},
    {{0x01, 0x00, 0xAB}, {0, 0, 0}, "DEFAULT_PARAMETERS", ""},
    {{0x01, 0x00, 0xAC}, {0, 0, 0}, "RESTORE_DEFAULTS", ""},
    {{0x01, 0x01, 0x01}, {1, 0, 0}, "MODE", "0 attitude, 1 with height hold, 2 position hold, 3 program"},
    {{0x01, 0x10, 0x02}, {0, 0, 0}, "FLOW_RESET_ATTITUDE", ""},
    {{0x01, 0x10, 0x03}, {0, 0, 0}, "FLOW_RESET_MOTION", ""},
    {{0x01, 0x10, 0x04}, {0, 0, 0}, "FLOW_PAUSE", "Pauses the correction of the optical flow sensor"},
    {{0x01, 0x30, 0x01}, {0, 0, 0}, "BEGIN_ACC_CAL", "Calibration by the host begins: clears the accelerometer's"},
    {{0x01, 0x30, 0x02}, {0, 0, 0}, "BEGIN_COMPASS_CAL", "Calibration by the host begins: clears the compass's"},
    {{0x01, 0x30, 0x11}, {0, 0, 0}, "BEGIN_ACC_CAL_AGAIN", ""},
    {{0x10, 0x00, 0x01}, {0, 0, 0}, "UNLOCK", ""},
    {{0x10, 0x00, 0x02}, {0, 0, 0}, "LOCK", "Emergency stop: the motors stop at once"},
    {{0x10, 0x00, 0x04}, {0, 0, 0}, "HOVER", ""},
    {{0x10, 0x00, 0x05}, {3, 0, 0}, "TAKE_OFF", "Height in cm, 0 to 500; 0: default. Not in mode 0"},
    {{0x10, 0x00, 0x06}, {0, 0, 0}, "LAND", "Not in mode 0"},
    {{0x10, 0x00, 0x07}, {0, 0, 0}, "RETURN_HOME", "Mode 3 only"},
    {{0x10, 0x00, 0x08}, {3, 0, 0}, "FLIP", "Direction in degrees, 1 to 360. Mode 3 only"},
    {{0x10, 0x00, 0x09}, {0, 0, 0}, "ORBIT", "Mode 3 only"},
    {{0x10, 0x00, 0x0A}, {1, 0, 0}, "HEADLESS", "0 off, 1 on"},
    {{0x10, 0x00, 0x60}, {0, 0, 0}, "WAYPOINTS", "Mode 3 only"},
    {{0x10, 0x00, 0x61}, {0, 0, 0}, "WAYPOINTS_PAUSE", "Mode 3 only"},
    {{0x10, 0x00, 0x62}, {0, 0, 0}, "WAYPOINTS_CANCEL", "Mode 3 only"},
    {{0x10, 0x01, 0x01}, {6, 6, 0}, "GO_TO", "x and y in cm, -100000 to 100000. Mode 3 only"},
    {{0x10, 0x01, 0x02}, {6, 0, 0}, "GO_TO_HEIGHT", "cm, -100000 to 100000. Mode 3 only"},
    {{0x10, 0x02, 0x01}, {3, 3, 0}, "UP", "cm, 0 to 10000; cm/s, 10 to 300. Mode 3 only"},
    {{0x10, 0x02, 0x02}, {3, 3, 0}, "DOWN", "cm, 0 to 10000; cm/s, 10 to 300. Mode 3 only"},
    {{0x10, 0x02, 0x03}, {3, 3, 3}, "MOVE", "cm, cm/s, degrees clockwise from the nose. Mode 3 only"},
    {{0x10, 0x02, 0x07}, {3, 3, 0}, "TURN_LEFT", "Degrees, 0 to 359; degrees/s, 5 to 90. Mode 3 only"},
    {{0x10, 0x02, 0x08}, {3, 3, 0}, "TURN_RIGHT", "Degrees, 0 to 359; degrees/s, 5 to 90. Mode 3 only"},
    {{0x10, 0x03, 0x01}, {6, 6, 0}, "GO_TO_PLACE", "Longitude and latitude, degrees x 10000000. Mode 3 only"},
};
// clang-format on

struct NamedRow {
    std::uint16_t number;
    const char* name;
    std::uint32_t scale = 1;
};

constexpr NamedRow device_rows[] = {{1, "HW_TYPE"}, {2, "HW_VERSION"}, {3, "SW_VERSION"}, {4, "BOOT_VERSION"}};
constexpr NamedRow tkz_rows[] = {
    {65, "GAIN_1"},
    {66, "GAIN_2"},
    {67, "GAIN_3"},
    {68, "PID_MODE"},
    {71, "RC_MODE"},
    {72, "UNLOCK_PWM"},
    {73, "UNLOCK_STICK"},
    {74, "GYRO_AUTO_CAL"},
    {75, "BATTERY_CELLS"},
    {76, "LOW_VOLT_WARN", 100},
    {77, "LOW_VOLT_RETURN", 100},
    {78, "LOW_VOLT_LAND", 100},
    {79, "CENTRE_X"},
    {80, "CENTRE_Y"},
    {81, "CENTRE_Z"},
    {82, "TAKEOFF_HEIGHT"},
    {83, "TAKEOFF_SPEED"},
    {84, "LAND_SPEED"},
    {85, "LAND_SPEED_MAX"},
    {86, "AUTO_LAND"},
    {87, "HEATER_ON"},
    {88, "HEATER_TEMP"},
    {89, "SPEED_HOR"},
    {90, "SPEED_RC"},
    {91, "SPEED_UP"},
    {92, "SPEED_DOWN"},
    {94, "SAFE_ATTITUDE"},
    {95, "MAG_MODE"},
    {96, "RATE_LIMIT_ROL"},
    {97, "RATE_LIMIT_PIT"},
    {98, "RATE_LIMIT_YAW"},
    {99, "RETURN_HEIGHT"},
    {100, "RETURN_SPEED"},
};
constexpr NamedRow lx_rows[] = {
    {151, "GYR_FILTER"},   {152, "ACC_FILTER"}, {153, "FUSION_ATT"},   {154, "FUSION_MAG"}, {155, "FUSION_HOR"},
    {156, "FUSION_VER"},   {157, "FENCE_MODE"}, {158, "FENCE_RADIUS"}, {159, "FENCE_X"},    {160, "FENCE_Y"},
    {161, "FENCE_HEIGHT"}, {162, "COM1_BAUD"},  {163, "COM2_BAUD"},    {164, "COM2_MODE"},  {165, "RGB_OUT"},
};
// Of the output periods in ms, from parameter 300 on.
constexpr const char* period_ids[] = {"01", "02", "03", "04", "05", "06", "07", "08", "09", "0A", "0B",
                                      "0C", "0D", "0E", "20", "21", "30", "32", "33", "34", "40", "41"};
// From parameter 1000 on, in the order in which V8 hosts look for them.
constexpr const char* calibration_names[] = {"CAL_AOFF_X", "CAL_AOFF_Y", "CAL_AOFF_Z", "CAL_ASEN_X", "CAL_ASEN_Y", "CAL_ASEN_Z",
                                             "CAL_AEM1_X", "CAL_AEM1_Y", "CAL_AEM1_Z", "CAL_AEM2_X", "CAL_AEM2_Y", "CAL_AEM2_Z",
                                             "CAL_AEM3_X", "CAL_AEM3_Y", "CAL_AEM3_Z", "CAL_MOFF_X", "CAL_MOFF_Y", "CAL_MOFF_Z",
                                             "CAL_MSEN_X", "CAL_MSEN_Y", "CAL_MSEN_Z"};
constexpr std::size_t first_of_matrix = 6, end_of_matrix = 15;

void add_rows(std::vector<V7Parameter>& to, std::span<const NamedRow> rows) {
    for (const NamedRow& row : rows) to.push_back({row.number, row.name, row.scale});
}

constexpr std::size_t max_rows = 2000, max_parameter_name = 20;    // a name in 0xE2 has 20 bytes

std::string_view trimmed(std::string_view text) noexcept {
    constexpr std::string_view blanks = " \t\r";
    const std::size_t first = text.find_first_not_of(blanks);
    return first == text.npos ? std::string_view{} : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

template <class Number>
bool read_number(std::string_view word, Number& number) noexcept {
    const char* const end = word.data() + word.size();
    const auto [last, error] = std::from_chars(word.data(), end, number);
    return error == std::errc{} && last == end;
}

std::string parse_parameter(std::string_view line, V7Parameter& row) {
    std::array<std::string_view, 4> words;
    std::size_t count = 0;
    for (bool more = true; more; ++count) {
        if (count == words.size()) return "more than NUMBER, NAME, SCALE, TYPE";
        const std::size_t comma = line.find(',');
        more = comma != line.npos;
        words[count] = trimmed(line.substr(0, comma));
        if (more) line.remove_prefix(comma + 1);
    }
    if (!read_number(words[0], row.number)) return "NUMBER must be 0 to 65535";
    row.name = words[1];
    if (row.name.empty() || row.name.size() > max_parameter_name)
        return "NAME must have 1 to " + std::to_string(max_parameter_name) + " bytes";
    if (count > 2 && (!read_number(words[2], row.scale) || row.scale == 0)) return "SCALE must be 1 to 4294967295";
    if (count > 3 && words[3] != "i32" && words[3] != "f32") return "TYPE must be i32 or f32";
    row.as_f32 = words[3] == "f32";
    return {};
}

void add_calibration(std::vector<V7Parameter>& to) {
    for (std::size_t i = 0; i < std::size(calibration_names); ++i) {
        const bool is_of_matrix = i >= first_of_matrix && i < end_of_matrix;
        to.push_back({static_cast<std::uint16_t>(1000 + i), calibration_names[i], is_of_matrix ? 100'000u : 1000u, true});
    }
}

}    // namespace

std::span<const V7Command> v7_commands() noexcept { return v7_command_rows; }

std::string parse_v7_parameters(std::string_view text, std::vector<V7Parameter>& rows) {
    std::set<std::uint16_t> numbers;
    rows.clear();
    for (std::size_t line = 1; !text.empty(); ++line) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view words = trimmed(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        if (words.empty() || words.front() == '#') continue;
        V7Parameter row;
        std::string wrong = parse_parameter(words, row);
        if (wrong.empty() && !numbers.insert(row.number).second)
            wrong = "the number " + std::to_string(row.number) + " occurs twice";
        if (wrong.empty() && rows.size() == max_rows) wrong = "more than " + std::to_string(max_rows) + " parameters";
        if (!wrong.empty()) return "line " + std::to_string(line) + ": " + wrong;
        rows.push_back(std::move(row));
    }
    return rows.empty() ? "no parameters in it" : "";
}

std::vector<V7Parameter> v7_lx_parameters() {
    std::vector<V7Parameter> all;
    add_rows(all, device_rows);
    add_rows(all, lx_rows);
    for (std::size_t i = 0; i < std::size(period_ids); ++i)
        all.push_back({static_cast<std::uint16_t>(300 + i), std::string{"PERIOD_"} + period_ids[i]});
    add_calibration(all);
    return all;
}

std::vector<V7Parameter> v7_tkz_parameters() {
    std::vector<V7Parameter> all;
    add_rows(all, device_rows);
    for (std::uint16_t pid = 0; pid < 18; ++pid)
        for (std::uint16_t part = 0; part < 3; ++part)
            all.push_back(
                {static_cast<std::uint16_t>(11 + 3 * pid + part), "PID" + std::to_string(pid + 1) + '_' + "PID"[part], 1000});
    add_rows(all, tkz_rows);
    add_calibration(all);
    return all;
}

}    // namespace anogate
