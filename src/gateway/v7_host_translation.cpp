#include "v7_layouts.hpp"

#include <gateway/v7_host_translation.hpp>

#include <ano/address.hpp>
#include <ano/reading.hpp>
#include <ano/values.hpp>
#include <ano/wire.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <type_traits>
#include <utility>

namespace anogate {

namespace v7 = ano::v7;

namespace {

constexpr std::uint16_t first_of_device = 1, last_of_device = 4;    // V7 parameters: hardware type and three versions

bool is_of_device(std::uint16_t number) noexcept { return number >= first_of_device && number <= last_of_device; }

// The number as V7 has it; std::nullopt: it has no such number.
std::optional<std::int32_t> number_in_v7(std::span<const std::uint8_t> bytes, ano::Type type, double scale) noexcept {
    if (type == ano::Type::text || bytes.size() < ano::width(type)) return std::nullopt;
    const double number = ano::with_type(type, [&]<class T>(T) { return static_cast<double>(ano::load<T>(bytes.data())); }) *
                          scale;
    const double whole = std::round(number);
    // A scaled f32 has an error of its own. Without a scale a fraction would be lost, and the host program would write that back.
    if (!(whole >= INT32_MIN && whole <= INT32_MAX) || (scale == 1 && whole != number)) return std::nullopt;
    return static_cast<std::int32_t>(whole);
}

// Writes the value and returns its size; 0: the type does not have it.
std::size_t put_number(std::int32_t number, ano::Type type, double scale, std::uint8_t* at) noexcept {
    return ano::with_type(type, [&]<class T>(T) -> std::size_t {
        if constexpr (std::is_floating_point_v<T>) {
            ano::store(at, static_cast<T>(number / scale));
        } else {
            if (!std::in_range<T>(number)) return 0;
            ano::store(at, static_cast<T>(number));
        }
        return sizeof(T);
    });
}

}    // namespace

void V7HostTranslation::reset() noexcept {
    alt_bar_ = {};
    to_host_ = {};
    echoes_.reset();
    connected_at_.reset();
    types_ = {};
    first_ = size_ = 0;
    in_flight_ = is_written_ = false;
    times_sent_ = 0;
}

// --- From the host program

void V7HostTranslation::up(v7::FrameView frame, ano::TimePoint now, V7Output& output) {
    const std::uint8_t id = frame.id();
    const Data data = frame.data();
    now_ = now;
    if (echoes_.is_back(frame, now)) return drop(&V7Counters::up_echo);
    if (const auto line = V7EchoWatch::line_of(frame)) return probe_up(*line);
    if (is_connected()) return drop(&V7Counters::up_loop);
    if (is_of_own_sensor(id)) return drop(&V7Counters::up_own_sensor);
    if (id == 0x00) return drop(&V7Counters::up_unmatched);
    if (v7::table::is_new_in_v8(id)) return drop(&V7Counters::up_no_counterpart);
    if (data.empty()) return drop(&V7Counters::up_malformed);
    const std::uint8_t destination = v8_address_of(frame.destination());
    if (destination == 0 || ano::address::is_host(destination)) return drop(&V7Counters::up_no_address);
    const Origin origin{host_of(id), settings_.address, id, frame.checks()};
    switch (id) {
    case 0xE0: return command_up(origin, data, now, output);
    case 0xE1: return read_up(origin, data, now, output);
    case 0xE2: return write_up(origin, data, now, output);
    case 0x60: return ask({.origin = origin, .number = data[0]}, now, output);
    case 0x61: return send_acknowledged(origin, 0x61, data, now, output);
    default: break;
    }
    if (v7::is_same_in_v8(id)) send_to_device(id, id, data, output);
    else rebuild_up(frame, output);
}

// One of another gateway may be on its way through this one in a loop.
void V7HostTranslation::probe_up(std::uint32_t line) noexcept {
    if (!settings_.lines) return drop(&V7Counters::up_no_counterpart);
    const auto& own = settings_.lines->of_devices;
    if (std::find(own.begin(), own.end(), line) != own.end()) {
        connected_at_ = now_;
        return drop(&V7Counters::up_loop);
    }
    settings_.lines->passed_on = line;
    ++settings_.lines->times_passed_on;
    drop(&V7Counters::up_no_counterpart);
}

void V7HostTranslation::rebuild_up(v7::FrameView frame, V7Output& output) {
    const Data data = frame.data();
    const ano::Message& row = v7::layouts_of(frame.id()).front();
    if (row.is_open() ? data.size() < row.fixed_size : data.size() != row.fixed_size) return drop(&V7Counters::up_malformed);
    std::array<std::uint8_t, v7::max_len> changed;
    std::copy(data.begin(), data.end(), changed.begin());
    std::size_t size = data.size();
    switch (frame.id()) {
    case 0x32: positions_in_mm(data.data(), changed.data()); break;
    case 0x34: size = ranging_in_v8(range_, data.data(), changed.data()); break;
    case 0xA1: ano::store(changed.data(), static_cast<float>(ano::load<std::int32_t>(data.data()))); break;
    default: return drop(&V7Counters::up_no_counterpart);
    }
    if (size == 0) return drop(&V7Counters::up_unrepresentable);
    send_to_device(frame.id(), frame.id(), Data{changed}.first(size), output);
}

void V7HostTranslation::send_acknowledged(const Origin& origin, std::uint8_t id, Data data, ano::TimePoint now,
                                          V7Output& output) {
    const ano::FrameView sent = send_up(origin.host, origin.asked, id, data, output);
    expect(to_host_, {id, sent.checks(), origin, now, true});
}

void V7HostTranslation::command_up(const Origin& origin, Data data, ano::TimePoint now, V7Output& output) {
    if (data.size() < 3 || data.size() > v7_command_size) return drop(&V7Counters::up_malformed);
    if (v7_erases_firmware(data)) return drop(&V7Counters::up_erase);
    send_acknowledged(origin, 0xC0, data, now, output);
}

void V7HostTranslation::read_up(const Origin& origin, Data data, ano::TimePoint now, V7Output& output) {
    if (data.size() != 2) return drop(&V7Counters::up_malformed);
    const auto number = ano::load<std::uint16_t>(data.data());
    if (const auto index = index_of(number)) return ask({.origin = origin, .number = number, .index = *index}, now, output);
    if (is_of_device(number)) return ask({.origin = origin, .number = number, .is_of_device = true}, now, output);
    ++counters_.answered;
    send_parameter(origin, number, no_parameter, output);
}

void V7HostTranslation::write_up(const Origin& origin, Data data, ano::TimePoint now, V7Output& output) {
    if (data.size() != 6) return drop(&V7Counters::up_malformed);
    const auto number = ano::load<std::uint16_t>(data.data());
    const auto index = index_of(number);
    if (!index) return drop(&V7Counters::up_no_counterpart);
    const auto value = ano::load<std::int32_t>(data.data() + 2);
    ask({.origin = origin, .number = number, .index = *index, .value = value}, now, output);
}

// Without a table the index is the number, except for the numbers that V7 reserves for the device.
std::optional<std::uint16_t> V7HostTranslation::index_of(std::uint16_t number) const noexcept {
    const auto& rows = settings_.parameters;
    if (rows.empty()) return is_of_device(number) ? std::nullopt : std::optional{number};
    const auto row = std::find_if(rows.begin(), rows.end(), [=](const V7Parameter& r) { return r.number == number; });
    return row == rows.end() ? std::nullopt : std::optional{static_cast<std::uint16_t>(row - rows.begin())};
}

// --- To the host program

void V7HostTranslation::down(ano::FrameView frame, ano::TimePoint now, V7Output& output) {
    const Data data = frame.data();
    now_ = now;
    if (frame.source() != settings_.address) return drop(&V7Counters::down_other_device);
    if (data.empty()) return drop(&V7Counters::down_malformed);
    switch (frame.id()) {
    case 0x00: return check_down(data, now, output);
    case 0x60:
    case 0x61: return waypoint_down(frame, now, output);
    case 0xE1: return value_down(data, now, output);
    case 0xE2: return description_down(data, now, output);
    case 0xE3: return device_info_down(data, now, output);
    default: break;
    }
    if (v7::table::is_new_in_v8(frame.id())) return drop(&V7Counters::down_no_counterpart);
    rebuild_down(frame, now, output);
}

// The number itself if V7 has no other one: an MCU then drops the frame, and a host program accepts it, as it does any.
std::uint8_t V7HostTranslation::receiver(std::uint8_t v8_destination) const noexcept {
    return settings_.v7_address.value_or(v7_address_of(v8_destination));
}

void V7HostTranslation::send_down(std::uint8_t v8_destination, std::uint8_t id, Data data, V7Output& output) {
    if (data.size() > settings_.max_data) return drop(&V7Counters::down_too_big);
    const v7::FrameView frame{Data{v7_}.first(v7::encode(v7_, receiver(v8_destination), id, data))};
    ++counters_.down;
    echoes_.sent(frame, now_);
    output.to_device(frame);
}

// DATA with the size of V7's layout, which V8 has as variants of 0x02, 0x05, 0x08 and 0x34, stay as they are.
void V7HostTranslation::rebuild_down(ano::FrameView frame, ano::TimePoint now, V7Output& output) {
    const std::uint8_t id = frame.id(), to = frame.destination();
    const Data data = frame.data();
    const std::size_t size = data.size();
    switch (id) {
    case 0x01: return inertial_down(to, data, output);
    case 0x02: return size == 14 ? send_down(to, id, data, output) : compass_down(to, data, now, output);
    case 0x05: return size == 9 ? send_down(to, id, data, output) : altitude_down(to, data, now, output);
    case 0x06: {
        std::array<std::uint8_t, 5> mode;
        if (size < mode.size()) return drop(&V7Counters::down_malformed);
        std::copy_n(data.begin(), mode.size(), mode.begin());
        mode[1] = std::min<std::uint8_t>(mode[1], 1);    // V7 has no "airborne"
        return send_down(to, id, mode, output);
    }
    case 0x08: return size < 8 ? drop(&V7Counters::down_malformed) : send_down(to, id, data.first(8), output);
    case 0x32: return position_down(to, data, output);
    case 0x34: return size == 7 ? send_down(to, id, data, output) : ranging_down(to, data, output);
    case 0xA1: return log_value_down(to, data, output);
    case 0xE0: return drop(&V7Counters::down_no_counterpart);
    default: return send_down(to, id, data, output);
    }
}

void V7HostTranslation::inertial_down(std::uint8_t to, Data data, V7Output& output) {
    std::array<std::uint8_t, 13> v7_data;
    if (data.size() < v7_data.size()) return drop(&V7Counters::down_malformed);
    std::copy_n(data.begin(), v7_data.size(), v7_data.begin());
    if (acc_.unit == V7Acceleration::Unit::per_g) scale_axes(v7_data.data(), 0, acc_.per_g / 980.665);
    if (acc_.unit == V7Acceleration::Unit::cmss) scale_axes(v7_data.data(), 6, 2000.0 / 32768);
    send_down(to, 0x01, v7_data, output);
}

void V7HostTranslation::compass_down(std::uint8_t to, Data data, ano::TimePoint now, V7Output& output) {
    if (data.size() < 9) return drop(&V7Counters::down_malformed);
    std::array<std::uint8_t, 14> v7_data{};
    std::copy_n(data.begin(), 6, v7_data.begin());
    if (alt_bar_.is_fresh(now)) ano::store(v7_data.data() + 6, alt_bar_.value);
    ano::store(v7_data.data() + 10, saturated(ano::load<std::int16_t>(data.data() + 6) * (settings_.temp / 10.0)));
    v7_data[13] = data[8];
    send_down(to, 0x02, v7_data, output);
}

void V7HostTranslation::altitude_down(std::uint8_t to, Data data, ano::TimePoint now, V7Output& output) {
    if (data.size() < 13) return drop(&V7Counters::down_malformed);
    alt_bar_ = {ano::load<std::int32_t>(data.data()), now};
    std::array<std::uint8_t, 9> v7_data;
    std::copy_n(data.begin() + 8, 4, v7_data.begin());
    std::copy_n(data.begin() + 4, 4, v7_data.begin() + 4);
    v7_data[8] = data[12];
    send_down(to, 0x05, v7_data, output);
}

void V7HostTranslation::check_down(Data data, ano::TimePoint now, V7Output& output) {
    if (data.size() < 3) return drop(&V7Counters::down_malformed);
    const auto expected = to_host_.take(data[0], {data[1], data[2]}, now);
    if (!expected) return drop(&V7Counters::down_unmatched);
    const Origin& origin = expected->origin;
    const std::uint8_t check[]{origin.id, origin.checks.sum, origin.checks.add};
    send_down(origin.host, 0x00, check, output);
    if (const Request* request = in_flight(0xE2); request && request->origin.checks == origin.checks && origin.id == 0xE2)
        end_request(now, output);
}

// The answers to other hosts have the same destination.
void V7HostTranslation::description_down(Data data, ano::TimePoint now, V7Output& output) {
    const std::span layouts = ano::layouts_of(0xE2);
    const ano::Message* const layout = ano::select_layout(layouts, data);
    const bool awaits = in_flight_ && !queue_[first_].is_of_device && queue_[first_].origin.id != 0x60 && !is_written_;
    if (!layout || !awaits || ano::load<std::uint16_t>(data.data()) != queue_[first_].index)
        return drop(&V7Counters::down_unmatched);
    if (type_of(queue_[first_])) return drop(&V7Counters::down_unmatched);
    const auto type = layout == &layouts.front() ? ano::parameter_type(data[2]) : std::optional{ano::Type::i32};
    times_sent_ = 0;
    if (!type || *type == ano::Type::text) {
        drop(&V7Counters::down_unrepresentable);
    } else {
        known_type(queue_[first_].index) = {queue_[first_].index, type};
        if (send_request(now, output)) return;
    }
    end_request(now, output);
}

void V7HostTranslation::value_down(Data data, ano::TimePoint now, V7Output& output) {
    const Request* const request = in_flight(0xE1);
    if (!request || request->is_of_device || data.size() < 3 || ano::load<std::uint16_t>(data.data()) != request->index)
        return drop(&V7Counters::down_unmatched);
    const auto type = type_of(*request);
    if (!type) return drop(&V7Counters::down_unmatched);
    if (const auto number = number_in_v7(data.subspan(2), *type, scale_of(request->index, *type)))
        send_parameter(request->origin, request->number, *number, output);
    else drop(&V7Counters::down_unrepresentable);
    end_request(now, output);
}

void V7HostTranslation::device_info_down(Data data, ano::TimePoint now, V7Output& output) {
    const Request* const request = in_flight(0xE1);
    if (!request || !request->is_of_device || data.size() < 9) return drop(&V7Counters::down_unmatched);
    const std::uint16_t number = request->number;
    const std::int32_t value = number == first_of_device ? v7_address_of(settings_.address)
                                                         : ano::load<std::uint16_t>(data.data() + 1 + 2 * (number - 2));
    send_parameter(request->origin, number, value, output);
    end_request(now, output);
}

void V7HostTranslation::waypoint_down(ano::FrameView frame, ano::TimePoint now, V7Output& output) {
    const Request* const request = in_flight(0x60);
    if (!request || (frame.id() == 0x61 && frame.data()[0] != request->number)) return drop(&V7Counters::down_unmatched);
    send_down(request->origin.host, frame.id(), frame.data(), output);
    end_request(now, output);
}

void V7HostTranslation::send_parameter(const Origin& to, std::uint16_t number, std::int32_t value, V7Output& output) {
    std::uint8_t data[6];
    ano::store(data, number);
    ano::store(data + 2, value);
    send_down(to.host, 0xE2, data, output);
}

// --- Requests

std::optional<ano::Type> V7HostTranslation::type_of(const Request& request) noexcept {
    const KnownType& known = known_type(request.index);
    return known.index == request.index ? known.type : std::nullopt;
}

// V7 has the values of f32 as whole numbers, by a scale that only the table states.
double V7HostTranslation::scale_of(std::uint16_t index, ano::Type type) const noexcept {
    const bool is_real = type == ano::Type::f32 || type == ano::Type::f64;
    return is_real && index < settings_.parameters.size() ? settings_.parameters[index].scale : 1.0;
}

void V7HostTranslation::ask(const Request& request, ano::TimePoint now, V7Output& output) {
    for (std::size_t i = size_; i-- > 0;) {
        const Request& waiting = queue_[(first_ + i) % queue_.size()];
        const bool has_value = is_write(request) && waiting.value == request.value;
        if (waiting.origin == request.origin) {
            // The host program repeats the write in flight: the device may not have received the first.
            if (i == 0 && is_written_) send_request(now, output);
            else ++counters_.merged;
            return;
        }
        if (is_write(waiting) && waiting.index == request.index && !has_value) break;    // the order of the two counts
    }
    if (size_ == queue_.size()) return drop(&V7Counters::up_queue_full);
    queue_[(first_ + size_++) % queue_.size()] = request;
    begin_next(now, output);
}

void V7HostTranslation::begin_next(ano::TimePoint now, V7Output& output) {
    while (!in_flight_ && size_ > 0) {
        in_flight_ = true;
        if (send_request(now, output)) return;
        remove_first();
    }
}

void V7HostTranslation::remove_first() noexcept {
    in_flight_ = is_written_ = false;
    times_sent_ = 0;
    first_ = (first_ + 1) % queue_.size();
    --size_;
}

bool V7HostTranslation::send_request(ano::TimePoint now, V7Output& output) {
    const Request& request = queue_[first_];
    ++times_sent_;
    due_ = now + settings_.repeat_interval;
    if (request.origin.id == 0x60) {
        const std::uint8_t number[]{static_cast<std::uint8_t>(request.number)};
        send_to_device(0x60, 0x60, number, output);
        return true;
    }
    enum : std::uint8_t { of_device = 0, value = 2, description = 3 };
    const auto type = request.is_of_device ? std::nullopt : type_of(request);
    if (type && is_write(request)) return send_write(request, *type, now, output);
    std::uint8_t question[3]{type ? value : request.is_of_device ? of_device : description};
    ano::store(question + 1, request.index);
    send_to_device(request.origin.id, 0xE0, question, output);
    return true;
}

bool V7HostTranslation::send_write(const Request& request, ano::Type type, ano::TimePoint now, V7Output& output) {
    std::array<std::uint8_t, 2 + 8> data;
    ano::store(data.data(), request.index);
    const std::size_t size = put_number(request.value, type, scale_of(request.index, type), data.data() + 2);
    if (size == 0) {
        drop(&V7Counters::up_unrepresentable);
        return false;
    }
    is_written_ = true;
    send_acknowledged(request.origin, 0xE1, Data{data}.first(2 + size), now, output);
    return true;
}

void V7HostTranslation::end_request(ano::TimePoint now, V7Output& output) {
    remove_first();
    begin_next(now, output);
}

void V7HostTranslation::expire(ano::TimePoint now, V7Output& output) {
    now_ = now;
    if (!in_flight_ || now < due_) return;
    if (!is_written_ && times_sent_ < settings_.repeats) {
        send_request(now, output);
        return;
    }
    ++counters_.unanswered;
    end_request(now, output);
}

std::optional<ano::TimePoint> V7HostTranslation::deadline() const noexcept {
    return in_flight_ ? std::optional{due_} : std::nullopt;
}

}    // namespace anogate
