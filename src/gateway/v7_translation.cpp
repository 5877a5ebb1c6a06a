#include "v7_layouts.hpp"

#include <gateway/v7_translation.hpp>

#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <ano/wire.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace anogate {

namespace v7 = ano::v7;

std::bitset<256> V7Settings::default_down() {
    std::bitset<256> ids;
    for (const unsigned id : {0x00u, 0x30u, 0x32u, 0x33u, 0x34u, 0x40u, 0x41u, 0x51u, 0x60u, 0x61u, 0xA0u, 0xC0u, 0xE0u, 0xE1u})
        ids.set(id);
    for (unsigned id = ano::first_flexible; id <= ano::last_flexible; ++id) ids.set(id);
    return ids;
}

// --- Every link

V7LinkTranslation::V7LinkTranslation(V7Settings settings)
    : settings_{std::move(settings)},
      acc_{settings_.acc.value_or(usual_acceleration(settings_.address))},
      range_{settings_.range.value_or(settings_.address == 0xDE ? V7Range::flow : V7Range::lx)},
      echoes_{settings_.line} {
    settings_.max_data = std::min(settings_.max_data, v7::max_len);
    settings_.repeats = std::max(settings_.repeats, 1u);
}

std::uint8_t V7LinkTranslation::source_of(std::uint8_t v7_id, std::uint8_t usual) const noexcept {
    for (const V7Source& source : settings_.sources)
        if (v7_id >= source.first && v7_id <= source.last) return source.address;
    return usual;
}

ano::FrameView V7LinkTranslation::send_up(std::uint8_t source, std::uint8_t destination, std::uint8_t id, Data data,
                                          V7Output& output) {
    const auto frame = std::span{v8_}.first(ano::overhead + data.size());
    ano::write_header(frame, source, destination, id, data.size());
    if (data.data() != frame.data() + ano::header_size) std::copy(data.begin(), data.end(), frame.begin() + ano::header_size);
    ano::seal(frame);
    ++counters_.up;
    output.from_device(ano::FrameView{frame});
    return ano::FrameView{frame};
}

void V7LinkTranslation::position_down(std::uint8_t v8_destination, Data data, V7Output& output) {
    if (data.size() < 12) return drop(&V7Counters::down_malformed);
    std::array<std::uint8_t, 12> cm;
    positions_in_cm(data.data(), cm.data());
    send_down(v8_destination, 0x32, cm, output);
}

void V7LinkTranslation::log_value_down(std::uint8_t v8_destination, Data data, V7Output& output) {
    if (data.size() < 4) return drop(&V7Counters::down_malformed);
    if (data.size() > settings_.max_data) return drop(&V7Counters::down_too_big);
    const auto value = log_value_in_v7(data.data());
    if (!value) return drop(&V7Counters::down_unrepresentable);
    std::array<std::uint8_t, v7::max_len> changed;
    std::copy(data.begin(), data.end(), changed.begin());
    ano::store(changed.data(), *value);
    send_down(v8_destination, 0xA1, Data{changed}.first(data.size()), output);
}

void V7LinkTranslation::ranging_down(std::uint8_t v8_destination, Data data, V7Output& output) {
    if (data.size() < 5) return drop(&V7Counters::down_malformed);
    const auto send = [&](const V7Distance& distance) {
        std::array<std::uint8_t, 7> v7_data;
        distance.store(v7_data.data());
        send_down(v8_destination, 0x34, v7_data, output);
    };
    bool is_unrepresentable = false;
    for_each_distance(range_, data, send, [&] { is_unrepresentable = true; });
    if (is_unrepresentable) drop(&V7Counters::down_unrepresentable);
}

bool V7LinkTranslation::ExpectedAcks::add(const Expected& expected) noexcept {
    const bool replaces = all[next].waits && expected.at - all[next].at < memory;
    all[next] = expected;
    next = (next + 1) % all.size();
    return !replaces;
}

// The oldest one that matches.
std::optional<V7LinkTranslation::Expected> V7LinkTranslation::ExpectedAcks::take(std::uint8_t id, ano::Checks checks,
                                                                                 ano::TimePoint now) noexcept {
    for (std::size_t i = 0; i < all.size(); ++i) {
        Expected& expected = all[(next + i) % all.size()];
        if (!expected.waits || expected.id != id || expected.checks != checks || now - expected.at >= memory) continue;
        expected.waits = false;
        return expected;
    }
    return std::nullopt;
}

// --- A link with a device

V7Translation::V7Translation(V7Settings settings) : V7LinkTranslation{std::move(settings)} {
    if (settings_.name.empty()) settings_.name = "V7 " + std::string{ano::address::who(settings_.address)};
    if (settings_.lines) settings_.lines->of_devices.push_back(echoes_.line());
}

