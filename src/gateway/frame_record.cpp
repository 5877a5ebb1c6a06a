#include <gateway/frame_record.hpp>

#include <algorithm>
#include <array>
#include <cstring>

namespace anogate {
namespace {

constexpr std::size_t drops_in(const auto& table) {
    return static_cast<std::size_t>(
        std::count_if(std::begin(table), std::end(table), [](const auto& row) { return row.counts == Counts::drops; }));
}

constexpr auto names = [] {
    std::array<std::string_view, 1 + drops_in(receive_counters) + drops_in(send_counters)> all;
    std::size_t n = 1;
    for (const auto& row : receive_counters)
        if (row.counts == Counts::drops) all[n++] = row.name;
    for (const auto& row : send_counters)
        if (row.counts == Counts::drops) all[n++] = row.name;
    return all;
}();

template <class Rows, class Cause>
std::uint8_t number_in(const Rows& rows, Cause cause) noexcept {
    const auto row = std::find_if(std::begin(rows), std::end(rows), [cause](const auto& r) { return r.value == cause; });
    const auto name = std::find(names.begin() + 1, names.end(), row != std::end(rows) ? row->name : "");
    return name != names.end() ? static_cast<std::uint8_t>(name - names.begin()) : std::uint8_t{0};
}

void store(char* at, std::uint64_t number) noexcept {
    for (std::size_t i = 0; i < 8; ++i) at[i] = static_cast<char>(number >> 8 * i & 0xFF);
}

std::uint64_t number_at(std::string_view bytes, std::size_t at) noexcept {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < 8; ++i) number |= std::uint64_t{static_cast<std::uint8_t>(bytes[at + i])} << 8 * i;
    return number;
}

}    // namespace

std::string_view text(Direction direction) noexcept {
    switch (direction) {
    case Direction::in: return "in";
    case Direction::out: return "out";
    case Direction::dropped: return "dropped";
    }
    return "";
}

void write(char* at, const FrameRecord& record) noexcept {
    store(at, record.time_ns);
    store(at + 8, record.boottime_ns);
    at[16] = static_cast<char>(record.link);
    at[17] = static_cast<char>(static_cast<std::uint8_t>(record.direction) | (record.is_elsewhere ? FrameRecord::elsewhere : 0) |
                               (record.raw.empty() ? 0 : FrameRecord::has_raw));
    at[18] = static_cast<char>(record.cause);
    at[19] = static_cast<char>(record.channel);
    const auto frame = record.frame.bytes();
    std::memcpy(at + FrameRecord::head, frame.data(), frame.size());
    if (record.raw.empty()) return;
    char* const raw = at + FrameRecord::head + frame.size();
    raw[0] = static_cast<char>(record.raw.size() & 0xFF);
    raw[1] = static_cast<char>(record.raw.size() >> 8 & 0xFF);
    std::memcpy(raw + 2, record.raw.data(), record.raw.size());
}

void append(std::string& records, const FrameRecord& record) {
    const std::size_t begin = records.size();
    if (const std::size_t end = begin + record.size(); end > records.capacity())
        records.reserve(std::max(end, 2 * records.capacity()));
    records.resize(begin + record.size());
    write(records.data() + begin, record);
}

std::optional<FrameRecord> next_record(std::string_view& records) noexcept {
    if (records.size() < FrameRecord::head) return std::nullopt;
    const auto byte = [&](std::size_t at) { return static_cast<std::uint8_t>(records[at]); };
    const std::string_view behind = records.substr(FrameRecord::head);
    const auto frame = ano::frame_at({reinterpret_cast<const std::uint8_t*>(behind.data()), behind.size()});
    const bool is_elsewhere = (byte(17) & FrameRecord::elsewhere) != 0;
    const auto direction = static_cast<std::uint8_t>(byte(17) & ~(FrameRecord::elsewhere | FrameRecord::has_raw));
    if (!frame || direction > static_cast<std::uint8_t>(Direction::dropped)) return std::nullopt;
    std::span<const std::uint8_t> raw;
    std::size_t end = FrameRecord::head + frame->bytes().size();
    if ((byte(17) & FrameRecord::has_raw) != 0) {
        if (records.size() < end + 2) return std::nullopt;
        const std::size_t size = byte(end) | std::size_t{byte(end + 1)} << 8;
        if (records.size() < end + 2 + size) return std::nullopt;
        raw = {reinterpret_cast<const std::uint8_t*>(records.data()) + end + 2, size};
        end += 2 + size;
    }
    FrameRecord record{number_at(records, 0),
                       number_at(records, 8),
                       byte(16),
                       static_cast<Direction>(direction),
                       byte(18),
                       byte(19),
                       *frame,
                       is_elsewhere,
                       raw};
    records.remove_prefix(end);
    return record;
}

std::span<const std::string_view> frame_causes() noexcept { return names; }
std::uint8_t number_of(ReceiveCause cause) noexcept { return number_in(receive_counters, cause); }
std::uint8_t number_of(SendCause cause) noexcept { return number_in(send_counters, cause); }

}    // namespace anogate
