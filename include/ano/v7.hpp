// The older protocol V7: 0xAA D_ADDR ID LEN(u8) DATA SC AC. Sources and evidence: note "protocol-v7", sections 1 to 4. A frame states its
// receiver alone: it has no source.
//
// Flow:    as for FrameParser (parser.hpp)
#pragma once
#include <ano/frame.hpp>
#include <ano/messages.hpp>
#include <ano/prefix_sums.hpp>
#include <ano/room.hpp>
#include <ano/time.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace ano::v7 {

inline constexpr std::uint8_t head = 0xAA;
inline constexpr std::size_t header_size = 4;               // HEAD to LEN
inline constexpr std::size_t overhead = header_size + 2;    // the header, SC and AC
inline constexpr std::size_t max_len = 255;                 // the largest LEN
inline constexpr std::size_t max_frame_size = overhead + max_len;

/// Receivers (section 2).
namespace address {
inline constexpr std::uint8_t tuokongzhe = 0x05, data_radio = 0x10, flow = 0x22, lx_imu = 0x60, lx_mcu = 0x61;
inline constexpr std::uint8_t console = 0x66, host = 0xAF, broadcast = 0xFF;
}    // namespace address

/// A view of one whole V7 frame whose checks hold. Valid as long as the memory it refers to.
class FrameView {
public:
    /// `bytes` must be exactly one frame whose checks hold: use frame_at() or Parser to find out.
    constexpr explicit FrameView(std::span<const std::uint8_t> bytes) noexcept : bytes_{bytes} {}

    constexpr std::uint8_t destination() const noexcept { return bytes_[1]; }
    constexpr std::uint8_t id() const noexcept { return bytes_[2]; }
    /// 0 to 255 bytes.
    constexpr std::span<const std::uint8_t> data() const noexcept {
        return bytes_.subspan(header_size, bytes_.size() - overhead);
    }
    constexpr Checks checks() const noexcept { return {bytes_[bytes_.size() - 2], bytes_[bytes_.size() - 1]}; }
    /// HEAD to AC.
    constexpr std::span<const std::uint8_t> bytes() const noexcept { return bytes_; }

private:
    std::span<const std::uint8_t> bytes_;
};

/// The frame at the beginning of `bytes`; std::nullopt unless it is whole and both checks hold.
constexpr std::optional<FrameView> frame_at(std::span<const std::uint8_t> bytes) noexcept {
    if (bytes.size() < overhead || bytes[0] != head || bytes.size() < overhead + bytes[3]) return std::nullopt;
    const FrameView frame{bytes.first(overhead + bytes[3])};
    if (checks_of(frame.bytes().first(header_size + bytes[3])) != frame.checks()) return std::nullopt;
    return frame;
}

/// Writes one frame to the front of `out` and returns its size; 0, and nothing written, when `out` has not
/// overhead + data.size() bytes or the data exceed max_len. `data` may not overlap `out`.
constexpr std::size_t encode(std::span<std::uint8_t> out, std::uint8_t destination, std::uint8_t id,
                             std::span<const std::uint8_t> data) noexcept {
    if (data.size() > max_len || out.size() < overhead + data.size()) return 0;
    const auto frame = out.first(overhead + data.size());
    frame[0] = head;
    frame[1] = destination;
    frame[2] = id;
    frame[3] = static_cast<std::uint8_t>(data.size());
    for (std::size_t i = 0; i < data.size(); ++i) frame[header_size + i] = data[i];
    seal(frame);
    return frame.size();
}

/// What became of the bytes. bytes_in = the bytes of good frames + skipped_bytes + those still waiting.
struct ParserCounters {
    std::uint64_t frames_in{};
    std::uint64_t bytes_in{};
    std::uint64_t bad_check{};        // candidates whose checks do not hold
    std::uint64_t skipped_bytes{};    // bytes that belong to no good frame
    std::uint64_t expired{};          // candidates whose end never came, or came after a good frame behind them
};

/// After a refused candidate it looks again one byte later, so that a damaged frame costs no other frame; any input costs linear
/// time. A candidate whose rest is not there yet waits for at most max_frame_size bytes. When no byte came for `quiet`, it gives way
/// to a good frame behind it. Neither throws nor allocates after construction.
class Parser {
public:
    struct Options {
        Duration quiet = std::chrono::milliseconds{20};    // longer than the pauses inside a frame
    };
    explicit Parser(Options options);
    Parser() : Parser(Options{}) {}

    /// Room for the next bytes, at least one if next() was called until it returned std::nullopt. Every view becomes invalid.
    std::span<std::uint8_t> prepare() noexcept;
    /// `n` bytes of that room were filled at `now`.
    void commit(std::size_t n, TimePoint now) noexcept;
    /// The next good frame; std::nullopt when none is whole.
    std::optional<FrameView> next() noexcept;

    /// Call before the bytes of a datagram are put in. The rest of the previous one is kept only if it is younger than 100 ms and
    /// `datagram` does not itself start with a good frame.
    void begin_datagram(std::span<const std::uint8_t> datagram, TimePoint now) noexcept;
    /// The input ends here: next() no longer waits for the rest of a candidate.
    void finish() noexcept { barrier_ = end_; }
    /// Gives up a candidate that holds back a good frame. True: call next() again.
    bool expire(TimePoint now) noexcept;
    /// When expire() may have something to do; std::nullopt while it has not.
    std::optional<TimePoint> deadline() const noexcept;

