#include <recording/disk_pace.hpp>

#include <gtest/gtest.h>

#include <vector>

namespace anogate::disk_pace_tests {
namespace {

using namespace std::chrono_literals;
using State = DiskPace::State;

/// A disk that gets one write after the other, and is checked every 150 ms.
class DiskPaces : public testing::Test {
protected:
    static constexpr ano::Duration beat = 150ms;

    State look(ano::Duration silence, bool is_behind = false, bool fails = false, bool loses = false) {
        now += beat;
        const State state = pace.look(now, {silence, is_behind, loses, fails});
        if (told.empty() || told.back() != state) told.push_back(state);
        return state;
    }
    /// A write of this duration.
    void write(ano::Duration time) {
        for (ano::Duration silence = beat; silence < time; silence += beat) look(silence);
    }
    void pass(ano::Duration time) {
        for (ano::Duration left = time; left > 0ms; left -= beat) look(0ms);
    }

    DiskPace pace;
    ano::TimePoint now{1000s};
    std::vector<State> told;    // without consecutive equal ones
};

TEST_F(DiskPaces, a_disk_that_hangs_counts_as_silent_until_it_responds) {
    EXPECT_EQ(look(749ms), State::well);
    EXPECT_EQ(look(750ms), State::silent);
    EXPECT_EQ(look(60s, true), State::silent);
    EXPECT_EQ(look(0ms, true), State::well) << "what waited is still on its way";
    EXPECT_EQ(look(0ms, true), State::slow);
}

TEST_F(DiskPaces, a_disk_that_lags_counts_as_slow_for_ten_seconds_after_the_last_sign) {
    EXPECT_EQ(look(0ms, true), State::slow);
    pass(8s);
    EXPECT_EQ(look(0ms, true), State::slow);
    const ano::TimePoint last = now;
    while (look(0ms) == State::slow) {}
    EXPECT_GE(now - last, 10s);
    EXPECT_LT(now - last, 10s + 2 * beat);
}

TEST_F(DiskPaces, one_that_needs_two_seconds_for_each_write_is_reported_once) {
    for (int i = 0; i < 100; ++i) {
        write(2s);
        pass(300ms);
    }
    EXPECT_EQ(told, (std::vector{State::well, State::silent, State::well, State::slow}));
    pass(11s);
    EXPECT_EQ(told.back(), State::well);
    write(1s);
    EXPECT_EQ(told.back(), State::silent) << "that is another trouble";
}

TEST_F(DiskPaces, one_that_needs_sixteen_seconds_for_each_write_is_reported_once_too) {
    for (int i = 0; i < 20; ++i) {
        write(16s);
        pass(150ms);
    }
    EXPECT_EQ(told, (std::vector{State::well, State::silent, State::well, State::slow}));
    write(31s);
    EXPECT_EQ(told.back(), State::slow);
    write(63s);
    EXPECT_EQ(told.back(), State::silent) << "twice as long as ever";
    pass(150ms);
    EXPECT_EQ(told.back(), State::slow) << "as it was before";
}

TEST_F(DiskPaces, one_that_hangs_is_silent_at_once_even_if_it_lagged_by_chance_just_before) {
    for (int i = 0; i < 2; ++i) {
        EXPECT_EQ(look(400ms, true), State::slow) << "what it took last is 600 ms older";
        EXPECT_EQ(look(749ms, true), State::slow);
        EXPECT_EQ(look(750ms, true), State::silent);
        EXPECT_EQ(look(5s, true), State::silent);
        EXPECT_EQ(look(0ms, true), State::well) << "what waited is still on its way";
        pass(11s);
        look(0ms, true, false, true);
        pass(11s);
    }
}

TEST_F(DiskPaces, one_that_lost_frames_and_hangs_is_silent_after_half_a_minute) {
    write(16s);
    pass(11s);
    ASSERT_EQ(told.back(), State::well) << "a trouble that is over does not count";
    look(0ms, true, false, true);
    look(0ms, true);
    EXPECT_EQ(look(29'999ms), State::slow);
    EXPECT_EQ(look(30s), State::silent);
    EXPECT_EQ(look(0ms, true, true), State::well) << "an error says it all";
}

TEST_F(DiskPaces, an_error_replaces_the_report_of_a_slow_disk) {
    EXPECT_EQ(look(0ms, true, true), State::well);
    look(0ms, true);
    EXPECT_EQ(look(0ms, true, true), State::well);
    EXPECT_EQ(look(750ms, false, true), State::silent) << "an error that is told, and a disk that hangs since";
    look(0ms);
    EXPECT_EQ(look(750ms), State::silent) << "a trouble of its own";
}

}    // namespace
}    // namespace anogate::disk_pace_tests
