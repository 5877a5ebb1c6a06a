// When a device is reset: on request, or when its link was silent too long, but at most once per minute.
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <optional>

namespace anogate {

class ResetPolicy {
public:
    static constexpr ano::Duration apart = std::chrono::minutes{1};

    /// `silent_for`: std::nullopt if silence is no reason for a reset. Silence counts from `start`.
    constexpr ResetPolicy(std::optional<ano::Duration> silent_for, ano::TimePoint start) noexcept
        : silent_for_{silent_for}, heard_{start} {}

    /// A valid frame was received on the link.
    constexpr void heard(ano::TimePoint now) noexcept { heard_ = now; }
    /// The reset was pulsed. The silence of silent_for counts again from now.
    constexpr void pulsed(ano::TimePoint now) noexcept { heard_ = pulsed_ = now, was_pulsed_ = true; }

    /// Whether a pulse may begin.
    constexpr bool may_pulse(ano::TimePoint now) const noexcept { return !was_pulsed_ || now >= pulsed_ + apart; }
    constexpr ano::TimePoint may_pulse_at() const noexcept { return was_pulsed_ ? pulsed_ + apart : ano::TimePoint{}; }

    /// When silence causes a reset, if no frame is received until then; std::nullopt if silence is no reason.
    constexpr std::optional<ano::TimePoint> due() const noexcept {
        if (!silent_for_) return std::nullopt;
        return std::max(heard_ + *silent_for_, may_pulse_at());
    }

private:
    std::optional<ano::Duration> silent_for_;
    ano::TimePoint heard_;
    ano::TimePoint pulsed_{};
    bool was_pulsed_ = false;
};

}    // namespace anogate
