#include <mavlink/mission_items.hpp>

#include <algorithm>
#include <cmath>

namespace anogate::mavlink {
namespace {

using Refusal = MissionRefusal;

constexpr std::uint16_t item_waypoint = 16, item_return = 20, item_land = 21, item_take_off = 22, item_speed = 178;
constexpr std::uint16_t to_the_target = 400;
constexpr double degree_1e7 = 1e-7, cm_per_metre = 100;

std::optional<ItemKind> kind_of(const MissionItem& item) noexcept {
    switch (item.command) {
    case item_waypoint: return item.parameters[0] > 0 ? ItemKind::hold : ItemKind::waypoint;
    case item_return: return ItemKind::return_home;
    case item_land: return ItemKind::land;
    case item_take_off: return ItemKind::take_off;
    default: return std::nullopt;
    }
}

std::uint16_t command_of(ItemKind kind) noexcept {
    switch (kind) {
    case ItemKind::return_home: return item_return;
    case ItemKind::land: return item_land;
    case ItemKind::take_off: return item_take_off;
    default: return item_waypoint;
    }
}

bool is_set(float value) noexcept { return !std::isnan(value) && value != 0; }

class Translation {
public:
    explicit Translation(const MissionContext& context) : context_{context} {}

    // std::nullopt: it is expressed.
    std::optional<Refusal> add(const MissionItem& item) {
        if (item.command == item_speed) return change_speed(item);
        const auto kind = kind_of(item);
        const FunRow* row = nullptr;
        if (kind)
            for (const FunRow& one : context_.funs)
                if (one.kind == *kind) row = &one;
        if (row == nullptr && kind == ItemKind::hold)
            return refuse(MissionResult::invalid_parameter_1, "the device can't wait at a waypoint");
        if (row == nullptr)
            return refuse(MissionResult::unsupported, "the device has no waypoint for command " + std::to_string(item.command));
        if (waypoints_.size() == ano::host::last_waypoint) return refuse(MissionResult::no_space, "too many waypoints");
        Waypoint next;
        next.num = static_cast<std::uint8_t>(waypoints_.size() + 1);
        next.spd = speed_;
        next.fun = row->fun;
        if (auto refused = set_details(next, item, *row)) return refused;
        if (auto refused = set_place(next, item, *kind)) return refused;
        waypoints_.push_back(next);
        speed_is_used_ = true;
        return std::nullopt;
    }
    std::vector<Waypoint> take() { return std::move(waypoints_); }
    bool speed_is_used() const noexcept { return speed_is_used_; }

private:
    static Refusal refuse(MissionResult result, std::string text) { return {result, 0, std::move(text)}; }

    std::optional<Refusal> change_speed(const MissionItem& item) {
        constexpr float most = 655.35F;
        const float speed = item.parameters[1];
        if (is_set(item.parameters[2]) && item.parameters[2] > 0)
            return refuse(MissionResult::invalid_parameter_3, "a throttle can't be set");
        if (is_set(item.parameters[3])) return refuse(MissionResult::invalid_parameter_4, "a relative speed can't be set");
        if (!(speed > 0 && speed <= most))
            return refuse(MissionResult::invalid_parameter_2, "the speed must be above 0 and at most 655 m/s");
        speed_ = static_cast<std::uint16_t>(std::lround(cm_per_metre * speed));
        speed_is_used_ = false;
        return std::nullopt;
    }

    static std::optional<Refusal> set_details(Waypoint& next, const MissionItem& item, const FunRow& row) {
        constexpr float longest = 255;
        const auto [hold, radius, pass, yaw] = item.parameters;
        if (item.command == item_waypoint) {
            if (hold < 0 || hold > longest || hold != std::floor(hold))
                return refuse(MissionResult::invalid_parameter_1, "the time must be whole seconds, at most 255");
            if (is_set(radius)) return refuse(MissionResult::invalid_parameter_2, "an acceptance radius can't be set");
            if (is_set(pass)) return refuse(MissionResult::invalid_parameter_3, "passing at a distance can't be set");
        }
        next.yaw = to_the_target;
        if (!std::isnan(yaw) && item.command != item_return)
            next.yaw = static_cast<std::uint16_t>(std::lround(std::fmod(std::fmod(yaw, 360.0F) + 360.0F, 360.0F)) % 360);
        for (std::size_t i = 0; i < next.cmd.size(); ++i)
            next.cmd[i] = row.bytes[i].is_hold_time ? static_cast<std::uint8_t>(std::max(hold, 0.0F)) : row.bytes[i].constant;
        return std::nullopt;
    }

