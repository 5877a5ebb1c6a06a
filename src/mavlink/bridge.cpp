#include <mavlink/bridge.hpp>

#include <ano/address.hpp>
#include <ano/typed.hpp>
#include <ano_json/shown_text.hpp>
#include <client/gateway_socket.hpp>
#include <mavlink/command_executions.hpp>
#include <mavlink/mission_server.hpp>
#include <mavlink/parameter_server.hpp>
#include <mavlink/telemetry_schedule.hpp>

#include <algorithm>
#include <cmath>

namespace anogate::mavlink {
namespace {

constexpr std::size_t max_stations = 64, parameters_at_once = 4;
constexpr std::uint8_t all_systems = 0, all_components = 0;

std::uint16_t key_of(Origin origin) noexcept { return static_cast<std::uint16_t>(origin.system << 8 | origin.component); }

// The target of a message that has one; all_systems: none.
Origin target_of(PacketView packet) noexcept {
    const Message& row = *find_message(packet.id());
    const auto byte = [&](std::string_view name) -> std::uint8_t {
        const Field* const field = row.field(name);
        return field != nullptr && field->offset < packet.payload().size() ? packet.payload()[field->offset] : std::uint8_t{0};
    };
    return {row.field("target") != nullptr ? byte("target") : byte("target_system"), byte("target_component")};
}

// Whether a message without a target is for all vehicles: it only asks.
bool may_be_for_all(PacketView packet) noexcept {
    const std::uint32_t id = packet.id();
    return id == id_of<"PARAM_REQUEST_LIST"> || id == id_of<"REQUEST_DATA_STREAM"> || id == id_of<"PING"> ||
           id == id_of<"TIMESYNC">;
}

constexpr std::pair<Action, Activity> shown_activities[] = {{Action::take_off, Activity::take_off},
                                                            {Action::land, Activity::land},
                                                            {Action::return_home, Activity::return_home},
                                                            {Action::go_to, Activity::go_to},
                                                            {Action::start_mission, Activity::mission}};
// The numbers of sim:fc for commands by name; 0x06 shows numbers.
constexpr std::pair<Action, Cid> numbers_by_name[] = {{Action::take_off, {0x10, 0, 1}},
                                                      {Action::land, {0x10, 0, 2}},
                                                      {Action::return_home, {0x10, 0, 10}},
                                                      {Action::go_to, {0x10, 0, 8}},
                                                      {Action::start_mission, {0x10, 0, 12}}};

std::vector<ActivityCommand> activities_of(const std::vector<CommandRow>& rows) {
    std::vector<ActivityCommand> all;
    for (const auto& [action, activity] : shown_activities) {
        const CommandRow* const row = find_row(rows, action);
        if (row == nullptr) continue;
        if (row->cid) all.push_back({*row->cid, activity});
        for (const auto& [by_name, cid] : numbers_by_name)
            if (!row->cid && by_name == action) all.push_back({cid, activity});
    }
    return all;
}

}    // namespace

struct MavlinkBridge::Vehicle {
    MavlinkDevice settings;
    std::vector<CommandRow> commands;
    VehicleState state{};
    VehicleIdentity identity{};
    StickControl sticks;
    std::uint16_t texts = 0;
    std::unique_ptr<CommandExecutions> executions{};
    std::unique_ptr<ParameterServer> parameters{};
    std::unique_ptr<MissionServer> missions{};
    std::optional<Origin> logged{};    // the station that steers it
    ano::TimePoint mission_sent_at{};
};

struct MavlinkBridge::PerVehicle {
    TelemetrySchedule schedule;
    std::uint8_t sequence = 0;
    std::vector<std::uint32_t> sent = std::vector<std::uint32_t>(
        telemetry_rows().size());    // TelemetryRow::version() of what was sent
};

struct MavlinkBridge::Connection {
    std::size_t number = 0;
    ConnectionKind kind;
    PacketParser parser;
    bool is_greeted = false;    // a station sent its HEARTBEAT
    Version version = Version::v2;
    std::map<std::uint8_t, PerVehicle> vehicles{};    // by system id
    std::map<std::uint16_t, SequenceWatch> stations{};
    std::deque<std::pair<const Vehicle*, Payload>> waiting{};
    LinkCounters link{};
    ano::TimePoint received_at{};
};

MavlinkBridge::MavlinkBridge(const MavlinkSettings& settings, BridgeOutput& output, ano::TimePoint now,
                             const std::optional<SigningKey>& key)
    : output_{output},
      autopilot_{settings.autopilot},
      start_{now},
      now_{now},
      timed_at_{now},
      decoding_{std::make_shared<const Decoding>()},
      key_{key} {
    if (key_) signatures_.emplace(*key_);
    for (const MavlinkDevice& device : settings.devices) {
        vehicles_.push_back(std::unique_ptr<Vehicle>{
            new Vehicle{device, device.command_rows(), VehicleState{}, VehicleIdentity{}, StickControl{device.sticks()}}});
        set_up(*vehicles_.back());
    }
}

MavlinkBridge::~MavlinkBridge() = default;

void MavlinkBridge::set_up(Vehicle& vehicle) {
    const std::uint8_t address = vehicle.settings.address;
    vehicle.identity.autopilot = autopilot_;
    vehicle.identity.type = static_cast<std::uint8_t>(vehicle.settings.type);
    vehicle.identity.cells = static_cast<std::uint8_t>(vehicle.settings.cells);
    vehicle.identity.activities = activities_of(vehicle.commands);
    vehicle.identity.has_missions = true;
    const StickSettings sticks = vehicle.settings.sticks();
    vehicle.identity.has_attitude_target = sticks.accepts_input(StickInput::attitude);
    vehicle.identity.has_velocity_target = sticks.accepts_input(StickInput::velocity);
    vehicle.executions = std::make_unique<CommandExecutions>(
        [this, &vehicle](const StationCommand& command, const CommandExecutions::Done& done) {
            carry_out(vehicle, command, done);
        },
        [this, &vehicle](const StationCommand& command, Result result) {
            Draft<"COMMAND_ACK"> draft;
            draft.set<"command">(command.command).set<"result">(static_cast<std::uint8_t>(result)).set<"progress">(0xFF);
            answer(command.from, vehicle,
                   draft.set<"target_system">(command.from.system).set<"target_component">(command.from.component));
        });
    const auto reports = [this, &vehicle](Severity severity, const std::string& text) { report(vehicle, severity, text); };
    const auto to_all = [this, &vehicle](const Payload& payload) { send_to_all(vehicle, payload); };
    vehicle.parameters = std::make_unique<ParameterServer>(
        ParameterServer::Output{[this, address](auto done) {
                                    request(parameters_request(address), [done](const http::Outcome& outcome) {
                                        auto all = is_success(outcome) ? parameters_in(outcome.answer.body) : std::nullopt;
                                        if (all) done(std::move(*all), "");
                                        else done({}, fault_of(outcome));
                                    });
                                },
                                [this, address](const std::string& name, const ano::Number& value, auto done) {
                                    request(parameter_request(address, name, value), [done](const http::Outcome& outcome) {
                                        if (is_success(outcome)) done(stored_value_in(outcome.answer.body), "");
                                        else done(std::nullopt, fault_of(outcome));
                                    });
                                },
                                reports, to_all});
    MissionServer::Output missions;
    missions.read = [this, address](const MissionServer::Output::Read& done) {
        request(waypoints_request(address), [done](const http::Outcome& outcome) {
            auto all = is_success(outcome) ? waypoints_in(outcome.answer.body) : std::nullopt;
            if (all) done(std::move(*all), "");
            else done({}, fault_of(outcome));
        });
    };
    missions.write = [this, address](const std::vector<Waypoint>& waypoints, const MissionServer::Output::Written& done) {
        request(put_waypoints_request(address, waypoints),
                [done](const http::Outcome& outcome) { done(is_success(outcome) ? "" : fault_of(outcome)); });
    };
    if (find_row(vehicle.commands, Action::clear_mission) != nullptr)
        missions.clear = [this, &vehicle, address](const MissionServer::Output::Written& done) {
            const auto command = command_for(*find_row(vehicle.commands, Action::clear_mission), {});
            request(call_request(address, *command),
                    [done](const http::Outcome& outcome) { done(is_success(outcome) ? "" : fault_of(outcome)); });
        };
    missions.fly_from = [this, &vehicle, address](std::uint8_t first) {
        const FlightMode* const mode = vehicle.state.mode.at(now_);
        const CommandRow* const row = find_row(vehicle.commands, Action::start_mission);
        if (row == nullptr || mode == nullptr || mode->safety != FlightMode::Safety::airborne) return;
        Wish wish;
        wish.first = first;
        if (const auto command = command_for(*row, wish)) request(call_request(address, *command), [](const http::Outcome&) {});
    };
    missions.send = [this, &vehicle](Origin station, const Payload& payload) { answer(station, vehicle, payload); };
    missions.send_to_all = to_all;
    missions.report = reports;
    vehicle.missions = std::make_unique<MissionServer>(vehicle.settings.funs, std::move(missions));
}

std::uint64_t MavlinkBridge::since_start_us(ano::TimePoint now) const noexcept {
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now - start_).count());
}

