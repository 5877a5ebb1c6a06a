// For how long nobody has taken what a link brings.
#pragma once
#include <ano/time.hpp>

#include <optional>

namespace anogate {

class Untaken {
public:
    /// What is further apart is no flow.
    static constexpr ano::Duration pause = std::chrono::seconds{3};

    /// One more that had no taker.
    void note(ano::TimePoint now) noexcept {
        if (!lasts(now)) since_ = now;
        last_ = now;
    }
    /// One that had a taker.
    void taken() noexcept { last_ = ano::TimePoint::min(); }
    /// From the first to the last of them that were no pause apart; nothing: there was none lately, or one was taken since.
    std::optional<ano::Duration> duration(ano::TimePoint now) const noexcept {
        return lasts(now) ? std::optional{last_ - since_} : std::nullopt;
    }

private:
    bool lasts(ano::TimePoint now) const noexcept { return last_ != ano::TimePoint::min() && now - last_ < pause; }

    ano::TimePoint since_{};
    ano::TimePoint last_ = ano::TimePoint::min();
};

}    // namespace anogate
