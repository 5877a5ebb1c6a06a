// The devices that were heard, the last state of those that are vehicles, and the silence after which they are lost. Pure: the
// owner supplies frames and time.
#pragma once
#include <ano/time.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

/// A vehicle, that is, a device that sent `mode`, or another device that sent telemetry.
struct WatchedDevice {
    std::uint8_t address = 0;
    ano::TimePoint heard_at{};
    std::optional<std::uint8_t> flag{};    // `sflag`: locked, unlocked, airborne; std::nullopt: it never sent a mode
    ano::TimePoint lost_at{};              // unless a frame of it is received before
    bool is_lost = false;
    std::string elsewhere{};    // LossWatch::record_elsewhere()

    bool was_locked() const noexcept { return flag && *flag == 0; }
    /// Equal in the data that clients receive: whether it is heard, and for a lost one its last state.
    bool is_same(const WatchedDevice& other) const noexcept {
        return address == other.address && is_lost == other.is_lost &&
               (!is_lost || (flag == other.flag && elsewhere == other.elsewhere));
    }
};

class LossWatch {
public:
    /// For a vehicle, while the period of its `mode` is not known, or if it sends only other frames.
    static constexpr ano::Duration lost_after = std::chrono::seconds{2};
    /// Added to the longest of the last `periods` intervals of `mode`, so that neither jitter nor a lower rate counts as a loss.
    static constexpr ano::Duration patience = std::chrono::milliseconds{900};
    static constexpr std::size_t periods = 4;
    /// Telemetry at longer intervals is not a sign of life; a device that sends no mode is lost after this time without a frame.
    static constexpr ano::Duration rarest_telemetry = std::chrono::seconds{5};

    /// Messages that devices send without a request: those of the protocol, and flexible ones.
    static constexpr bool is_telemetry(std::uint8_t id) noexcept { return (id > 0 && id < 0x60) || (id >= 0xF1 && id <= 0xFA); }

    /// To be called for any frame except `mode`.
    void receive(std::uint8_t address, std::uint8_t id, ano::TimePoint now) noexcept;
    void record_mode(std::uint8_t address, std::uint8_t flag, ano::TimePoint now) noexcept;
    /// A frame with its address was received at `place`, and is not known to be from it: not a sign of life, but reported until
    /// the device is heard.
    void record_elsewhere(std::uint8_t address, const std::string& place) { lives_[address].elsewhere = place; }
    bool was_received_elsewhere(std::uint8_t address) const noexcept { return !lives_[address].elsewhere.empty(); }
    void forget(std::uint8_t address) noexcept { lives_[address] = {}; }

    /// The device is reported as lost until it is heard again, so a frame from another place must not end that. A vehicle that
    /// was locked may have been connected elsewhere.
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