TelemetryContext MavlinkBridge::context_of(const Connection& connection, const Vehicle& vehicle, ano::TimePoint now) const {
    return {vehicle.state, vehicle.identity, connection.link, now, since_start_us(now), output_.unix_us()};
}

void MavlinkBridge::request(DeviceRequest what, const std::function<void(const http::Outcome&)>& done) {
    if (output_.request(std::move(what), done)) return;
    http::Outcome outcome;
    outcome.fault = "too many requests are waiting; try again later";
    done(outcome);
}

MavlinkBridge::Vehicle* MavlinkBridge::vehicle_of(std::string_view link, std::uint8_t address) noexcept {
    for (const auto& vehicle : vehicles_)
        if (vehicle->settings.address == address && (vehicle->settings.link.empty() || vehicle->settings.link == link))
            return vehicle.get();
    return nullptr;
}

void MavlinkBridge::receive(std::string_view link, const FrameRecord& record, ano::TimePoint now) {
    now_ = now;
    if (record.direction != Direction::in || record.is_elsewhere) return;
    Vehicle* const vehicle = vehicle_of(link, record.frame.source());
    if (vehicle == nullptr) return;
    vehicle->state.set_signs(decoding_->attitude(link));
    const ano::Reading reading = ano::read(record.frame, &decoding_->layouts());
    vehicle->state.receive(reading, now);
    on_text(*vehicle, link, record);
    if (const auto info = ano::as<"device_info">(record.frame)) {
        vehicle->identity.hardware = info->get<"hw_ver">();
        vehicle->identity.software = info->get<"sw_ver">();
    }
    if (ano::is_flexible(record.frame.id()))
        for (const Payload& payload : named_values(reading, since_start_us(now))) send_to_all(*vehicle, payload);
    const Fix* const fix = record.frame.id() == ano::id_of<"gps"> ? vehicle->state.fix.at(now) : nullptr;
    if (fix == nullptr || connections_.empty()) return;
    if (const auto& home = vehicle->state.home()) vehicle->missions->set_home_altitude(home->altitude);
    const double* const height = vehicle->state.height.at(now);
    constexpr double degree_1e7 = 1e-7;
    if (height != nullptr && activity_of(context_of(*connections_.begin()->second, *vehicle, now)) == Activity::mission)
        vehicle->missions->on_place(fix->lat * degree_1e7, fix->lng * degree_1e7, *height);
}

