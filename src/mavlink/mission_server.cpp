#include <mavlink/mission_server.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace anogate::mavlink {
namespace {

constexpr std::uint8_t of_mission = 0;    // MAV_MISSION_TYPE; fences and rally points are others

std::uint16_t station_key(Origin station) noexcept { return static_cast<std::uint16_t>(station.system << 8 | station.component); }

}    // namespace

void MissionServer::receive(PacketView packet, ano::TimePoint now) {
    const Origin from{packet.system(), packet.component()};
    if (const auto m = as<"MISSION_COUNT">(packet)) return on_count(from, m->get<"count">(), m->get<"mission_type">(), now);
    if (const auto m = as<"MISSION_REQUEST_LIST">(packet)) return on_request_list(from, m->get<"mission_type">());
    if (const auto m = as<"MISSION_REQUEST_INT">(packet)) return on_request(from, m->get<"seq">(), false);
    if (const auto m = as<"MISSION_REQUEST">(packet)) return on_request(from, m->get<"seq">(), packet.version() == Version::v1);
    if (const auto m = as<"MISSION_CLEAR_ALL">(packet)) return on_clear(from, m->get<"mission_type">());
    if (const auto m = as<"MISSION_SET_CURRENT">(packet)) return on_set_current(from, m->get<"seq">());
    if (const auto m = as<"MISSION_WRITE_PARTIAL_LIST">(packet))
        return on_partial_write(from, m->get<"start_index">(), m->get<"end_index">(), m->get<"mission_type">(), now);
    if (const auto m = as<"MISSION_REQUEST_PARTIAL_LIST">(packet))
        return on_partial_read(from, m->get<"start_index">(), m->get<"end_index">(), m->get<"mission_type">());
    if (as<"MISSION_ACK">(packet)) {
        downloads_.erase(station_key(from));
        if (upload_ && upload_->station == from && !upload_->is_writing) upload_.reset();    // it cancels
        return;
    }
    std::uint16_t number = 0;
    if (const auto item = mission_item(packet, number)) on_item(from, number, *item, now);
}

void MissionServer::acknowledge(Origin to, MissionResult result, std::uint8_t type) {
    Draft<"MISSION_ACK"> draft;
    draft.set<"target_system">(to.system).set<"target_component">(to.component).set<"type">(static_cast<std::uint8_t>(result));
    output_.send(to, draft.set<"mission_type">(type));
}

// Whether this station may write; one at a time.
bool MissionServer::begin(Origin from) {
    if (upload_ && (upload_->station != from || upload_->is_writing)) {
        acknowledge(from, MissionResult::denied);
        return false;
    }
    upload_ = Upload{};
    upload_->station = from;
    upload_->number = ++uploads_;
    return true;
}

void MissionServer::on_count(Origin from, std::uint16_t count, std::uint8_t type, ano::TimePoint now) {
    if (type != of_mission) return acknowledge(from, MissionResult::unsupported, type);
    if (count == 0) return on_clear(from, type);
    if (count > max_items) return acknowledge(from, MissionResult::no_space);
    if (!begin(from)) return;
    upload_->items.resize(count);
    upload_->end = count;
    request(now);
}

void MissionServer::on_partial_write(Origin from, int first, int last, std::uint8_t type, ano::TimePoint now) {
    if (type != of_mission) return acknowledge(from, MissionResult::unsupported, type);
    if (last < 0) last = static_cast<int>(items_.size()) - 1;
    if (first < 0 || last < first || static_cast<std::size_t>(last) >= items_.size())
        return acknowledge(from, MissionResult::invalid_sequence);
    if (!begin(from)) return;
    upload_->items = items_;
    upload_->is_partial = true;
    upload_->next = upload_->first = static_cast<std::uint16_t>(first);
    upload_->end = static_cast<std::uint16_t>(last + 1);
    request(now);
}

