// One ANO V8 frame: 0xAB S_ADDR D_ADDR ID LEN(u16, little-endian) DATA SC AC   (protocol text, section 1)
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <type_traits>

namespace ano {

inline constexpr std::uint8_t head = 0xAB;
inline constexpr std::size_t header_size = 6;               // HEAD to LEN
inline constexpr std::size_t overhead = header_size + 2;    // the header, SC and AC: the size of the smallest frame
inline constexpr std::size_t max_len = 65535;               // the largest LEN
inline constexpr std::size_t max_frame_size = overhead + max_len;

/// Both check bytes of a frame.
struct Checks {
    std::uint8_t sum;    // SC: the sum of every byte from HEAD to the end of DATA, mod 256
    std::uint8_t add;    // AC: the sum of the successive values of SC, mod 256
    friend constexpr bool operator==(Checks, Checks) = default;
};

/// checks_of() for many bytes: processes several bytes at a time.
Checks checks_of_many(std::span<const std::uint8_t> bytes) noexcept;

/// The checks over `bytes`, which are HEAD to the end of DATA. Takes linear time and never fails.
constexpr Checks checks_of(std::span<const std::uint8_t> bytes) noexcept {
    if (!std::is_constant_evaluated() && bytes.size() >= 32) return checks_of_many(bytes);
    unsigned sum = 0;    // only the low byte of each sum is used
    unsigned add = 0;
    for (const std::uint8_t byte : bytes) {
        sum += byte;
        add += sum;
    }
    return {static_cast<std::uint8_t>(sum), static_cast<std::uint8_t>(add)};
}

/// A view of one complete frame with valid checks. As cheap to copy as a span. Valid as long as the memory it refers to (for a
/// frame from FrameParser: until its next prepare()).
class FrameView {
public:
    /// `bytes` must be exactly one frame with valid checks. frame_at() and FrameParser verify that.
    constexpr explicit FrameView(std::span<const std::uint8_t> bytes) noexcept : bytes_{bytes} {}

    constexpr std::uint8_t source() const noexcept { return bytes_[1]; }
    constexpr std::uint8_t destination() const noexcept { return bytes_[2]; }
    constexpr std::uint8_t id() const noexcept { return bytes_[3]; }
    constexpr std::span<const std::uint8_t> data() const noexcept {
        return bytes_.subspan(header_size, bytes_.size() - overhead);
    }
    constexpr Checks checks() const noexcept { return {bytes_[bytes_.size() - 2], bytes_[bytes_.size() - 1]}; }
    /// HEAD to AC.
    constexpr std::span<const std::uint8_t> bytes() const noexcept { return bytes_; }

private:
    std::span<const std::uint8_t> bytes_;
};

/// LEN of the frame that begins at `header`, which has header_size bytes or more: 0 to 65535.
constexpr std::size_t data_length(const std::uint8_t* header) noexcept {
    return static_cast<std::size_t>(header[4] | header[5] << 8);
}

/// The frame at the beginning of `bytes`; std::nullopt unless it is complete, its LEN is at most `max_data` and both checks are
/// right.
constexpr std::optional<FrameView> frame_at(std::span<const std::uint8_t> bytes, std::size_t max_data = max_len) noexcept {
    if (bytes.size() < overhead || bytes[0] != head) return std::nullopt;
    const std::size_t length = data_length(bytes.data());
    if (length > max_data || bytes.size() < overhead + length) return std::nullopt;
    const FrameView frame{bytes.first(overhead + length)};
    if (checks_of(frame.bytes().first(header_size + length)) != frame.checks()) return std::nullopt;
    return frame;
}

/// Writes both checks to the end of a frame; `frame` is HEAD to AC, and its LEN must agree with its size.
constexpr void seal(std::span<std::uint8_t> frame) noexcept {
    const Checks checks = checks_of(frame.first(frame.size() - 2));
    frame[frame.size() - 2] = checks.sum;
    frame[frame.size() - 1] = checks.add;
}

/// Writes HEAD to LEN to the beginning of `frame`, which has header_size bytes or more; `length`: bytes of DATA, at most max_len.
constexpr void write_header(std::span<std::uint8_t> frame, std::uint8_t source, std::uint8_t destination, std::uint8_t id,
                            std::size_t length) noexcept {
    frame[0] = head;
    frame[1] = source;
    frame[2] = destination;
    frame[3] = id;
    frame[4] = static_cast<std::uint8_t>(length);
    frame[5] = static_cast<std::uint8_t>(length >> 8);
}

/// Writes one frame to the beginning of `out` and returns its size. Returns 0 and writes nothing if `out` has fewer than overhead
/// + data.size() bytes or the data exceed max_len. `data` must not overlap `out`.
constexpr std::size_t encode(std::span<std::uint8_t> out, std::uint8_t source, std::uint8_t destination, std::uint8_t id,
                             std::span<const std::uint8_t> data) noexcept {
    if (data.size() > max_len || out.size() < overhead + data.size()) return 0;
    const auto frame = out.first(overhead + data.size());
    write_header(frame, source, destination, id, data.size());
    for (std::size_t i = 0; i < data.size(); ++i) frame[header_size + i] = data[i];
    seal(frame);
    return frame.size();
}

}    // namespace ano
