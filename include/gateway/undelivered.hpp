// How long frames that are received on a link have had no receiver.
#pragma once
#include <ano/time.hpp>

#include <optional>

namespace anogate {

class Undelivered {
public:
    /// Frames further apart than this belong to different series.
    static constexpr ano::Duration pause = std::chrono::seconds{3};

    /// A frame had no receiver.
    void note(ano::TimePoint now) noexcept {
        if (!lasts(now)) since_ = now;
        last_ = now;
    }
    /// A frame had a receiver.
    void delivered() noexcept { last_ = ano::TimePoint::min(); }
    /// The time from the first to the last frame without a receiver in the present series; std::nullopt: there was none lately,
    /// or a later frame had a receiver.
    std::optional<ano::Duration> duration(ano::TimePoint now) const noexcept {
        return lasts(now) ? std::optional{last_ - since_} : std::nullopt;
    }

private:
    bool lasts(ano::TimePoint now) const noexcept { return last_ != ano::TimePoint::min() && now - last_ < pause; }

    ano::TimePoint since_{};
    ano::TimePoint last_ = ano::TimePoint::min();
};

}    // namespace anogate
