// The record of one frame, as sent to clients (GET /frames?format=binary).
#pragma once
#include <ano/frame.hpp>
#include <gateway/counters.hpp>
#include <gateway/ids.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace anogate {

enum class Direction : std::uint8_t { in, out, dropped };
std::string_view text(Direction direction) noexcept;

/// Numbers are little-endian: time_ns (8 bytes), boottime_ns (8), link, direction, cause, channel, and the frame, whose LEN
/// determines its length. The upper bit of the direction is `is_elsewhere`. The next bit is set if `raw` follows the frame: its
/// length (2 bytes), and its bytes. Records follow each other without a gap.
struct FrameRecord {
    static constexpr std::size_t head = 20;             // bytes before the frame
    static constexpr std::uint8_t no_channel = 0xFF;    // it belongs to no channel of its link
    static constexpr std::uint8_t elsewhere = 0x80;     // in the byte of the direction
    static constexpr std::uint8_t has_raw = 0x40;       // there as well

    std::uint64_t time_ns = 0;        // since 1970
    std::uint64_t boottime_ns = 0;    // since the computer was started, including the time in which it was suspended
    std::uint8_t link = 0;            // LinkId
    Direction direction = Direction::in;
    std::uint8_t cause = 0;    // why it was dropped: an index of frame_causes(); 0: it was not dropped
    std::uint8_t channel = no_channel;
    ano::FrameView frame;
    bool is_elsewhere = false;              // received where its source is not at home: another sender may use the address
    std::span<const std::uint8_t> raw{};    // the frame as it was on the wire, in protocol V7; at most 65,535 bytes

    /// The bytes written by write().
    std::size_t size() const noexcept { return head + frame.bytes().size() + (raw.empty() ? 0 : 2 + raw.size()); }
};

/// Writes size() bytes to `at`.
void write(char* at, const FrameRecord& record) noexcept;
/// Throws std::bad_alloc; then `records` is unchanged.
void append(std::string& records, const FrameRecord& record);
/// Removes and returns the first record; std::nullopt: there is none, or `records` are damaged. Valid as long as their memory.
std::optional<FrameRecord> next_record(std::string_view& records) noexcept;

/// The names of the counters for the causes of drops; the first is empty.
std::span<const std::string_view> frame_causes() noexcept;
std::uint8_t number_of(ReceiveCause cause) noexcept;
std::uint8_t number_of(SendCause cause) noexcept;

}    // namespace anogate