void MavlinkBridge::on_text(Vehicle& vehicle, std::string_view link, const FrameRecord& record) {
    constexpr std::uint8_t red = 1, blue = 3;
    const ano::Encoding encoding = encodings_.of(record.frame, link, true, decoding_.get());
    if (const auto text = ano::as<"log">(record.frame)) {
        const std::uint8_t color = text->get<"color">();
        const Severity severity = color == red ? Severity::error : color == blue ? Severity::notice : Severity::info;
        return report(vehicle, severity, ano::display_text(text->get<"str">(), encoding));
    }
    if (const auto value = ano::as<"log_value">(record.frame))
        report(vehicle, Severity::info,
               ano::number_text(ano::widened(value->get<"val">())) + " " + ano::display_text(value->get<"str">(), encoding));
}

void MavlinkBridge::report(Vehicle& vehicle, Severity severity, const std::string& text) {
    if (++vehicle.texts == 0) ++vehicle.texts;
    for (const Payload& part : status_texts(severity, text, vehicle.texts)) send_to_all(vehicle, part);
}

std::size_t MavlinkBridge::open(ConnectionKind kind, ano::TimePoint now) {
    const std::size_t number = next_connection_++;
    auto& connection = connections_[number];
    const Transport transport = kind.transport;
    connection.reset(new Connection{number, std::move(kind), PacketParser{transport}});
    for (const auto& vehicle : vehicles_)
        connection->vehicles.emplace(vehicle->settings.system, PerVehicle{TelemetrySchedule{now}});
    return number;
}

