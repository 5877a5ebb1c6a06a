// V7Translation: from hosts to the device.
#include "v7_layouts.hpp"
#include "v7_tables.hpp"

#include <gateway/v7_translation.hpp>

#include <ano/address.hpp>
#include <ano/wire.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

namespace anogate {

namespace v7 = ano::v7;

namespace {

constexpr std::uint16_t v7_action = 0x10, v8_protocol_version = 800;
constexpr std::uint16_t first_version = 2;    // parameters 2, 3 and 4: hardware, software, boot

// 0xC0 is translated and 0xC1 is answered by the gateway. 0xE2, a description in V8, is a value in V7.
constexpr bool has_no_counterpart(std::uint8_t id) noexcept {
    return id == 0xE2 || (v7::table::is_new_in_v8(id) && id != 0xC0 && id != 0xC1);
}

// `size` bytes, filled with zeros behind the text.
void append_string(std::string_view text, std::uint8_t* at, std::size_t size) noexcept {
    const std::size_t n = std::min(text.size(), size);
    std::copy_n(text.begin(), n, at);
    std::fill(at + n, at + size, std::uint8_t{0});
}

}    // namespace

std::uint8_t V7Translation::receiver(std::uint8_t asked, std::uint8_t v7_id) const noexcept {
    if (settings_.v7_address) return *settings_.v7_address;
    if (v7_id != 0xE1 && v7_id != 0xE2) return v7::address::broadcast;
    switch (asked) {
    case 0xDC: return v7::address::flight_controller;
    case 0xDD: return v7::address::imu;
    case 0xDB: return v7::address::mcu;
    case 0xDE: return v7::address::optical_flow;
    case 0xE6: return v7::address::data_radio;
    default: return v7::address::broadcast;
    }
}

V7Translation::Origin V7Translation::origin_of(ano::FrameView frame) const noexcept {
    const std::uint8_t to = frame.destination();
    return {frame.source(), is_own_id(to) ? to : settings_.address, frame.id(), frame.checks()};
}

// A frame for an unknown address is sent to every place. A V8 device ignores it there; a V7 device would execute it, because the
// frame that it gets has no such receiver.
bool V7Translation::is_for_device(std::uint8_t destination) const noexcept {
    const bool is_port = destination != ano::address::unassigned && destination == settings_.port_id;
    return destination == ano::address::broadcast || is_port || is_own_id(destination);
}

bool V7Translation::reaches_only(std::uint8_t asked, std::uint8_t v7_id) const noexcept {
    return asked == settings_.address || (!settings_.v7_address && receiver(asked, v7_id) != v7::address::broadcast);
}

void V7Translation::down(ano::FrameView frame, ano::TimePoint now, V7Output& output) {
    const std::uint8_t id = frame.id();
    const Data data = frame.data();
    now_ = now;
    if (is_of_own_sensor(id)) return drop(&V7Counters::down_own_sensor);
    if (has_no_counterpart(id)) return drop(&V7Counters::down_no_counterpart);
    if (!settings_.down[id == 0xC1 ? 0xC0 : id]) return drop(&V7Counters::down_not_allowed);
    if (!is_for_device(frame.destination())) return drop(&V7Counters::down_other_device);
    if (data.empty()) return drop(&V7Counters::down_malformed);
    const Origin origin = origin_of(frame);
    switch (id) {
    case 0x00: return drop(&V7Counters::down_unmatched);    // the device sent no command
    case 0x32: return position_down(origin.asked, data, output);
    case 0x34: return ranging_down(origin.asked, data, output);
    case 0x60:
    case 0x61: return waypoint_down(origin, data, now, output);
    case 0xA1: return log_value_down(origin.asked, data, output);
    case 0xC0: return command_down(origin, data, now, output);
    case 0xC1: return describe_commands(origin, data, output);
    case 0xE0: return parameter_command_down(origin, data, now, output);
    case 0xE1: return parameter_value_down(origin, data, now, output);
    case 0x40:
    case 0x41:
        if (!reaches_only(origin.asked, id)) return drop(&V7Counters::down_other_device);
        [[fallthrough]];
    default: return send_down(origin.asked, id, data, output);
    }
}

// The only way to the device: whatever was translated above, these two laws hold.
bool V7Translation::send_down(Data bytes, V7Output& output) {
    const v7::FrameView frame{bytes};
    if (needs_probe(frame.id())) send_probe(output);
    auto nested = nested_.add(bytes);
    if (nested == V7NestedFrames::Found::begun_before) {    // a probe between the two takes them apart
        send_probe(output);
        nested = nested_.add(bytes);
    }
    if (nested != V7NestedFrames::Found::nothing) {
        drop(nested_.is_erasing() ? &V7Counters::down_erase : &V7Counters::down_own_sensor);
        return false;
    }
    ++counters_.down;
    echoes_.sent(frame, now_);
    output.to_device(frame);
    return true;
}

// If a link with a host program is connected with this one, what is sent arrives there, and would be sent again. A command or
// write acts in each round, so none depends on a probe before it that the line may have damaged.
bool V7Translation::needs_probe(std::uint8_t v7_id) const noexcept {
    const bool has_programs = settings_.lines && settings_.lines->of_programs > 0;
    if (!has_programs) return !V7EchoWatch::asks_or_acts(v7_id) && echoes_.is_probe_due(now_);
    return v7_id == 0xE0 || v7_id == 0xE2 || v7_id == 0x61 || echoes_.is_probe_due(now_);
}

void V7Translation::send_probe(V7Output& output) {
    if (settings_.max_data < V7EchoWatch::probe_data) return;
    const auto send = [&](v7::FrameView probe) {
        if (nested_.add(probe.bytes()) != V7NestedFrames::Found::nothing) return;
        ++counters_.down;
        output.to_device(probe);
    };
    if (settings_.lines && settings_.lines->times_passed_on != times_passed_on_) {
        times_passed_on_ = settings_.lines->times_passed_on;
        send(v7::FrameView{V7EchoWatch::probe_of(settings_.lines->passed_on)});
    }
    if (const auto probe = echoes_.probe(now_)) send(*probe);
}

void V7Translation::send_down(std::uint8_t v8_destination, std::uint8_t id, Data data, V7Output& output) {
    if (data.size() > settings_.max_data) return drop(&V7Counters::down_too_big);
    send_down(Data{v7_}.first(v7::encode(v7_, receiver(v8_destination, id), id, data)), output);
}

// Not one of the requests that wait for each other: an emergency stop is sent at once.
void V7Translation::command_down(const Origin& origin, Data data, ano::TimePoint now, V7Output& output) {
    if (data.size() < 3) return drop(&V7Counters::down_malformed);
    if (v7_erases_firmware(data)) return drop(&V7Counters::down_erase);
    if (!reaches_only(origin.asked, 0xE0)) return drop(&V7Counters::down_other_device);
    if (data.size() > v7_command_size || v7_command_size > settings_.max_data) return drop(&V7Counters::down_too_big);
    std::array<std::uint8_t, v7_command_size> command{};
    std::copy(data.begin(), data.end(), command.begin());
    const std::size_t size = v7::encode(v7_, receiver(origin.asked, 0xE0), 0xE0, command);
    const v7::FrameView frame{Data{v7_}.first(size)};
    if (settings_.ack == V7Ack::device) expect(to_host_, {0xE0, frame.checks(), origin, now, true});
    if (send_down(frame.bytes(), output) && settings_.ack == V7Ack::sent) acknowledge(origin, output);
}

void V7Translation::waypoint_down(const Origin& origin, Data data, ano::TimePoint now, V7Output& output) {
    constexpr std::size_t waypoint_size = 22;
    if (origin.id == 0x60) return ask(origin, 0x60, data.first(1), data[0], data[0], now, output);
    if (data.size() < waypoint_size) return drop(&V7Counters::down_malformed);
    ask(origin, 0x61, data.first(waypoint_size), data[0], data[0], now, output);
}

void V7Translation::parameter_command_down(const Origin& origin, Data data, ano::TimePoint now, V7Output& output) {
    if (data.size() < 3) return drop(&V7Counters::down_malformed);
    const auto value = ano::load<std::uint16_t>(data.data() + 1);
    switch (data[0]) {
    case 0: return describe_device(origin, now, output);
    case 1: {
        std::uint8_t count[]{1, 0, 0};
        ano::store(count + 1, static_cast<std::uint16_t>(parameters_of(origin.asked).size()));
        return answer(origin, 0xE0, count, output);
    }
    case 2:
        if (const auto number = number_of(origin, value)) {
            std::uint8_t bytes[2];
            ano::store(bytes, *number);
            ask(origin, 0xE1, bytes, *number, value, now, output);
        }
        return;
    case 3: return describe_parameter(origin, value, output);
    case v7_action: return parameter_action_down(origin, value, now, output);
    default: return drop(&V7Counters::down_no_counterpart);
    }
}

void V7Translation::parameter_action_down(const Origin& origin, std::uint16_t action, ano::TimePoint now, V7Output& output) {
    switch (action) {
    case 0xAA: return command_down(origin, std::array<std::uint8_t, 3>{0x01, 0x00, 0xAC}, now, output);
    case 0x20: return command_down(origin, std::array<std::uint8_t, 3>{0x01, 0x30, 0x01}, now, output);
    case 0x30: return command_down(origin, std::array<std::uint8_t, 3>{0x01, 0x30, 0x02}, now, output);
    // The device stores by itself: parameters after some seconds, a calibration with its last parameter.
    case 0xAB:
    case 0x21:
    case 0x31:
        if (is_present(now)) acknowledge(origin, output);
        return;
    default: return drop(&V7Counters::down_no_counterpart);
    }
}

void V7Translation::parameter_value_down(const Origin& origin, Data data, ano::TimePoint now, V7Output& output) {
    if (data.size() < 6) return drop(&V7Counters::down_malformed);
    const auto index = ano::load<std::uint16_t>(data.data());
    const auto number = number_of(origin, index);
    if (!number) return;
    auto value = ano::load<std::int32_t>(data.data() + 2);
    const auto rows = parameters_of(origin.asked);
    if (!rows.empty() && rows[index].as_f32) {
        const double wire = std::round(static_cast<double>(ano::load<float>(data.data() + 2)) * rows[index].scale);
        if (!(wire >= INT32_MIN && wire <= INT32_MAX)) return drop(&V7Counters::down_unrepresentable);
        value = static_cast<std::int32_t>(wire);
    }
    std::uint8_t bytes[6];
    ano::store(bytes, *number);
    ano::store(bytes + 2, value);
    ask(origin, 0xE2, bytes, *number, index, now, output);
}

// The number of the parameter in the device; std::nullopt, and counted: the table has no such row.
std::optional<std::uint16_t> V7Translation::number_of(const Origin& origin, std::uint16_t index) noexcept {
    const auto rows = parameters_of(origin.asked);
    if (rows.empty()) return index;
    if (index < rows.size()) return rows[index].number;
    drop(&V7Counters::down_no_counterpart);
    return std::nullopt;
}

// --- Answers of the gateway

void V7Translation::answer(const Origin& origin, std::uint8_t id, Data data, V7Output& output) {
    const auto frame = std::span{v8_}.first(ano::overhead + data.size());
    ano::encode(frame, origin.asked, origin.host, id, data);
    ++counters_.answered;
    output.from_device(ano::FrameView{frame});
}

void V7Translation::acknowledge(const Origin& origin, V7Output& output) {
    const std::uint8_t check[]{origin.id, origin.checks.sum, origin.checks.add};
    answer(origin, 0x00, check, output);
}

void V7Translation::describe_commands(const Origin& origin, Data data, V7Output& output) {
    if (data.size() < 3) return drop(&V7Counters::down_malformed);
    const auto commands = v7_commands();
    const auto number = ano::load<std::uint16_t>(data.data() + 1);
    if (data[0] == 0) {
        std::uint8_t count[]{0, 0, 0};
        ano::store(count + 1, static_cast<std::uint16_t>(commands.size()));
        return answer(origin, 0xC1, count, output);
    }
    if (data[0] != 1 || number >= commands.size()) return drop(&V7Counters::down_no_counterpart);
    const V7Command& command = commands[number];
    std::array<std::uint8_t, 128> info{};
    ano::store(info.data(), number);
    std::copy(command.id.begin(), command.id.end(), info.begin() + 2);
    std::copy(command.types.begin(), command.types.end(), info.begin() + 5);
    append_string(command.name, info.data() + 13, 20);
    const std::size_t text = std::min(command.info.size(), info.size() - 33);
    append_string(command.info, info.data() + 33, text);
    answer(origin, 0xC2, Data{info}.first(33 + text), output);
}

void V7Translation::describe_parameter(const Origin& origin, std::uint16_t index, V7Output& output) {
    constexpr std::uint8_t i32 = 5, f32 = 8;
    const auto rows = parameters_of(origin.asked);
    if (!rows.empty() && index >= rows.size()) return drop(&V7Counters::down_no_counterpart);
    const V7Parameter unlisted{.number = index, .name = {}};    // without a table, the index is the number
    const V7Parameter& row = rows.empty() ? unlisted : rows[index];
    std::array<std::uint8_t, 80> info{};
    ano::store(info.data(), index);
    info[2] = row.as_f32 ? f32 : i32;
    append_string(row.name, info.data() + 3, 20);
    std::size_t size = 23;
    const auto add_text = [&](std::string_view text) {
        append_string(text, info.data() + size, text.size());
        size += text.size();
    };
    const auto add_number = [&](std::uint32_t number) {
        std::array<char, 10> digits;
        std::size_t first = digits.size();
        do digits[--first] = static_cast<char>('0' + number % 10);
        while ((number /= 10) > 0);
        add_text({digits.data() + first, digits.size() - first});
    };
    add_text("number ");
    add_number(row.number);
    if (row.scale != 1 && !row.as_f32) {
        add_text(", value x ");
        add_number(row.scale);
    }
    answer(origin, 0xE2, Data{info}.first(size), output);
}

// Asks the device for the versions that are not known yet, or for all if it may be another one. They are never stated in part:
// a host would take the device for another one when they change.
void V7Translation::describe_device(const Origin& origin, ano::TimePoint now, V7Output& output) {
    if (has_waiting(origin)) {
        ++counters_.merged;
        return;
    }
    const bool is_same = versions_of_ == origin.asked && is_present(now);
    if (!reaches_only(origin.asked, 0xE1)) {
        versions_of_ = origin.asked;
        versions_.fill({0, true});
        if (is_present(now)) send_device_info(origin, output);
        return;
    }
    if (is_same && are_versions_known()) return send_device_info(origin, output);
    if (size_ + versions_.size() > queue_.size()) return drop(&V7Counters::down_queue_full);
    if (!is_same) versions_ = {};
    for (std::size_t i = 0; i < versions_.size(); ++i) {
        if (versions_[i].known) continue;
        const auto number = static_cast<std::uint16_t>(first_version + i);
        std::uint8_t bytes[2];
        ano::store(bytes, number);
        Request request = request_of(origin, 0xE1, bytes, number);
        request.is_own = true;
        queued(size_++) = request;
    }
    begin_next(now, output);
}

// A request of describe_device() ended. One without an answer ends the others.
void V7Translation::end_own_request(const Request& ended, std::optional<std::int32_t> value, ano::TimePoint now,
                                    V7Output& output) {
    if (versions_of_ != ended.origin.asked) versions_ = {};
    versions_of_ = ended.origin.asked;
    const auto is_next = [&] {
        const Request& next = queue_[first_];
        return size_ > 0 && next.is_own && next.origin.asked == ended.origin.asked && next.origin.host == ended.origin.host;
    };
    if (value) {
        // The number of an unused parameter is no version.
        const bool is_version = *value >= 0 && *value <= UINT16_MAX;
        versions_[ended.subject - first_version] = {static_cast<std::uint16_t>(is_version ? *value : 0), true};
        if (is_next()) return;
    } else {
        while (is_next()) remove_first();
        const bool states_none = std::none_of(versions_.begin(), versions_.end(), [](const Version& v) { return v.known; });
        if (states_none && is_present(now)) versions_.fill({0, true});
    }
    if (are_versions_known() && is_present(now)) send_device_info(ended.origin, output);
}

void V7Translation::send_device_info(const Origin& origin, V7Output& output) {
    std::array<std::uint8_t, 9 + 20> info{origin.asked};
    for (std::size_t i = 0; i < versions_.size(); ++i) ano::store(info.data() + 1 + 2 * i, versions_[i].value);
    ano::store(info.data() + 7, v8_protocol_version);
    const std::size_t name = std::min(settings_.name.size(), info.size() - 9);
    append_string(settings_.name, info.data() + 9, name);
    answer(origin, 0xE3, Data{info}.first(9 + name), output);
}

// --- Requests

bool V7Translation::has_waiting(const Origin& origin) const noexcept {
    for (std::size_t i = 0; i < size_; ++i) {
        if (queue_[(first_ + i) % queue_.size()].origin == origin) return true;
    }
    return false;
}

// To merge two writes of a parameter with another value between them would leave the device with that value.
std::optional<std::size_t> V7Translation::find_equal(const Origin& origin, const Request& request) const noexcept {
    for (std::size_t i = size_; i-- > 0;) {
        const Request& waiting = queue_[(first_ + i) % queue_.size()];
        if (waiting.origin == origin) return i;
        const bool is_of_same = waiting.subject == request.subject && waiting.origin.asked == origin.asked &&
                                is_of_waypoints(waiting) == is_of_waypoints(request);
        const bool changes_it = !asks_for_data(waiting) && !std::ranges::equal(waiting.frame(), request.frame());
        if (is_of_same && changes_it) return std::nullopt;
    }
    return std::nullopt;
}

// The host's repetition of the request in flight: to send it again does no harm, and the line may have lost the first.
bool V7Translation::may_be_sent_again(ano::TimePoint now) const noexcept {
    return in_flight_ && times_sent_ < max_sends && now - (due_ - settings_.repeat_interval) >= host_interval;
}

V7Translation::Request V7Translation::request_of(const Origin& origin, std::uint8_t v7_id, Data data,
                                                 std::uint16_t subject) const noexcept {
    Request request;
    request.origin = origin;
    request.subject = subject;
    request.size = static_cast<std::uint8_t>(v7::encode(request.bytes, receiver(origin.asked, v7_id), v7_id, data));
    return request;
}

void V7Translation::ask(const Origin& origin, std::uint8_t v7_id, Data data, std::uint16_t subject, std::uint16_t index,
                        ano::TimePoint now, V7Output& output) {
    if (data.size() > settings_.max_data) return drop(&V7Counters::down_too_big);
    if (!reaches_only(origin.asked, v7_id)) return drop(&V7Counters::down_other_device);
    Request request = request_of(origin, v7_id, data, subject);
    if (const auto equal = find_equal(origin, request)) {
        if (*equal == 0 && may_be_sent_again(now)) send_request(now, output);
        else ++counters_.merged;
        return;
    }
    if (size_ == queue_.size()) return drop(&V7Counters::down_queue_full);
    request.index = index;
    queued(size_++) = request;
    begin_next(now, output);
}

void V7Translation::begin_next(ano::TimePoint now, V7Output& output) {
    while (!in_flight_ && size_ > 0) {
        const bool is_sent = send_request(now, output);
        if (asks_for_data(queue_[first_]) || settings_.ack == V7Ack::device) continue;
        if (is_sent) acknowledge(queue_[first_].origin, output);
        remove_first();
    }
}

bool V7Translation::send_request(ano::TimePoint now, V7Output& output) {
    const Request& request = queue_[first_];
    in_flight_ = true;
    ++times_sent_;
    due_ = now + settings_.repeat_interval;
    if (!asks_for_data(request) && settings_.ack == V7Ack::device)
        expect(to_host_, {request.id(), v7::FrameView{request.frame()}.checks(), request.origin, now, true});
    return send_down(request.frame(), output);
}

void V7Translation::remove_first() noexcept {
    in_flight_ = false;
    times_sent_ = 0;
    first_ = (first_ + 1) % queue_.size();
    --size_;
}

// `value`: of the parameter that it asked for.
void V7Translation::end_request(ano::TimePoint now, V7Output& output, std::optional<std::int32_t> value) {
    const Request ended = queue_[first_];
    remove_first();
    if (ended.is_own) end_own_request(ended, value, now, output);
    begin_next(now, output);
}

void V7Translation::expire(ano::TimePoint now, V7Output& output) {
    now_ = now;
    if (!in_flight_ || now < due_) return;
    const Request& request = queue_[first_];
    if (asks_for_data(request) && times_sent_ < settings_.repeats) {
        send_request(now, output);
        return;
    }
    ++counters_.unanswered;
    end_request(now, output);
}

std::optional<ano::TimePoint> V7Translation::deadline() const noexcept { return in_flight_ ? std::optional{due_} : std::nullopt; }

}    // namespace anogate
