#include <ros2/arrival_envelope.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace arrival_envelope_tests {
namespace {

using anogate::ArrivalEnvelope;

constexpr double ms = 1e6;
constexpr std::uint64_t start = 5'000'000'000;

/// Arrivals in the order of time: a delay does not let messages overtake each other.
template <class Delay>
std::vector<std::uint64_t> arrivals_of(std::size_t count, double period, Delay delay) {
    std::vector<std::uint64_t> arrivals;
    std::uint64_t last = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double at = static_cast<double>(start) + period * static_cast<double>(i) + delay();
        last = std::max(last, static_cast<std::uint64_t>(at));
        arrivals.push_back(last);
    }
    return arrivals;
}

/// The 99th percentile of the errors, in ms, from message 100 on.
double p99(const std::vector<std::uint64_t>& stamps, double period) {
    std::vector<double> errors;
    for (std::size_t i = 100; i < stamps.size(); ++i)
        errors.push_back(std::abs(static_cast<double>(stamps[i] - start) - period * static_cast<double>(i)) / ms);
    std::sort(errors.begin(), errors.end());
    return errors[errors.size() * 99 / 100];
}

std::vector<std::uint64_t> stamps_of(const std::vector<std::uint64_t>& arrivals) {
    ArrivalEnvelope envelope;
    std::vector<std::uint64_t> stamps;
    for (const std::uint64_t arrival : arrivals) stamps.push_back(envelope.stamp(arrival));
    return stamps;
}

TEST(ArrivalEnvelope, jitter_of_10_ms_becomes_at_most_1_ms_at_100_hz) {
    std::mt19937_64 random{7};
    std::uniform_real_distribution<double> even{0, 10 * ms};
    const auto uniform = arrivals_of(5000, 10 * ms, [&] { return even(random); });
    EXPECT_GT(p99(uniform, 10 * ms), 9.5);
    EXPECT_LE(p99(stamps_of(uniform), 10 * ms), 1);

    std::exponential_distribution<double> tail{std::log(100) / (10 * ms)};    // 1 % above 10 ms
    const auto exponential = arrivals_of(5000, 10 * ms, [&] { return tail(random); });
    EXPECT_GT(p99(exponential, 10 * ms), 9);
    EXPECT_LE(p99(stamps_of(exponential), 10 * ms), 1);
}

TEST(ArrivalEnvelope, a_stamp_is_never_in_the_future_never_goes_back_and_is_at_most_one_period_back) {
    std::mt19937_64 random{11};
    std::exponential_distribution<double> tail{1 / (20 * ms)};
    const auto arrivals = arrivals_of(3000, 10 * ms, [&] { return tail(random); });
    const auto stamps = stamps_of(arrivals);
    for (std::size_t i = 0; i < stamps.size(); ++i) {
        ASSERT_LE(stamps[i], arrivals[i]) << i;
        ASSERT_GE(static_cast<double>(stamps[i]), static_cast<double>(arrivals[i]) - 1.2 * 10 * ms)
            << i;    // the period is an estimate
        if (i == 0) continue;
        ASSERT_GE(stamps[i], stamps[i - 1]) << i;
    }
}

TEST(ArrivalEnvelope, after_a_lost_message_at_most_ten_stamps_are_early) {
    std::vector<std::uint64_t> arrivals;
    for (std::uint64_t i = 0; i < 300; ++i)
        if (i != 150) arrivals.push_back(start + i * 10'000'000);
    const auto stamps = stamps_of(arrivals);
    int early = 0;
    for (std::size_t i = 0; i < stamps.size(); ++i) early += stamps[i] != arrivals[i] ? 1 : 0;
    EXPECT_LE(early, 10);
}

TEST(ArrivalEnvelope, follows_another_rate) {
    std::vector<std::uint64_t> arrivals;
    std::uint64_t at = start;
    for (int i = 0; i < 200; ++i) arrivals.push_back(at += 10'000'000);
    for (int i = 0; i < 200; ++i) arrivals.push_back(at += 50'000'000);
    for (int i = 0; i < 300; ++i) arrivals.push_back(at += 5'000'000);
    const auto stamps = stamps_of(arrivals);
    EXPECT_EQ(stamps[399], arrivals[399]);
    EXPECT_EQ(stamps.back(), arrivals.back());
}

TEST(ArrivalEnvelope, messages_without_a_period_keep_their_arrival) {
    std::mt19937_64 random{3};
    std::exponential_distribution<double> gap{1 / (300 * ms)};
    std::vector<std::uint64_t> arrivals;
    std::uint64_t at = start;
    for (int i = 0; i < 1000; ++i) arrivals.push_back(at += static_cast<std::uint64_t>(gap(random)) + 1);
    const auto stamps = stamps_of(arrivals);
    std::size_t changed = 0;
    for (std::size_t i = 0; i < stamps.size(); ++i) changed += stamps[i] != arrivals[i] ? 1u : 0u;
    EXPECT_LT(changed, stamps.size() / 10);
}

TEST(ArrivalEnvelope, begins_anew_if_the_clock_goes_back) {
    ArrivalEnvelope envelope;
    for (std::uint64_t i = 0; i < 50; ++i) envelope.stamp(start + i * 10'000'000);
    EXPECT_EQ(envelope.stamp(1000), 1000u);
    EXPECT_EQ(envelope.stamp(2000), 2000u);
}

}    // namespace
}    // namespace arrival_envelope_tests
