#include <ano/traffic.hpp>
#include <gateway/can_settings.hpp>
#include <gateway/can_stream.hpp>

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace anogate {
namespace {

constexpr std::uint32_t last_standard_id = 0x7FF;
constexpr std::uint32_t last_extended_id = 0x1FFF'FFFF;
constexpr std::uint32_t standard_range = 0x100;    // number of ids from one base on
constexpr std::uint32_t extended_range = 0x4'0000;
constexpr auto last_class = static_cast<std::uint32_t>(ano::TrafficClass::bulk);

std::string hex(std::uint32_t number) {
    char text[16];
    std::snprintf(text, sizeof text, "0x%X", number);
    return text;
}

/// The base in hex; in decimal with a suggestion if the 0x is probably missing.
std::string format_base(std::uint32_t base, std::uint32_t range, std::uint32_t last_base) {
    const std::string digits = std::to_string(base);
    const std::uint64_t meant = std::stoull(digits, nullptr, 16);
    return meant % range == 0 && meant <= last_base ? digits + " (did you mean 0x" + digits + "?)" : hex(base);
}

}    // namespace

std::string fault_of(const CanSettings& can) {
    const std::uint32_t last = can.extended ? last_extended_id : last_standard_id;
    const std::string width = can.extended ? "29-bit" : "11-bit";
    if (can.framing == CanFraming::isotp) {
        if (can.base) return "base belongs to framing=stream";
        if (!can.tx || !can.rx) return "framing=isotp needs tx and rx, the two CAN ids";
        if (*can.tx > last || *can.rx > last)
            return "tx and rx are " + width + " ids, at most " + hex(last) + (can.extended ? "" : " (extended: 29-bit)");
        if (*can.tx == *can.rx) return "tx and rx must differ";
        return {};
    }
    if (can.tx || can.rx) return "tx and rx belong to framing=isotp";
    const std::uint32_t range = can.extended ? extended_range : standard_range;
    const std::uint32_t last_base = last + 1 - range;
    if (can.base && (*can.base % range != 0 || *can.base > last_base))
        return "base is a multiple of " + hex(range) + " up to " + hex(last_base) + " (" + width + " ids), not " +
               format_base(*can.base, range, last_base);
    return {};
}

std::uint32_t CanIds::of(std::span<const std::uint8_t> header) const noexcept {
    const std::uint32_t source = header[1];
    if (!extended_) return base_ + source;
    return base_ + (static_cast<std::uint32_t>(ano::traffic_class_of(header[3])) << 16) + (source << 8) + header[2];
}

std::optional<std::uint8_t> CanIds::source(std::uint32_t id) const noexcept {
    const std::uint32_t offset = id - base_;
    if (!extended_) {
        if (offset >= standard_range) return std::nullopt;
        return static_cast<std::uint8_t>(offset);
    }
    if (offset >= (last_class + 1) << 16) return std::nullopt;
    return static_cast<std::uint8_t>(offset >> 8);
}

std::vector<CanIds::Filter> CanIds::filters() const {
    if (!extended_) return {{base_, last_standard_id & ~(standard_range - 1)}};
    return {{base_, last_extended_id & ~0x1'FFFFu}, {base_ + (last_class << 16), last_extended_id & ~0xFFFFu}};
}

std::span<const CanCutter::Piece> CanCutter::cut(std::span<const std::span<const std::uint8_t>> frames) noexcept {
    const std::size_t room = fd_ ? 64 : 8;
    std::size_t count = 0;
    for (std::size_t i = 0; i < frames.size() && count < max_pieces; ++i) {
        std::span<const std::uint8_t> rest = frames[i];
        const std::uint32_t id = i == 0 && rest_id_ ? *rest_id_ : ids_.of(rest);
        while (!rest.empty() && count < max_pieces) {
            const auto bytes = rest.first(std::min(room, rest.size()));
            rest = rest.subspan(bytes.size());
            pieces_[count++] = {id, bytes, can_fd_size(bytes.size()), rest.empty()};
        }
    }
    return std::span{pieces_}.first(count);
}

std::size_t CanCutter::taken(std::size_t n) noexcept {
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < n; ++i) bytes += pieces_[i].bytes.size();
    if (n > 0) {
        const Piece& last = pieces_[n - 1];
        rest_id_ = last.last ? std::nullopt : std::optional{last.id};
    }
    return bytes;
}

CanStreams::Stream* CanStreams::find(std::uint32_t id) noexcept {
    for (Stream& stream : streams_)
        if (stream.id == id) return &stream;
    return nullptr;
}

// A new id is only accepted with the beginning of a V8 frame. Otherwise noise with ever new ids could take the places of ids that
// are in the middle of a frame.
bool CanStreams::begins_stream(std::uint32_t id, std::span<const std::uint8_t> data) noexcept {
    if (!data.empty() && data[0] == ano::head && ids_.source(id)) return true;
    refused_.bytes_in += data.size();
    refused_.skipped_bytes += data.size();
    return false;
}

void CanStreams::put(Stream& stream, std::span<const std::uint8_t> data, TimePoint now) noexcept {
    stream.used = ++uses_;
    const auto room = stream.parser.prepare();    // the largest CAN frame always fits
    std::memcpy(room.data(), data.data(), data.size());
    stream.parser.commit(data.size(), now);
}

CanStreams::Stream& CanStreams::unused_longest() noexcept {
    return *std::min_element(streams_.begin(), streams_.end(), [](const Stream& a, const Stream& b) { return a.used < b.used; });
}

std::optional<TimePoint> CanStreams::deadline() const noexcept {
    std::optional<TimePoint> first;
    for (const Stream& stream : streams_)
        if (const auto due = stream.parser.deadline()) first = std::min(first.value_or(*due), *due);
    return first;
}

ReceiveCounters CanStreams::received() const noexcept {
    ReceiveCounters all = refused_;
    for (const Stream& stream : streams_) add(all, stream.parser.counters());
    return all;
}

}    // namespace anogate