V7Translation::~V7Translation() {
    if (settings_.lines) std::erase(settings_.lines->of_devices, echoes_.line());
}

void V7Translation::reset() noexcept {
    alt_bar_ = alt_fu_ = {};
    last_frame_.reset();
    versions_ = {};
    to_host_ = {};
    echoes_.reset();
    nested_.reset();
    first_ = size_ = 0;
    in_flight_ = false;
    times_sent_ = 0;
}

bool V7Translation::is_own_id(std::uint8_t id) const noexcept {
    return id == settings_.address ||
           std::any_of(settings_.sources.begin(), settings_.sources.end(), [=](const V7Source& s) { return s.address == id; });
}

// --- From the device

bool V7Translation::has_returned(v7::FrameView frame) noexcept {
    const V7EchoWatch::Returned returned = echoes_.judge(frame, now_);
    if (returned == V7EchoWatch::Returned::no) return false;
    drop(returned == V7EchoWatch::Returned::echo ? &V7Counters::up_echo : &V7Counters::up_loop);
    return true;
}

void V7Translation::up(v7::FrameView frame, ano::TimePoint now, V7Output& output) {
    now_ = now;
    if (has_returned(frame)) return;
    last_frame_ = now;
    const Data data = frame.data();
    switch (frame.id()) {
    case 0x00: return check_up(frame, now, output);
    case 0xE0:
    case 0xE1: return drop(&V7Counters::up_command);
    case 0xE2: return parameter_up(frame, now, output);
    case 0x60:
    case 0x61:
        if (waypoint_up(frame, now, output)) return;
        break;
    default: break;
    }
    if (v7::table::is_new_in_v8(frame.id())) return drop(&V7Counters::up_no_counterpart);
    if (data.empty()) return drop(&V7Counters::up_malformed);
    std::uint8_t destination = v8_address_of(frame.destination());
    if (destination == 0) return drop(&V7Counters::up_no_address);
    if (ano::is_for_devices(frame.id()) && !ano::address::is_host(destination)) {
        if (frame.id() != 0x40 && frame.id() != 0x41) return drop(&V7Counters::up_command);
        destination = ano::address::host;
    }
    const std::uint8_t source = source_of(frame.id());
    if (v7::is_same_in_v8(frame.id())) send_up(source, destination, frame.id(), data, output);
    else if (const std::size_t size = rebuild_up(frame, now, v8_.data() + ano::header_size))
        send_up(source, destination, frame.id(), {v8_.data() + ano::header_size, size}, output);
}

// Writes the DATA in V8 and returns their size. 0: the frame was dropped and counted.
std::size_t V7Translation::rebuild_up(v7::FrameView frame, ano::TimePoint now, std::uint8_t* data) noexcept {
    const Data v7 = frame.data();
    const ano::Message& row = v7::layouts_of(frame.id()).front();
    if (row.is_open() ? v7.size() < row.fixed_size : v7.size() != row.fixed_size) {
        drop(&V7Counters::up_malformed);
        return 0;
    }
    const auto unchanged = [&] {
        std::copy(v7.begin(), v7.end(), data);
        return v7.size();
    };
    const bool keeps = settings_.layout == V7Layout::keep;
    switch (frame.id()) {
    case 0x01: return inertial_up(v7, data);
    case 0x02: return keeps ? unchanged() : compass_up(v7, now, data);
    case 0x05: return keeps ? unchanged() : altitude_up(v7, now, data);
    case 0x08: return keeps ? unchanged() : position_up(v7, now, data);
    case 0x34: return keeps ? unchanged() : ranging_up(v7, data);
    case 0x32: positions_in_mm(v7.data(), data); return 12;
    case 0xA1:
        unchanged();
        ano::store(data, static_cast<float>(ano::load<std::int32_t>(v7.data())));
        return v7.size();
    default: drop(&V7Counters::up_no_counterpart); return 0;
    }
}

std::size_t V7Translation::inertial_up(Data v7, std::uint8_t* data) const noexcept {
    std::copy(v7.begin(), v7.end(), data);
    if (acc_.unit == V7Acceleration::Unit::per_g) scale_axes(data, 0, 980.665 / acc_.per_g);
    if (acc_.unit == V7Acceleration::Unit::cmss) scale_axes(data, 6, 32768.0 / 2000);
    return v7.size();
}

std::size_t V7Translation::compass_up(Data v7, ano::TimePoint now, std::uint8_t* data) noexcept {
    alt_bar_ = {ano::load<std::int32_t>(v7.data() + 6), now};
    std::copy_n(v7.begin(), 6, data);
    const double tenths = ano::load<std::int16_t>(v7.data() + 10) * 10.0 / settings_.temp;
    ano::store(data + 6, saturated(tenths));
    data[8] = v7[13];
    return 9;
}