void MavlinkBridge::close(std::size_t connection) {
    connections_.erase(connection);
    std::erase_if(where_, [&](const auto& station) { return station.second == connection; });
}

void MavlinkBridge::on_bytes(std::size_t number, std::span<const std::uint8_t> bytes, ano::TimePoint now) {
    const auto found = connections_.find(number);
    if (found == connections_.end()) return;
    Connection& connection = *found->second;
    now_ = connection.received_at = now;
    while (!bytes.empty()) {
        const auto room = connection.parser.prepare();
        const std::size_t n = std::min(room.size(), bytes.size());
        std::copy_n(bytes.begin(), n, room.begin());
        connection.parser.commit(n);
        bytes = bytes.subspan(n);
        read_packets(connection, now);
    }
    if (connection.kind.is_datagram) {
        connection.parser.give_up();
        read_packets(connection, now);
    }
    pump(connection, now);
}

void MavlinkBridge::on_quiet(std::size_t number, ano::TimePoint now) {
    const auto found = connections_.find(number);
    if (found == connections_.end() || found->second->parser.waiting() == 0) return;
    found->second->parser.give_up();
    read_packets(*found->second, now);
}

void MavlinkBridge::read_packets(Connection& connection, ano::TimePoint now) {
    while (const auto packet = connection.parser.next()) on_packet(connection, *packet, now);
    connection.link.bad = connection.parser.counters().bad_crc;
}

void MavlinkBridge::on_packet(Connection& connection, PacketView packet, ano::TimePoint now) {
    constexpr std::uint8_t ground_station = 6;
    const Origin from{packet.system(), packet.component()};
    for (const auto& vehicle : vehicles_)
        if (vehicle->settings.system == from.system) {
            ++counters_.forged;
            return;
        }
    if (signatures_ && !signatures_->accepts(packet, signing_time(output_.unix_us()))) {
        ++counters_.unsigned_packets;
        return;
    }
    const auto heartbeat = as<"HEARTBEAT">(packet);
    if (heartbeat && heartbeat->get<"type">() == ground_station && !std::exchange(connection.is_greeted, true))
        output_.log("ground station " + std::to_string(from.system) + " on " + connection.kind.name);
    if (!connection.is_greeted) {
        ++counters_.unexpected;
        return;
    }
    if (!connection.stations.contains(key_of(from)) && connection.stations.size() == max_stations) return;
    ++connection.link.received;
    connection.link.lost += connection.stations[key_of(from)].on_packet(packet.sequence());
    if (heartbeat && heartbeat->get<"type">() == ground_station) connection.version = packet.version();
    if (where_.size() < max_stations || where_.contains(key_of(from))) where_[key_of(from)] = connection.number;
    const Origin target = target_of(packet);
    if (target.component != all_components && target.component != component) return;
    for (const auto& vehicle : vehicles_)
        if (target.system == vehicle->settings.system || (target.system == all_systems && may_be_for_all(packet)))
            on_message(connection, *vehicle, packet, now);
}

