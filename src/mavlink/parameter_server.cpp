#include <mavlink/parameter_server.hpp>

#include <algorithm>

namespace anogate::mavlink {

void ParameterServer::receive(PacketView packet) {
    const Origin from{packet.system(), packet.component()};
    if (as<"PARAM_REQUEST_LIST">(packet)) return on_list(from);
    if (const auto one = as<"PARAM_REQUEST_READ">(packet))
        return on_read(from, one->get<"param_id">(), one->get<"param_index">());
    if (const auto set = as<"PARAM_SET">(packet))
        on_set(set->get<"param_id">(), set->get<"param_type">(), set->get<"param_value">());
}

// nullptr: too many stations wait.
ParameterServer::Station* ParameterServer::station_of(Origin origin) {
    const auto found = waiting_.find(key(origin));
    if (found != waiting_.end()) return &found->second;
    return waiting_.size() < max_stations ? &waiting_[key(origin)] : nullptr;
}

void ParameterServer::on_list(Origin from) {
    Station* const station = station_of(from);
    if (station == nullptr) return;
    const bool was_waiting = station->wants_list && station->next == 0;
    station->wants_list = true;
    station->next = 0;
    // A list that is repeated before its first value was sent does not need another reading.
    if (!is_read_ || !was_waiting) read();
}

void ParameterServer::on_read(Origin from, std::string_view id, std::int16_t index) {
    if (!is_read_) return read();    // the station asks again
    const auto place = index >= 0 ? std::optional{static_cast<std::size_t>(index)} : table_.find(id);
    Station* const station = station_of(from);
    if (station == nullptr) return;
    if (place && *place < table_.rows().size() && station->single.size() < table_.rows().size() &&
        std::find(station->single.begin(), station->single.end(), *place) == station->single.end())
        station->single.push_back(*place);
    if (station->single.empty() && !station->wants_list) waiting_.erase(key(from));
}

void ParameterServer::on_set(std::string_view id, std::uint8_t type_number, float value) {
    const auto place = is_read_ ? table_.find(id) : std::nullopt;
    if (!is_read_) read();
    if (!place) return;
    const ParameterTable::Row& row = table_.rows()[*place];
    const auto number = row.type_number == type_number ? value_of(row.type, value) : std::nullopt;
    if (!number || sets_ == max_waiting_sets) {
        output_.report(Severity::warning, row.id + (number ? ": too many values are being written" : ": wrong type of value"));
        return output_.send_to_all(payload_of(*place));
    }
    ++sets_;
    output_.write(row.name, *number, [this, place = *place](std::optional<ano::Number> stored, const std::string& error) {
        was_written(place, stored, error);
    });
}

void ParameterServer::read() {
    if (is_reading_) return;
    is_reading_ = true;
    output_.read(
        [this](std::vector<DeviceParameter> parameters, const std::string& error) { was_read(std::move(parameters), error); });
}

void ParameterServer::was_read(std::vector<DeviceParameter> parameters, const std::string& error) {
    is_reading_ = false;
    if (!error.empty()) {
        output_.report(Severity::warning, "parameters: " + error);
        return waiting_.clear();
    }
    table_ = ParameterTable{parameters};
    is_read_ = true;
    if (table_.left_out().empty() || std::exchange(told_left_out_, true)) return;
    std::string names;
    for (const std::string& name : table_.left_out()) names += (names.empty() ? "" : ", ") + name;
    output_.report(Severity::info, "not shown, because MAVLink can't carry them: " + names);
}

void ParameterServer::was_written(std::size_t place, std::optional<ano::Number> stored, const std::string& error) {
    --sets_;
    if (place >= table_.rows().size()) return;
    const auto value = stored ? bytewise(table_.rows()[place].type, *stored) : std::nullopt;
    if (value) table_.set(place, *value);
    else output_.report(Severity::error, table_.rows()[place].id + ": " + (error.empty() ? "not written" : error));
    output_.send_to_all(payload_of(place));
}

Payload ParameterServer::payload_of(std::size_t place) const {
    const ParameterTable::Row& row = table_.rows()[place];
    Draft<"PARAM_VALUE"> draft;
    draft.set_text<"param_id">(row.id).set<"param_value">(row.value).set<"param_type">(row.type_number);
    return draft.set<"param_count">(table_.rows().size()).set<"param_index">(place);
}

std::optional<Payload> ParameterServer::next(Origin origin) {
    const auto found = waiting_.find(key(origin));
    if (found == waiting_.end() || is_reading_ || !is_read_) return std::nullopt;
    Station& station = found->second;
    std::optional<Payload> payload;
    if (!station.single.empty()) {
        if (station.single.front() < table_.rows().size()) payload = payload_of(station.single.front());
        station.single.pop_front();
    } else if (station.wants_list && station.next < table_.rows().size()) {
        payload = payload_of(station.next++);
    }
    if (station.single.empty() && station.next >= table_.rows().size()) station.wants_list = false;
    if (station.single.empty() && !station.wants_list) waiting_.erase(found);
    return payload;
}

}    // namespace anogate::mavlink