    /// Bytes that wait for the rest of their frame.
    std::size_t waiting() const noexcept { return end_ - pos_; }
    /// Those bytes; valid until the next prepare().
    std::span<const std::uint8_t> rest() const noexcept { return {buffer_.get() + pos_, end_ - pos_}; }
    const ParserCounters& counters() const noexcept { return counters_; }

private:
    enum class Verdict : std::uint8_t { good, bad, incomplete };

    std::size_t find_head(std::size_t from) const noexcept;
    Verdict judge(std::size_t at, std::size_t limit) noexcept;
    bool checks_hold(std::size_t at, std::size_t to) noexcept;

    static constexpr std::size_t capacity = 4096 + 2 * max_frame_size;

    Options options_;
    Room<std::uint8_t> buffer_{capacity};
    std::size_t pos_ = 0;        // first byte not yet judged
    std::size_t end_ = 0;        // end of the bytes put in
    std::size_t barrier_ = 0;    // a candidate that begins before this does not wait for its rest

    // As in FrameParser: sums are made only behind a refused candidate.
    PrefixSums sums_{capacity};
    std::size_t sums_until_ = 0;

    bool none_behind_ = false;    // no good frame was found behind the waiting candidate since the last byte came
    TimePoint last_arrival_{};
    ParserCounters counters_;
};

// clang-format off
namespace table {
using namespace ano::table;

/// The messages whose DATA differ from V8 (section 4). All others of V7 have the DATA of V8.
inline constexpr Message messages[] = {
    {0x01, "inertial", "Accelerometer and gyroscope; the scale of the accelerometer depends on the device", sensor, {
        {"acc_x", i16}, {"acc_y", i16}, {"acc_z", i16},
        {"gyr_x", i16, times(32768, 2000), "°/s"}, {"gyr_y", i16, times(32768, 2000), "°/s"},
        {"gyr_z", i16, times(32768, 2000), "°/s"}, {"shock_sta", u8}}},
    {0x02, "compass", "Magnetometer, barometric altitude and temperature", sensor, {
        {"mag_x", i16}, {"mag_y", i16}, {"mag_z", i16}, {"alt_bar", i32, "cm"},
        {"tmp", i16, times(100), "°C", note("×10 in the protocol text, ×100 in devices")}, {"bar_sta", u8}, {"mag_sta", u8}}},
    {0x05, "altitude", "Altitude fused and by the additional sensor", sensor, {
        {"alt_fu", i32, "cm"}, {"alt_add", i32, "cm"}, {"alt_sta", u8}}},
    {0x08, "position", "Offset from the place of take-off", sensor, {
        {"pos_x", i32, "cm"}, {"pos_y", i32, "cm"}}},
    {0x32, "general_position", "Position by an external sensor; X forward and Y left at unlock", sensor, {
        {"pos_x", i32, "cm", NoData{INT32_MIN}}, {"pos_y", i32, "cm", NoData{INT32_MIN}},
        {"pos_z", i32, "cm", NoData{INT32_MIN}}}},
    {0x34, "ranging", "Distance at an angle", sensor_by_kind, {
        {"direction", u8}, {"angle", u16, "°", range(0, 359)}, {"dist", u32, "cm", NoData{0xFFFFFFFF}}}},
    {0xA1, "log_value", "A number and a line of text", report, {{"val", i32}, {"str", text}}},
    {0xE0, "command", "Runs a command", urgent, {
        {"cid", u8}, {"cmd0", u8}, {"cmd1", u8}, {"values", bytes, Role::values}}},
    {0xE1, "parameter_read", "Asks for the value of a parameter", urgent, {{"par_id", u16}}},
    {0xE2, "parameter", "The value of a parameter: an answer, or a write", urgent, {{"par_id", u16}, {"val", i32}}},
    {0xFB, "redraw", "The wave display of the host redraws", urgent, {{"data", bytes}}},
};
inline constexpr MessageIndex index = index_messages(messages);

/// Messages of V8 that V7 does not have.
inline constexpr std::uint8_t not_in_v7[] = {0x31, 0x35, 0xB0, 0xB1, 0xB2, 0xC0, 0xC1, 0xC2, 0xE3, 0xF0};
}    // namespace table
// clang-format on

/// Every layout of a message of V7, from its own table or from V8's; empty for an id that V7 does not list.
constexpr std::span<const Message> layouts_of(std::uint8_t id) noexcept {
    if (table::index.count[id] != 0) return std::span{table::messages}.subspan(table::index.first[id], table::index.count[id]);
    for (const std::uint8_t other : table::not_in_v7)
        if (id == other) return {};
    return ano::layouts_of(id);
}

/// The base layout of a message of V7 whose DATA differ from V8; nullptr where they do not.
constexpr const Message* find_difference(std::uint8_t id) noexcept {
    return table::index.count[id] == 0 ? nullptr : &table::messages[table::index.first[id]];
}

}    // namespace ano::v7