void MavlinkBridge::on_message(Connection& connection, Vehicle& vehicle, PacketView packet, ano::TimePoint now) {
    if (const auto command = station_command(packet)) return on_command(connection, vehicle, *command, now);
    if (const auto m = as<"REQUEST_DATA_STREAM">(packet)) {
        connection.vehicles.at(vehicle.settings.system)
            .schedule.set_stream(m->get<"req_stream_id">(), m->get<"req_message_rate">(), m->get<"start_stop">() != 0, now);
        return;
    }
    if (const auto m = as<"PING">(packet)) {
        Draft<"PING"> draft;
        draft.set<"time_usec">(m->get<"time_usec">()).set<"seq">(m->get<"seq">());
        return answer(connection, vehicle,
                      draft.set<"target_system">(packet.system()).set<"target_component">(packet.component()));
    }
    if (const auto m = as<"TIMESYNC">(packet); m && m->get<"tc1">() == 0)
        return answer(connection, vehicle,
                      Draft<"TIMESYNC">{}.set<"tc1">(1000 * since_start_us(now)).set<"ts1">(m->get<"ts1">()));
    std::uint8_t unused = 0;
    if (stick_input(packet, unused)) return on_sticks(vehicle, packet, now);
    vehicle.parameters->receive(packet);
    vehicle.missions->receive(packet, now);
}

void MavlinkBridge::on_command(Connection& connection, Vehicle& vehicle, const StationCommand& command, ano::TimePoint now) {
    if (const auto result = own_command(connection, vehicle, command, now)) {
        Draft<"COMMAND_ACK"> draft;
        draft.set<"command">(command.command).set<"result">(static_cast<std::uint8_t>(*result)).set<"progress">(0xFF);
        return answer(connection, vehicle,
                      draft.set<"target_system">(command.from.system).set<"target_component">(command.from.component));
    }
    vehicle.executions->receive(command, now);
}

// What is answered without the device; repeating it is harmless.
std::optional<Result> MavlinkBridge::own_command(Connection& connection, Vehicle& vehicle, const StationCommand& command,
                                                 ano::TimePoint now) {
    TelemetrySchedule& schedule = connection.vehicles.at(vehicle.settings.system).schedule;
    const auto id = command.parameters[0] >= 0 && command.parameters[0] < 1e7 ? static_cast<std::uint32_t>(command.parameters[0])
                                                                              : 0xFFFFFFu;
    const auto make = [&](std::uint32_t message) {
        bool is_known = false;
        for (const TelemetryRow& row : telemetry_rows()) {
            if (row.id != message) continue;
            if (const auto payload = row.make(context_of(connection, vehicle, now))) {
                answer(connection, vehicle, *payload);
                is_known = true;
            }
        }
        return is_known                             ? Result::accepted
               : find_telemetry(message) != nullptr ? Result::temporarily_rejected
                                                    : Result::unsupported;
    };
    switch (static_cast<Command>(command.command)) {
    case Command::request_message: return make(id);
    case Command::request_capabilities: return make(id_of<"AUTOPILOT_VERSION">);
    case Command::request_protocol_version: return make(id_of<"PROTOCOL_VERSION">);
    case Command::get_home_position: return make(id_of<"HOME_POSITION">);
    case Command::set_message_interval:
        return schedule.set_interval(id, command.parameters[1], now) ? Result::accepted : Result::unsupported;
    case Command::get_message_interval:
        answer(connection, vehicle,
               Draft<"MESSAGE_INTERVAL">{}.set<"message_id">(id).set<"interval_us">(schedule.interval_us(id)));
        return Result::accepted;
    default: return std::nullopt;
    }
}