std::size_t V7Translation::altitude_up(Data v7, ano::TimePoint now, std::uint8_t* data) noexcept {
    alt_fu_ = {ano::load<std::int32_t>(v7.data()), now};
    if (!alt_bar_.is_fresh(now)) {
        std::copy(v7.begin(), v7.end(), data);
        return v7.size();
    }
    ano::store(data, alt_bar_.value);
    std::copy_n(v7.begin() + 4, 4, data + 4);
    std::copy_n(v7.begin(), 4, data + 8);
    data[12] = v7[8];
    return 13;
}

std::size_t V7Translation::position_up(Data v7, ano::TimePoint now, std::uint8_t* data) const noexcept {
    std::copy(v7.begin(), v7.end(), data);
    if (!alt_fu_.is_fresh(now)) return v7.size();
    ano::store(data + 8, alt_fu_.value);
    return 12;
}

std::size_t V7Translation::ranging_up(Data v7, std::uint8_t* data) noexcept {
    const std::size_t size = ranging_in_v8(range_, v7.data(), data);
    if (size == 0) drop(&V7Counters::up_unrepresentable);
    return size;
}

void V7Translation::check_up(v7::FrameView frame, ano::TimePoint now, V7Output& output) {
    const Data data = frame.data();
    if (data.size() != 3) return drop(&V7Counters::up_malformed);
    const ano::Checks checks{data[1], data[2]};
    const auto expected = to_host_.take(data[0], checks, now);
    if (!expected) return drop(&V7Counters::up_unmatched);
    const Origin& origin = expected->origin;
    const std::uint8_t acknowledged[]{origin.id, origin.checks.sum, origin.checks.add};
    send_up(origin.asked, origin.host, 0x00, acknowledged, output);
    if (in_flight_ && queue_[first_].id() == data[0] && v7::FrameView{queue_[first_].frame()}.checks() == checks) {
        echoes_.answered(v7::FrameView{queue_[first_].frame()}, now);
        end_request(now, output);
    }
}

void V7Translation::parameter_up(v7::FrameView frame, ano::TimePoint now, V7Output& output) {
    const Data data = frame.data();
    if (data.size() != 6) return drop(&V7Counters::up_malformed);
    const auto number = ano::load<std::uint16_t>(data.data());
    const auto value = ano::load<std::int32_t>(data.data() + 2);
    // On a tapped line the other end writes to the device, or to all. Some devices answer to all, slow ones to each repeated question.
    const bool asked = is_in_flight(0xE1, number), to_all = frame.destination() == v7::address::broadcast;
    if (to_all && !asked) return drop(&V7Counters::up_unmatched);
    if (!to_all && !ano::address::is_host(v8_address_of(frame.destination()))) return drop(&V7Counters::up_command);
    if (asked) {
        const Request& request = queue_[first_];
        if (!request.is_own) send_parameter(request.origin, request.index, value, output);
        return end_request(now, output, value);
    }
    const std::uint8_t source = source_of(frame.id());
    const auto index = index_of(number, source);
    if (!index) return drop(&V7Counters::up_no_counterpart);
    send_parameter({ano::address::host, source, 0, {}}, *index, value, output);
}

// Without a table the index is the number.
std::optional<std::uint16_t> V7Translation::index_of(std::uint16_t number, std::uint8_t device) const noexcept {
    const auto rows = parameters_of(device);
    if (rows.empty()) return number;
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (rows[i].number == number) return static_cast<std::uint16_t>(i);
    return std::nullopt;
}

void V7Translation::send_parameter(const Origin& to, std::uint16_t index, std::int32_t value, V7Output& output) {
    std::uint8_t data[6];
    ano::store(data, index);
    ano::store(data + 2, value);
    const auto rows = parameters_of(to.asked);
    if (index < rows.size() && rows[index].as_f32) {
        ano::store(data + 2, static_cast<float>(value / static_cast<double>(rows[index].scale)));
    }
    send_up(to.asked, to.host, 0xE1, data, output);
}

// True: it answers the request in flight.
bool V7Translation::waypoint_up(v7::FrameView frame, ano::TimePoint now, V7Output& output) {
    const Data data = frame.data();
    if (data.empty() || !in_flight_ || queue_[first_].id() != 0x60) return false;
    const Request& request = queue_[first_];
    if (frame.id() == 0x61 && request.subject != data[0]) return false;
    send_up(request.origin.asked, request.origin.host, frame.id(), data, output);
    end_request(now, output);
    return true;
}

}    // namespace anogate
