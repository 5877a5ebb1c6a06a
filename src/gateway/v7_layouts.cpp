#include "v7_layouts.hpp"

#include <ano/address.hpp>
#include <ano/wire.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

namespace anogate {
namespace {

namespace v7 = ano::v7;

// The first one of two with the same id in V8 is the usual one.
constexpr std::pair<std::uint8_t, std::uint8_t> v7_and_v8_addresses[]{
    {v7::address::broadcast, ano::address::broadcast},
    {v7::address::host, ano::address::host},
    {v7::address::console, ano::address::host},
    {v7::address::flight_controller, ano::address::flight_controller},
    {v7::address::data_radio, ano::address::data_radio},
    {v7::address::optical_flow, 0xDE},
    {v7::address::imu, 0xDD},
    {v7::address::mcu, 0xDB}};

constexpr std::array<std::uint8_t, 256> v8_addresses = [] {
    std::array<std::uint8_t, 256> all{};
    for (std::size_t a = 0; a < 200; ++a) all[a] = static_cast<std::uint8_t>(a);
    for (const auto& [in_v7, in_v8] : v7_and_v8_addresses) all[in_v7] = in_v8;
    return all;
}();

constexpr std::int32_t no_position = INT32_MIN;

}    // namespace

std::uint8_t v8_address_of(std::uint8_t v7_address) noexcept { return v8_addresses[v7_address]; }

std::uint8_t v7_address_of(std::uint8_t v8_address) noexcept {
    if (ano::address::is_host(v8_address)) return v7::address::host;
    for (const auto& [in_v7, in_v8] : v7_and_v8_addresses)
        if (in_v8 == v8_address) return in_v7;
    return v8_address;
}

V7Acceleration usual_acceleration(std::uint8_t address) noexcept {
    switch (address) {
    case 0xDC: return v7_acc_cmss;
    case 0xDD: return v7_acc_lx;
    case 0xDE: return v7_acc_flow;
    default: return {};
    }
}

std::int16_t saturated(double value) noexcept {
    return static_cast<std::int16_t>(std::lround(std::clamp(value, -32768.0, 32767.0)));
}

void scale_axes(std::uint8_t* data, std::size_t first, double factor) noexcept {
    for (std::size_t at = first; at < first + 6; at += 2)
        ano::store(data + at, saturated(ano::load<std::int16_t>(data + at) * factor));
}

void positions_in_mm(const std::uint8_t* in, std::uint8_t* out) noexcept {
    for (std::size_t at = 0; at < 12; at += 4) {
        const auto cm = ano::load<std::int32_t>(in + at);
        const std::int64_t mm = std::clamp<std::int64_t>(std::int64_t{cm} * 10, INT32_MIN + 1, INT32_MAX);
        ano::store(out + at, cm == no_position ? no_position : static_cast<std::int32_t>(mm));
    }
}

void positions_in_cm(const std::uint8_t* in, std::uint8_t* out) noexcept {
    for (std::size_t at = 0; at < 12; at += 4) {
        const auto mm = ano::load<std::int32_t>(in + at);
        ano::store(out + at, mm == no_position ? mm : mm / 10);
    }
}

std::optional<std::int32_t> log_value_in_v7(const std::uint8_t* val) noexcept {
    const double value = std::round(static_cast<double>(ano::load<float>(val)));
    if (!(value >= INT32_MIN && value <= INT32_MAX)) return std::nullopt;
    return static_cast<std::int32_t>(value);
}

void V7Distance::store(std::uint8_t* data) const noexcept {
    data[0] = direction;
    ano::store(data + 1, angle);
    ano::store(data + 3, cm);
}

std::size_t ranging_in_v8(V7Range range, const std::uint8_t* v7, std::uint8_t* data) noexcept {
    constexpr std::uint8_t none = 0xFF;
    const std::uint8_t direction = v7[0];
    const auto angle = ano::load<std::uint16_t>(v7 + 1);
    const auto cm = ano::load<std::uint32_t>(v7 + 3);
    const auto type = [&]() -> std::uint8_t {
        if (range == V7Range::flow) {
            constexpr std::uint8_t types[]{6, 5, 1, 2, 3, 4};
            return direction < std::size(types) ? types[direction] : none;
        }
        if (direction == 1) return angle == 270 ? 6 : angle == 90 ? 5 : none;
        if (direction != 0 || angle >= 360) return none;
        if (angle == 270) return range == V7Range::lx ? 6 : 3;
        return angle == 0 ? 1 : angle == 180 ? 2 : angle == 90 ? 4 : v8_scan;
    }();
    if (type == none || cm > (type == v8_scan ? UINT16_MAX : INT32_MAX / 10)) return 0;
    data[0] = type;
    if (type == v8_scan) {
        ano::store(data + 1, static_cast<std::uint16_t>(angle * 100));
        ano::store(data + 3, static_cast<std::uint16_t>(cm));
    } else {
        ano::store(data + 1, static_cast<std::int32_t>(cm * 10));
    }
    return 5;
}

std::optional<V7Distance> distance_in_v7(V7Range range, std::uint8_t type, std::int32_t mm) noexcept {
    const bool is_lx = range == V7Range::lx;
    if (type > 6 || mm < 0 || (is_lx && type == 3)) return std::nullopt;
    const auto cm = static_cast<std::uint32_t>(mm / 10);
    constexpr V7Distance directions[]{{1, 270}, {0, 0}, {0, 180}, {0, 270}, {0, 90}, {1, 90}, {1, 270}};
    if (is_lx && (type == 0 || type == 6)) return V7Distance{0, 270, cm};
    return V7Distance{directions[type].direction, directions[type].angle, cm};
}

std::optional<V7Distance> scanned_distance_in_v7(V7Range range, const std::uint8_t* pair) noexcept {
    const auto degrees = static_cast<std::uint16_t>((ano::load<std::uint16_t>(pair) + 50) / 100 % 360);
    if (range == V7Range::lx && degrees == 270) return std::nullopt;    // for `lx` this direction is down
    return V7Distance{0, degrees, ano::load<std::uint16_t>(pair + 2)};
}

}    // namespace anogate