void MavlinkBridge::carry_out(Vehicle& vehicle, const StationCommand& command, const std::function<void(Result)>& done) {
    CommandContext context{autopilot_, vehicle.state.home(), {}};
    if (const Vector* const position = vehicle.state.position.at(now_)) context.position = *position;
    auto answer_or_wish = wish_of(command, context);
    if (const auto* result = std::get_if<Result>(&answer_or_wish)) return done(*result);
    auto& wish = std::get<Wish>(answer_or_wish);
    if (wish.action == Action::start_mission && command.parameters[0] == 0) wish.first = vehicle.missions->first_waypoint();
    const CommandRow* const row = find_row(vehicle.commands, wish.action);
    if (row == nullptr) return done(Result::unsupported);
    const auto device_command = command_for(*row, wish);
    if (!device_command) return done(Result::denied);
    request(call_request(vehicle.settings.address, *device_command), [this, &vehicle, done](const http::Outcome& outcome) {
        const Result result = result_of(outcome);
        if (result != Result::accepted) report(vehicle, Severity::warning, fault_of(outcome));
        done(result);
    });
}

void MavlinkBridge::on_sticks(Vehicle& vehicle, PacketView packet, ano::TimePoint now) {
    StickFrame frame;
    // If the loop was stopped, the packet may have waited since then.
    constexpr ano::Duration usual = std::chrono::milliseconds{100};
    const ano::TimePoint received_at = now - timed_at_ > usual ? timed_at_ : now;
    const StickFault fault = vehicle.sticks.receive(packet, received_at, now, vehicle.state, frame);
    ++counters_.sticks[static_cast<std::size_t>(fault)];
    if (fault != StickFault::none) return;
    const auto station = vehicle.sticks.station(now);
    if (station != vehicle.logged)
        output_.log("system " + std::to_string(vehicle.settings.system) + " is steered by station " +
                    std::to_string(station->system));
    vehicle.logged = station;
    send(vehicle, frame);
}

bool MavlinkBridge::send(const Vehicle& vehicle, const StickFrame& frame) {
    std::array<std::uint8_t, 64> bytes{};
    std::size_t size = 0;
    if (const auto* sticks = std::get_if<ChannelFrame>(&frame)) {
        ano::Draft<"remote_control"> draft;
        const auto& c = sticks->channels;
        const bool is_set = draft.set<"rol">(c[0]) && draft.set<"pit">(c[1]) && draft.set<"thr">(c[2]) &&
                            draft.set<"yaw">(c[3]) && draft.set<"aux1">(c[4]) && draft.set<"aux2">(c[5]) &&
                            draft.set<"aux3">(c[6]) && draft.set<"aux4">(c[7]) && draft.set<"aux5">(c[8]) &&
                            draft.set<"aux6">(c[9]);
        if (is_set) size = draft.encode(bytes, ano::address::host, vehicle.settings.address);
    } else {
        const auto& r = std::get<RealtimeFrame>(frame);
        ano::Draft<"realtime_control"> draft;
        const bool is_set = draft.set<"ctrl_rol">(r.roll) && draft.set<"ctrl_pit">(r.pitch) &&
                            draft.set<"ctrl_thr">(r.throttle) && draft.set<"ctrl_yaw_dps">(r.yaw_rate) &&
                            draft.set<"ctrl_spd_x">(r.x) && draft.set<"ctrl_spd_y">(r.y) && draft.set<"ctrl_spd_z">(r.z);
        if (is_set) size = draft.encode(bytes, ano::address::host, vehicle.settings.address);
    }
    return size > 0 && output_.send({bytes.data(), size});
}

void MavlinkBridge::answer(Connection& connection, const Vehicle& vehicle, const Payload& payload) {
    if (connection.waiting.size() < max_waiting) connection.waiting.emplace_back(&vehicle, payload);
}

void MavlinkBridge::answer(Origin station, const Vehicle& vehicle, const Payload& payload) {
    const auto where = where_.find(key_of(station));
    const auto found = where == where_.end() ? connections_.end() : connections_.find(where->second);
    if (found != connections_.end()) answer(*found->second, vehicle, payload);
}

