// Which devices were heard, the last state of those that are vehicles, and after which silence they are lost. Pure: frames and the time come
// from its owner.
#pragma once
#include <ano/time.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

/// A vehicle, which sent `mode`, or another device that sent telemetry.
struct WatchedDevice {
    std::uint8_t address = 0;
    ano::TimePoint heard_at{};
    std::optional<std::uint8_t> flag{};    // `sflag`: locked, unlocked, airborne; std::nullopt: it never sent a mode
    ano::TimePoint lost_at{};              // if it is not heard until then
    bool is_lost = false;
    std::string elsewhere{};    // LossWatch::hear_elsewhere()

    bool was_locked() const noexcept { return flag && *flag == 0; }
    /// The same for who is told whether it is heard, and of a lost one, its last state.
    bool is_same(const WatchedDevice& other) const noexcept {
        return address == other.address && is_lost == other.is_lost &&
               (!is_lost || (flag == other.flag && elsewhere == other.elsewhere));
    }
};

class LossWatch {
public:
    /// Of a vehicle, while the period of its `mode` is not known, or it sends other frames alone.
    static constexpr ano::Duration lost_after = std::chrono::seconds{2};
    /// Beside the longest of the last `periods` intervals of `mode`, so that neither jitter nor a lower rate is a loss.
    static constexpr ano::Duration patience = std::chrono::milliseconds{900};
    static constexpr std::size_t periods = 4;
    /// Telemetry that is rarer is no sign of life; a device that sends no mode is silent for as long before it is lost.
    static constexpr ano::Duration rarest_telemetry = std::chrono::seconds{5};

    /// Devices send such messages by themselves: those of the protocol, and flexible ones.
    static constexpr bool is_telemetry(std::uint8_t id) noexcept { return (id > 0 && id < 0x60) || (id >= 0xF1 && id <= 0xFA); }

    /// Any frame that is no `mode`.
    void hear(std::uint8_t address, std::uint8_t id, ano::TimePoint now) noexcept;
    void hear_mode(std::uint8_t address, std::uint8_t flag, ano::TimePoint now) noexcept;
    /// A frame in its name came by `place`, and it is not known to be from it: no sign of life, but told until it is
    /// heard.
    void hear_elsewhere(std::uint8_t address, const std::string& place) { lives_[address].elsewhere = place; }
    bool is_told_elsewhere(std::uint8_t address) const noexcept { return !lives_[address].elsewhere.empty(); }
    void forget(std::uint8_t address) noexcept { lives_[address] = {}; }

    /// It is told as lost until it is heard again, so a frame from another place must not end that. A vehicle that was locked may have been
    /// connected elsewhere.
    bool stays_lost(std::uint8_t address) const noexcept {
        const Life& life = lives_[address];
        return life.flag ? *life.flag != 0 : life.sends_telemetry();
    }
    /// Returns std::nullopt if it sent neither `mode` nor telemetry.
    std::optional<WatchedDevice> device(std::uint8_t address, ano::TimePoint now) const;

private:
    struct Life {
        static constexpr std::uint8_t enough = 2;
        bool sends_telemetry() const noexcept { return intervals >= enough; }
        ano::Duration allowed_silence() const noexcept;

        ano::TimePoint heard_at{};             // any frame
        ano::TimePoint at{};                   // of the last mode or telemetry
        std::uint8_t intervals = 0;            // between frames of telemetry, up to `enough`
        std::optional<std::uint8_t> flag{};    // of the last mode
        ano::TimePoint mode_at{};
        std::array<ano::Duration, periods> mode_intervals{};
        std::size_t mode_count = 0;    // of its intervals
        std::string elsewhere;
    };

    std::array<Life, 256> lives_{};
};

}    // namespace anogate
