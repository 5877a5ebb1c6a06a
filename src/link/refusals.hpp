// Senders or connections that a listening link refused.
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <cstdint>
#include <string>

namespace anogate {

struct Refusals {
    static constexpr ano::Duration shown_for = std::chrono::minutes{10};

    std::uint64_t count = 0;
    ano::TimePoint last{};

    void add(ano::TimePoint now) {
        ++count;
        last = now;
    }
    bool is_recent(ano::TimePoint now) const { return count > 0 && now - last < shown_for; }
    /// Empty: none recently.
    std::string recent(ano::TimePoint now) const { return is_recent(now) ? std::to_string(count) : std::string{}; }
};

}    // namespace anogate