void MavlinkBridge::send_to_all(const Vehicle& vehicle, const Payload& payload) {
    for (const auto& [number, connection] : connections_)
        if (connection->is_greeted) answer(*connection, vehicle, payload);
}

bool MavlinkBridge::transmit(Connection& connection, const Vehicle& vehicle, const Payload& payload) {
    std::array<std::uint8_t, max_packet> bytes{};
    PerVehicle& own = connection.vehicles.at(vehicle.settings.system);
    const Version version = key_ ? Version::v2 : connection.version;
    const Origin origin{vehicle.settings.system, component};
    std::size_t size = encode(bytes, version, origin, own.sequence, *payload.row, payload.payload(),
                              key_ ? flag_signed : std::uint8_t{0});
    if (size == 0) return true;    // version 1 has no such message
    if (key_) {
        size += signature_size;
        signed_at_ = std::max(signed_at_ + 1, signing_time(output_.unix_us()));
        sign(std::span{bytes}.first(size), *key_, static_cast<std::uint8_t>(connection.number), signed_at_);
    }
    if (!output_.transmit(connection.number, std::span{bytes}.first(size))) return false;
    ++own.sequence;
    ++connection.link.sent;
    return true;
}

// Answers, then parameters, then telemetry.
void MavlinkBridge::pump(Connection& connection, ano::TimePoint now) {
    while (!connection.waiting.empty()) {
        if (!transmit(connection, *connection.waiting.front().first, connection.waiting.front().second)) return;
        connection.waiting.pop_front();
    }
    for (const auto& vehicle : vehicles_) {
        for (const auto& [key, watch] : connection.stations) {
            const Origin station{static_cast<std::uint8_t>(key >> 8), static_cast<std::uint8_t>(key & 0xFFu)};
            for (std::size_t i = 0; i < parameters_at_once && vehicle->parameters->waits(station); ++i) {
                const auto payload = vehicle->parameters->next(station);
                if (!payload) break;
                if (!transmit(connection, *vehicle, *payload)) return answer(connection, *vehicle, *payload);
            }
        }
        if (!pump_telemetry(connection, *vehicle, now)) return;
    }
}

bool MavlinkBridge::pump_telemetry(Connection& connection, Vehicle& vehicle, ano::TimePoint now) {
    PerVehicle& own = connection.vehicles.at(vehicle.settings.system);
    if (!connection.is_greeted && !connection.kind.speaks_first) return true;
    const auto is_fresh = [&](std::size_t place) {
        const TelemetryRow& row = telemetry_rows()[place];
        if (!connection.is_greeted && row.id != id_of<"HEARTBEAT">) return false;
        return !row.has_sources() || row.version(vehicle.state) != own.sent[place];
    };
    while (const auto place = own.schedule.next(now, is_fresh)) {
        const TelemetryRow& row = telemetry_rows()[*place];
        const auto payload = row.make(context_of(connection, vehicle, now));
        if (payload && !transmit(connection, vehicle, *payload)) return false;
        own.schedule.on_sent(*place, now);
        own.sent[*place] = row.version(vehicle.state);
    }
    return true;
}

void MavlinkBridge::on_time(ano::TimePoint now) {
    constexpr ano::Duration second = std::chrono::seconds{1};
    now_ = timed_at_ = now;
    for (const auto& vehicle : vehicles_) {
        vehicle->missions->on_time(now);
        if (const auto stop = vehicle->sticks.on_time(now, vehicle->state)) send(*vehicle, *stop);
        if (vehicle->logged && !vehicle->sticks.station(now)) vehicle->logged.reset();
        if (now - vehicle->mission_sent_at < second) continue;
        vehicle->mission_sent_at = now;
        send_to_all(*vehicle, vehicle->missions->current());
    }
    for (const auto& [number, connection] : connections_) pump(*connection, now);
}

}    // namespace anogate::mavlink