void MissionServer::request(ano::TimePoint now) {
    Upload& upload = *upload_;
    if (upload.requests++ == max_requests) return end(MissionResult::cancelled, "the station stopped sending items");
    upload.due = now + patience;
    Draft<"MISSION_REQUEST_INT"> draft;
    draft.set<"target_system">(upload.station.system).set<"target_component">(upload.station.component);
    output_.send(upload.station, draft.set<"seq">(upload.next));
}

void MissionServer::on_time(ano::TimePoint now) {
    if (upload_ && !upload_->is_writing && now >= upload_->due) request(now);
}

// Others than the one that is requested were repeated on the way.
void MissionServer::on_item(Origin from, std::uint16_t number, const MissionItem& item, ano::TimePoint now) {
    if (!upload_ || upload_->station != from || upload_->is_writing || number != upload_->next) return;
    Upload& upload = *upload_;
    upload.items[number] = item;
    upload.requests = 0;
    if (++upload.next < upload.end) return request(now);
    complete();
}

// The device's own list is read first: for HOME, and because waypoints can't be removed one by one.
void MissionServer::complete() {
    upload_->is_writing = true;
    output_.read([this, number = upload_->number](const std::vector<Waypoint>& stored, const std::string& error) {
        if (!upload_ || upload_->number != number) return;
        if (!error.empty()) return end(MissionResult::error, error);
        write(stored);
    });
}

void MissionServer::write(const std::vector<Waypoint>& stored) {
    MissionContext context{funs_, {}, home_altitude_};
    for (const Waypoint& one : stored)
        if (one.num == 0) context.home = one;
    const auto translated = waypoints_of(upload_->items, context);
    if (const auto* refused = std::get_if<MissionRefusal>(&translated))
        return end(refused->result, "mission item " + std::to_string(refused->item) + ": " + refused->text);
    const auto& waypoints = std::get<std::vector<Waypoint>>(translated);
    const auto more = std::count_if(stored.begin(), stored.end(),
                                    [&](const Waypoint& one) { return one.num > waypoints.size(); });
    if (more == 0) return put(waypoints);
    if (!output_.clear)
        return end(MissionResult::denied, "the device has " + std::to_string(more) + " more waypoints and can't remove them");
    output_.clear([this, number = upload_->number, waypoints](const std::string& error) {
        if (!upload_ || upload_->number != number) return;
        if (!error.empty()) return end(MissionResult::error, error);
        put(waypoints);
    });
}

void MissionServer::put(const std::vector<Waypoint>& waypoints) {
    output_.write(waypoints, [this, number = upload_->number](const std::string& error) {
        if (!upload_ || upload_->number != number) return;
        if (!error.empty()) return end(MissionResult::error, error);
        items_ = upload_->items;
        current_ = 0;
        reached_.reset();
        end(MissionResult::accepted, "");
    });
}

void MissionServer::end(MissionResult result, const std::string& text) {
    const Origin station = upload_->station;
    upload_.reset();
    if (!text.empty()) output_.report(Severity::error, text);
    acknowledge(station, result);
}

void MissionServer::on_clear(Origin from, std::uint8_t type) {
    if (type != of_mission) return acknowledge(from, MissionResult::unsupported, type);
    if (!begin(from)) return;
    upload_->is_writing = true;
    if (!output_.clear) return end(MissionResult::unsupported, "the device has no command that removes waypoints");
    output_.clear([this, number = upload_->number](const std::string& error) {
        if (!upload_ || upload_->number != number) return;
        if (error.empty()) items_.clear();
        end(error.empty() ? MissionResult::accepted : MissionResult::error, error);
    });
}

void MissionServer::on_request_list(Origin from, std::uint8_t type) {
    const auto answer = [this, from](std::size_t count, std::uint8_t of_type) {
        Draft<"MISSION_COUNT"> draft;
        draft.set<"target_system">(from.system).set<"target_component">(from.component).set<"count">(count);
        output_.send(from, draft.set<"mission_type">(of_type));
    };
    if (type != of_mission) return answer(0, type);
    if (downloads_.size() >= max_downloads && !downloads_.contains(station_key(from)))
        return acknowledge(from, MissionResult::denied);
    output_.read([this, from, answer](const std::vector<Waypoint>& stored, const std::string& error) {
        if (!error.empty()) {
            output_.report(Severity::error, "mission: " + error);
            return acknowledge(from, MissionResult::error);
        }
        items_ = items_of(stored, funs_);
        downloads_[station_key(from)] = items_;
        answer(items_.size(), of_mission);
    });
}

