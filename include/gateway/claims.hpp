// Decides between two devices that use the same address. The device that had it first is asked first.
#pragma once
#include <ano/time.hpp>
#include <gateway/ids.hpp>

#include <algorithm>
#include <array>
#include <bitset>
#include <chrono>
#include <cstdint>
#include <optional>

namespace anogate {

/// The tests in progress, at most one per address. A test sends questions to the holder of the address, and ends with a verdict
/// if the holder does not answer. Constant time, except take(); no allocation.
class Claims {
public:
    struct Pace {
        unsigned questions = 3;
        ano::Duration answer_within = std::chrono::seconds{1};     // after each question
        ano::Duration between_tests = std::chrono::seconds{10};    // of one address, from start to start
        /// If take() is called later than this after the answer was due, the answer may have been missed, so one more question is
        /// sent.
        ano::Duration late = std::chrono::milliseconds{500};
    };

    Claims() = default;
    explicit Claims(const Pace& pace) : pace_{pace} {}

    /// Starts a test, whose first question is due now. False: a test is in progress, or the last one started too recently.
    bool begin(std::uint8_t address, ChannelId claimant, ano::TimePoint now) noexcept {
        Test& test = tests_[address];
        if (under_way_[address] || now < test.next_at) return false;
        test = {claimant, 0, now, now + pace_.between_tests};
        under_way_.set(address);
        earliest_ = std::min(earliest_, now);
        return true;
    }
    bool is_under_way(std::uint8_t address) const noexcept { return under_way_[address]; }
    /// The channel that claims the address; only for a test in progress.
    ChannelId claimant(std::uint8_t address) const noexcept { return tests_[address].claimant; }
    /// Ends the test of an address.
    void end(std::uint8_t address) noexcept {
        under_way_.reset(address);
        if (under_way_.none()) earliest_ = ano::TimePoint::max();
    }

    /// Whether an action may be due.
    bool is_due(ano::TimePoint now) const noexcept { return now >= earliest_; }
    /// When to call take() next; std::nullopt: no test is in progress.
    std::optional<ano::TimePoint> next() const noexcept { return under_way_.none() ? std::nullopt : std::optional{earliest_}; }

    struct Due {
        std::uint8_t address = 0;
        bool silent = false;    // the test is over, the holder did not answer; false: ask the holder
        ChannelId claimant{};
    };
    /// The next action that is due, if any.
    std::optional<Due> next_due(ano::TimePoint now) noexcept {
        if (!is_due(now)) return std::nullopt;
        earliest_ = ano::TimePoint::max();
        for (std::size_t a = 0; a < tests_.size(); ++a) {
            if (!under_way_[a]) continue;
            Test& test = tests_[a];
            if (now < test.due) {
                earliest_ = std::min(earliest_, test.due);
                continue;
            }
            const bool silent = test.asked >= pace_.questions && now < test.due + pace_.late;
            if (!silent) {
                ++test.asked;
                test.due = now + pace_.answer_within;
            }
            earliest_ = now;    // look for more
            if (silent) end(static_cast<std::uint8_t>(a));
            return Due{static_cast<std::uint8_t>(a), silent, test.claimant};
        }
        return std::nullopt;
    }

private:
    struct Test {
        ChannelId claimant{};
        unsigned asked = 0;
        ano::TimePoint due{};
        ano::TimePoint next_at = ano::TimePoint::min();
    };
    Pace pace_;
    std::array<Test, 256> tests_{};
    std::bitset<256> under_way_;
    ano::TimePoint earliest_ = ano::TimePoint::max();    // not later than the next due time; may be earlier
};

}    // namespace anogate
