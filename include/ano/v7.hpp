// The previous version of the protocol, V7: 0xAA D_ADDR ID LEN(u8) DATA SC AC   (include/ano/protocol-v7.md)
//
// The address is that of the receiver. There is no source address, so a line carries several devices only if their ids differ.
// The checks are those of V8, over the shorter header.
//
// Flow:    auto room = parser.prepare();              // read into it
//          parser.commit(n, now);
//          while (auto frame = parser.next()) …       // each view is valid until the next prepare()
//          set a timer for parser.deadline(); when it is due: if (parser.expire(now)) call next() again
#pragma once
#include <ano/frame.hpp>
#include <ano/lazy_array.hpp>
#include <ano/messages.hpp>
#include <ano/prefix_sums.hpp>
#include <ano/reading.hpp>
#include <ano/schema.hpp>
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace ano::v7 {

inline constexpr std::uint8_t head = 0xAA;
inline constexpr std::size_t header_size = 4;               // HEAD to LEN
inline constexpr std::size_t overhead = header_size + 2;    // the header, SC and AC: the size of the smallest frame
inline constexpr std::size_t max_len = 255;                 // the largest LEN
inline constexpr std::size_t max_frame_size = overhead + max_len;

/// Addresses of V7 whose id in V8 differs.
namespace address {
inline constexpr std::uint8_t flight_controller = 0x05;
inline constexpr std::uint8_t data_radio = 0x10;
inline constexpr std::uint8_t optical_flow = 0x22;
inline constexpr std::uint8_t uwb = 0x30;
inline constexpr std::uint8_t imu = 0x60;
inline constexpr std::uint8_t mcu = 0x61;
inline constexpr std::uint8_t console = 0x66;
inline constexpr std::uint8_t host = 0xAF;
inline constexpr std::uint8_t broadcast = 0xFF;

/// The usual owner of this address, as text for people; empty: none is known.
constexpr std::string_view who(std::uint8_t a) noexcept {
    switch (a) {
    case flight_controller: return "flight controller";
    case data_radio: return "data radio";
    case optical_flow: return "optical flow";
    case uwb: return "UWB";
    case imu: return "IMU";
    case mcu: return "vendor MCU";
    case console: return "console";
    case host: return "host";
    case broadcast: return "broadcast";
    default: return {};
    }
}
}    // namespace address

/// A view of one complete frame with valid checks. As cheap to copy as a span. Valid as long as the memory it refers to (for a
/// frame from FrameParser: until its next prepare()).
class FrameView {
public:
    /// `bytes` must be exactly one frame with valid checks. frame_at() and FrameParser verify that.
    constexpr explicit FrameView(std::span<const std::uint8_t> bytes) noexcept : bytes_{bytes} {}

    constexpr std::uint8_t destination() const noexcept { return bytes_[1]; }
    constexpr std::uint8_t id() const noexcept { return bytes_[2]; }
    constexpr std::span<const std::uint8_t> data() const noexcept {
        return bytes_.subspan(header_size, bytes_.size() - overhead);
    }
    constexpr Checks checks() const noexcept { return {bytes_[bytes_.size() - 2], bytes_[bytes_.size() - 1]}; }
    /// HEAD to AC.
    constexpr std::span<const std::uint8_t> bytes() const noexcept { return bytes_; }

private:
    std::span<const std::uint8_t> bytes_;
};

/// The frame at the beginning of `bytes`; std::nullopt unless it is complete, its LEN is at most `max_data` and both checks are
/// right.
constexpr std::optional<FrameView> frame_at(std::span<const std::uint8_t> bytes, std::size_t max_data = max_len) noexcept {
    if (bytes.size() < overhead || bytes[0] != head) return std::nullopt;
    const std::size_t length = bytes[3];
    if (length > max_data || bytes.size() < overhead + length) return std::nullopt;
    const FrameView frame{bytes.first(overhead + length)};
    if (checks_of(frame.bytes().first(header_size + length)) != frame.checks()) return std::nullopt;
    return frame;
}

/// Writes HEAD to LEN to the beginning of `frame`, which has header_size bytes or more; `length`: bytes of DATA, at most max_len.
/// seal() (ano/frame.hpp) writes the checks.
constexpr void write_header(std::span<std::uint8_t> frame, std::uint8_t destination, std::uint8_t id,
                            std::size_t length) noexcept {
    frame[0] = head;
    frame[1] = destination;
    frame[2] = id;
    frame[3] = static_cast<std::uint8_t>(length);
}

/// Writes one frame to the beginning of `out` and returns its size. Returns 0 and writes nothing if `out` has fewer than overhead
/// + data.size() bytes or the data exceed max_len. `data` must not overlap `out`.
constexpr std::size_t encode(std::span<std::uint8_t> out, std::uint8_t destination, std::uint8_t id,
                             std::span<const std::uint8_t> data) noexcept {
    if (data.size() > max_len || out.size() < overhead + data.size()) return 0;
    const auto frame = out.first(overhead + data.size());
    write_header(frame, destination, id, data.size());
    for (std::size_t i = 0; i < data.size(); ++i) frame[header_size + i] = data[i];
    seal(frame);
    return frame.size();
}

/// Counters of the bytes. bytes_in = the bytes of valid frames + skipped_bytes + the waiting bytes.
struct ParserCounters {
    std::uint64_t frames_in{};
    std::uint64_t bytes_in{};
    std::uint64_t bad_check{};        // candidates with a wrong checksum
    std::uint64_t bad_length{};       // candidates whose LEN is above max_data
    std::uint64_t skipped_bytes{};    // bytes outside of valid frames
    std::uint64_t expired{};          // candidates whose end was not received, or only after a valid frame that follows them
};

/// Finds the frames in a stream of bytes, as ano::FrameParser does for V8. After a refused candidate the search continues one
/// byte later, so that a damaged frame never takes others with it. The time is linear for any input. A candidate whose rest is
/// missing waits for it, so a damaged LEN delays the frames behind it by at most 261 bytes or `quiet`. Neither throws nor
/// allocates after construction.
class FrameParser {
public:
    struct Options {
        std::size_t max_data = max_len;    // a larger LEN is refused
        Duration quiet = std::chrono::milliseconds{
            20};    // after this time without a byte, a waiting candidate makes way for a valid frame
        // Pauses of this length are normal inside a frame: after `quiet`, a candidate is given up only if valid frames after it end
        // with the last byte received. Zero: not set.
        Duration frame_gap{};
    };
    /// After this time without a byte (or `quiet` or `frame_gap`, if that is longer), waiting candidates are given up.
    static constexpr Duration patience = std::chrono::milliseconds{200};

    explicit FrameParser(Options options);

    /// Room for the next bytes, at least 4096 if next() was called until it returned std::nullopt. Invalidates all views.
    std::span<std::uint8_t> prepare() noexcept;
    /// `n` bytes of that room were filled at `now`.
    void commit(std::size_t n, TimePoint now) noexcept;
    /// The next valid frame; std::nullopt: none is complete.
    std::optional<FrameView> next() noexcept;

    /// Call before the bytes of a datagram are written. The rest of the previous one is kept only if it is younger than 100 ms
    /// (or `quiet` or `frame_gap`, if that is longer) and `datagram` does not itself start with a complete valid frame.
    void begin_datagram(std::span<const std::uint8_t> datagram, TimePoint now) noexcept;
    /// The input ends here: next() no longer waits for the rest of a candidate. Bytes committed later are parsed separately.
    void finish() noexcept { barrier_ = end_; }
    /// Gives up candidates that delay a valid frame or whose rest is overdue. True: call next() again.
    bool expire(TimePoint now) noexcept;
    /// When to call expire(); std::nullopt: no candidate waits for its rest.
    std::optional<TimePoint> deadline() const noexcept;

    /// Bytes that wait for the rest of their frame.
    std::size_t waiting() const noexcept { return end_ - pos_; }
    /// Those bytes; valid until the next prepare().
    std::span<const std::uint8_t> rest() const noexcept { return {buffer_.get() + pos_, end_ - pos_}; }
    const ParserCounters& counters() const noexcept { return counters_; }

private:
    enum class Verdict { good, bad, too_long, incomplete };

    Verdict judge(std::size_t at, std::size_t limit) const noexcept;
    std::size_t find_head(std::size_t from) const noexcept;
    std::size_t find_good_frame_behind(std::size_t at) const noexcept;
    std::size_t find_good_frames_to_the_end(std::size_t at) const noexcept;
    Duration longest_pause() const noexcept { return std::max(options_.quiet, options_.frame_gap); }

    Options options_;
    LazyArray<std::uint8_t> buffer_;
    PrefixSums sums_;             // over all committed bytes: checking a candidate takes constant time
    std::size_t pos_ = 0;         // first byte not yet checked
    std::size_t end_ = 0;         // end of the committed bytes
    std::size_t barrier_ = 0;     // the rest of a candidate that begins before this was not received: it ends here
    bool none_behind_ = false;    // no valid frame was found behind the waiting candidate since the last byte arrived
    bool none_at_end_ = false;    // the same for valid frames that end with the last byte
    TimePoint last_arrival_{};
    ParserCounters counters_;
};

namespace table {

using namespace ano::table;

// clang-format off
/// The messages whose DATA differ from those of V8, and the messages that V8 has under another id.
inline constexpr Message differences[] = {
    {0x01, "inertial", "Accelerometer, in a unit of the device, and gyroscope", sensor, {
        {"acc_x", i16}, {"acc_y", i16}, {"acc_z", i16},
        {"gyr_x", i16, times(32768, 2000), "°/s"}, {"gyr_y", i16, times(32768, 2000), "°/s"},
        {"gyr_z", i16, times(32768, 2000), "°/s"}, {"shock_sta", u8}}},
    {0x02, "compass", "Magnetometer, barometric altitude and temperature", sensor, {
        {"mag_x", i16}, {"mag_y", i16}, {"mag_z", i16}, {"alt_bar", i32, "cm"},
        {"tmp", i16, times(100), "°C", note("the vendor's text has ×10, devices have ×100")},
        {"bar_sta", u8}, {"mag_sta", u8}}},
    {0x05, "altitude", "Altitude fused and by the additional sensor", sensor, {
        {"alt_fu", i32, "cm"}, {"alt_add", i32, "cm"}, {"alt_sta", u8}}},
    {0x08, "position", "Position relative to the take-off point, without height", sensor, {
        {"pos_x", i32, "cm"}, {"pos_y", i32, "cm"}}},
    {0x32, "general_position", "Position by an external sensor; X forward and Y left at unlock", sensor, {
        {"pos_x", i32, "cm", NoData{INT32_MIN}}, {"pos_y", i32, "cm", NoData{INT32_MIN}},
        {"pos_z", i32, "cm", NoData{INT32_MIN}}}},
    {0x34, "ranging", "Distance at an angle", sensor_by_kind, {
        {"direction", u8}, {"angle", u16, "°"}, {"dist", u32, "cm", NoData{UINT32_MAX}}}},
    {0xA1, "log_value", "A number and a line of text", report, {{"val", i32}, {"str", text}}},
    {0xE0, "command", "Runs a command", urgent, {
        {"cid", u8}, {"cmd0", u8}, {"cmd1", u8}, {"values", bytes, Role::values, note("packed; zeros up to 11 bytes of DATA")}}},
    {0xE1, "parameter_read", "Requests the value of a parameter", urgent, {{"par_id", u16}}},
    {0xE2, "parameter_value", "The value of a parameter, as an answer or to be written", urgent, {
        {"par_id", u16}, {"val", i32, note("0x80000000: no such parameter")}}},
};
// clang-format on

inline constexpr MessageIndex differences_index = index_messages(differences);

/// Messages of V8 that V7 does not have. V7 uses 0xFB without DATA for something else.
constexpr bool is_new_in_v8(std::uint8_t id) noexcept {
    switch (id) {
    case 0x31:
    case 0x35:
    case 0xB0:
    case 0xB1:
    case 0xB2:
    case 0xC0:
    case 0xC1:
    case 0xC2:
    case 0xE3:
    case 0xF0:
    case 0xFB: return true;
    default: return false;
    }
}

}    // namespace table

/// Whether the DATA of `id` are the same in V8.
constexpr bool is_same_in_v8(std::uint8_t id) noexcept {
    return table::differences_index.count[id] == 0 && !table::is_new_in_v8(id);
}

/// Every layout of a message of V7, the base layout first; empty for an id that is not listed.
constexpr std::span<const Message> layouts_of(std::uint8_t id) noexcept {
    if (table::differences_index.count[id] != 0)
        return std::span{table::differences}.subspan(table::differences_index.first[id], table::differences_index.count[id]);
    return table::is_new_in_v8(id) ? std::span<const Message>{} : ano::layouts_of(id);
}

/// The base layout of the message with this name; nullptr: V7 has none.
constexpr const Message* find_message(std::string_view name) noexcept {
    for (const Message& row : table::differences)
        if (row.name == name) return &row;
    for (const Message& row : messages)
        if (row.name == name) return is_same_in_v8(row.id) ? &row : nullptr;
    return nullptr;
}

/// Reads DATA of a frame. `flexible` contains the layouts of flexible messages for devices whose id in V8 is `source`.
inline Reading read(FrameView frame, const FlexibleLayouts* flexible = nullptr, std::uint8_t source = 0) noexcept {
    return read_in(layouts_of(frame.id()), frame.id(), frame.data(), flexible, source);
}

}    // namespace ano::v7