void MissionServer::on_request(Origin from, std::uint16_t number, bool wants_floats) { send_item(from, number, wants_floats); }

void MissionServer::send_item(Origin to, std::uint16_t number, bool in_floats) {
    const auto found = downloads_.find(station_key(to));
    const auto& items = found != downloads_.end() ? found->second : items_;
    if (number >= items.size()) return acknowledge(to, MissionResult::invalid_sequence);
    const MissionItem& item = items[number];
    const auto fill = [&](auto draft) {
        draft.template set<"target_system">(to.system).template set<"target_component">(to.component).template set<"seq">(number);
        draft.template set<"frame">(item.frame).template set<"command">(item.command).template set<"autocontinue">(1);
        draft.template set<"current">(number == current_ ? 1 : 0)
            .template set<"param1">(item.parameters[0])
            .template set<"param2">(item.parameters[1]);
        draft.template set<"param3">(item.parameters[2])
            .template set<"param4">(item.parameters[3])
            .template set<"z">(item.altitude);
        return draft;
    };
    constexpr double degree_1e7 = 1e-7;
    if (in_floats)
        output_.send(to, fill(Draft<"MISSION_ITEM">{}).set<"x">(item.lat * degree_1e7).set<"y">(item.lng * degree_1e7));
    else output_.send(to, fill(Draft<"MISSION_ITEM_INT">{}).set<"x">(item.lat).set<"y">(item.lng));
}

void MissionServer::on_partial_read(Origin from, int first, int last, std::uint8_t type) {
    if (type != of_mission) return acknowledge(from, MissionResult::unsupported, type);
    if (last < 0) last = static_cast<int>(items_.size()) - 1;
    if (first < 0 || last < first || static_cast<std::size_t>(last) >= items_.size())
        return acknowledge(from, MissionResult::invalid_sequence);
    for (int number = first; number <= last; ++number) send_item(from, static_cast<std::uint16_t>(number), false);
}

void MissionServer::on_set_current(Origin from, std::uint16_t number) {
    if (number >= items_.size()) return acknowledge(from, MissionResult::invalid_sequence);
    current_ = number;
    output_.fly_from(first_waypoint());
    output_.send_to_all(current());
}

Payload MissionServer::current() const {
    constexpr std::uint8_t no_mission = 1, not_started = 2;
    Draft<"MISSION_CURRENT"> draft;
    draft.set<"seq">(current_).set<"total">(items_.size());
    return draft.set<"mission_state">(items_.empty() ? no_mission : not_started);
}

// Devices do not report which waypoint they fly to: it is reached when the vehicle is there.
void MissionServer::on_place(double lat, double lng, double height) {
    constexpr double degree_1e7 = 1e-7, near = 1.5;
    constexpr std::uint16_t change_of_speed = 178;
    while (current_ < items_.size() && items_[current_].command == change_of_speed) ++current_;
    if (current_ >= items_.size()) return;
    const MissionItem& item = items_[current_];
    const double north = (lat - item.lat * degree_1e7) * metres_per_degree;
    const double east = (lng - item.lng * degree_1e7) * metres_per_degree * std::cos(lat * std::numbers::pi / 180);
    if (std::hypot(north, east) > near || std::abs(height - double{item.altitude}) > near) return;
    if (reached_ != current_) output_.send_to_all(Draft<"MISSION_ITEM_REACHED">{}.set<"seq">(current_));
    reached_ = current_;
    if (current_ + 1 == items_.size()) return;
    ++current_;
    output_.send_to_all(current());
}

}    // namespace anogate::mavlink