    std::optional<Refusal> set_place(Waypoint& next, const MissionItem& item, ItemKind kind) const {
        constexpr std::int32_t right_angle = 900'000'000, half_turn = 1'800'000'000;
        constexpr std::uint8_t global = 0, relative = 3, global_int = 5, relative_int = 6;
        const bool may_lack_place = kind != ItemKind::waypoint && kind != ItemKind::hold;
        if (kind == ItemKind::return_home || (may_lack_place && item.lat == 0 && item.lng == 0)) {
            next.lat = context_.home.lat;
            next.lng = context_.home.lng;
        } else {
            if (std::abs(std::int64_t{item.lat}) > right_angle) return refuse(MissionResult::invalid_latitude, "not a latitude");
            if (std::abs(std::int64_t{item.lng}) > half_turn) return refuse(MissionResult::invalid_longitude, "not a longitude");
            next.lat = item.lat * degree_1e7;
            next.lng = item.lng * degree_1e7;
        }
        if (kind == ItemKind::return_home) return std::nullopt;
        double height = item.altitude;
        if (item.frame == global || item.frame == global_int) {
            if (!context_.home_altitude)
                return refuse(MissionResult::unsupported_frame,
                              "the altitude of home is not known: use altitudes relative to home");
            height -= *context_.home_altitude;
        } else if (item.frame != relative && item.frame != relative_int) {
            return refuse(MissionResult::unsupported_frame, "the altitude must be above home or above sea level");
        }
        constexpr double highest = 20'000'000;
        if (!(std::abs(height) < highest)) return refuse(MissionResult::invalid_altitude, "not an altitude");
        next.alt = static_cast<std::int32_t>(std::lround(cm_per_metre * height));
        return std::nullopt;
    }

    const MissionContext& context_;
    std::vector<Waypoint> waypoints_;
    std::uint16_t speed_ = 0;    // cm/s; 0: the usual one
    bool speed_is_used_ = true;
};

const FunRow* row_of(const Waypoint& waypoint, std::span<const FunRow> funs) noexcept {
    for (const FunRow& row : funs)
        if (row.fun == waypoint.fun) {
            bool fits = true;
            for (std::size_t i = 0; i < waypoint.cmd.size(); ++i)
                fits = fits && (row.bytes[i].is_hold_time || row.bytes[i].constant == waypoint.cmd[i]);
            if (fits) return &row;
        }
    return nullptr;
}

}    // namespace

std::optional<MissionItem> mission_item(PacketView packet, std::uint16_t& number) noexcept {
    const auto common = [&](const auto& view) {
        number = view.template get<"seq">();
        return MissionItem{view.template get<"frame">(),
                           view.template get<"command">(),
                           {view.template get<"param1">(), view.template get<"param2">(), view.template get<"param3">(),
                            view.template get<"param4">()},
                           0,
                           0,
                           view.template get<"z">()};
    };
    if (const auto item = as<"MISSION_ITEM_INT">(packet)) {
        MissionItem result = common(*item);
        result.lat = item->get<"x">();
        result.lng = item->get<"y">();
        return result;
    }
    if (const auto item = as<"MISSION_ITEM">(packet)) {
        MissionItem result = common(*item);
        constexpr double per_degree = 1e7;
        result.lat = limited<std::int32_t>(per_degree * item->get<"x">());
        result.lng = limited<std::int32_t>(per_degree * item->get<"y">());
        return result;
    }
    return std::nullopt;
}

std::vector<FunRow> usual_funs() { return {{ItemKind::waypoint, 0, {}}, {ItemKind::hold, 1, {ItemByte{true, 0}}}}; }

std::variant<std::vector<Waypoint>, MissionRefusal> waypoints_of(std::span<const MissionItem> items,
                                                                 const MissionContext& context) {
    Translation translation{context};
    for (std::size_t i = 0; i < items.size(); ++i)
        if (auto refused = translation.add(items[i])) {
            refused->item = i;
            return *refused;
        }
    if (!translation.speed_is_used())
        return MissionRefusal{MissionResult::unsupported, items.size() - 1, "no waypoint follows the change of speed"};
    return translation.take();
}

std::vector<MissionItem> items_of(std::span<const Waypoint> waypoints, std::span<const FunRow> funs) {
    constexpr std::uint8_t mission_frame = 2, relative = 3;
    std::vector<MissionItem> items;
    std::uint16_t speed = 0;
    for (const Waypoint& waypoint : waypoints) {
        if (waypoint.num == 0) continue;
        if (waypoint.spd != speed && waypoint.spd != 0)
            items.push_back({mission_frame, item_speed, {1, static_cast<float>(waypoint.spd) / 100, -1, 0}, 0, 0, 0});
        speed = waypoint.spd;
        const FunRow* const row = row_of(waypoint, funs);
        MissionItem item;
        item.frame = relative;
        item.command = row != nullptr ? command_of(row->kind) : item_waypoint;
        for (std::size_t i = 0; row != nullptr && i < waypoint.cmd.size(); ++i)
            if (row->bytes[i].is_hold_time) item.parameters[0] = waypoint.cmd[i];
        item.parameters[3] = waypoint.yaw < 360 ? static_cast<float>(waypoint.yaw) : std::nanf("");
        item.lat = static_cast<std::int32_t>(std::lround(waypoint.lat / degree_1e7));
        item.lng = static_cast<std::int32_t>(std::lround(waypoint.lng / degree_1e7));
        item.altitude = static_cast<float>(waypoint.alt / cm_per_metre);
        items.push_back(item);
    }
    return items;
}

std::uint8_t waypoint_of_item(std::span<const MissionItem> items, std::size_t item) noexcept {
    std::size_t number = 1;
    for (std::size_t i = 0; i < item && i < items.size(); ++i) number += items[i].command == item_speed ? 0u : 1u;
    return static_cast<std::uint8_t>(std::min<std::size_t>(number, ano::host::last_waypoint));
}

}    // namespace anogate::mavlink
