// The last log lines of devices (0xA0, 0xA1), in bounded memory. Pure.
#pragma once
#include <ano/frame.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

class DeviceLog {
public:
    static constexpr std::size_t max_lines = 500;      // per device and Origin
    static constexpr std::size_t max_of_all = 4000;    // of all devices; beyond that, the device with the most lines loses its
                                                       // oldest
    static constexpr std::size_t max_text = 400;       // bytes per line
    static constexpr std::uint8_t red_color = 1;

    /// `known`: received on a serial port, CAN or another link that is not a network, or on the link that the address is pinned
    /// to. Any program can send the others: red lines among them do not count, and they never displace a line of a known origin.
    enum class Origin : std::uint8_t { known, anybody };

    struct Line {
        std::uint64_t number = 0;                     // of all lines since the start, from 1
        std::uint64_t of_device = 0;                  // of those of its device, from 1
        std::uint64_t time_ns = 0;                    // Unix
        std::string link;                             // on which it was received
        std::uint8_t color = 0;                       // as in 0xA0; 1: red
        std::optional<float> value = std::nullopt;    // of 0xA1
        std::string text;                             // bytes of the device, in its encoding
        Origin origin = Origin::known;
        bool is_red() const noexcept { return color == red_color; }
        /// Since 1970, to the microsecond.
        double seconds() const noexcept {
            const std::uint64_t microseconds = time_ns / 1000;
            return static_cast<double>(microseconds) / 1e6;
        }
    };

    /// To be called for each frame received where the route of its source leads; all frames except log lines of devices are
    /// ignored. False: it is not a log line, or memory is short.
    bool receive(ano::FrameView frame, std::string_view link, std::uint64_t time_ns, Origin origin = Origin::known) noexcept;

    /// Oldest first. Valid until the next hear().
    const std::deque<Line>& lines(std::uint8_t address) const noexcept;
    /// The number of the last line of any device; 0: none yet.
    std::uint64_t last() const noexcept { return last_; }
    /// Lines of the device since the start, and how many of them were red and of a known origin.
    std::uint64_t count(std::uint8_t address) const noexcept { return kept_[address] ? kept_[address]->count : 0; }
    std::uint64_t red(std::uint8_t address) const noexcept { return kept_[address] ? kept_[address]->red : 0; }

private:
    struct Kept {
        std::deque<Line> lines;
        std::array<std::size_t, 2> of_origin{};    // number of lines, by Origin
        std::uint64_t count = 0, red = 0;
    };
    Kept* fullest(Origin origin) noexcept;
    void make_room(Kept& of, Origin origin) noexcept;
    void forget_oldest(Kept& of, Origin origin) noexcept;

    std::array<std::unique_ptr<Kept>, 256> kept_{};
    std::size_t size_ = 0;    // lines of all devices
    std::uint64_t last_ = 0;
};

}    // namespace anogate
