// Which recordings are removed.
#include <record/kept_recordings.hpp>

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kept_recordings_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

constexpr std::chrono::seconds now{1'763'898'044};
constexpr std::uint64_t plenty = 1'000'000'000'000;

KeptRecording recording(std::string name, std::uint64_t bytes, std::chrono::seconds age) {
    return {std::move(name), bytes, now - age, false, age};
}

std::string names_of_those_that_go(const std::vector<KeptRecording>& kept, const KeepLimits& limits,
                                   std::uint64_t free = plenty) {
    std::string names;
    for (const std::size_t i : recordings_to_delete(kept, limits, free).going) names += kept.at(i).name + " ";
    return names;
}

const std::vector<KeptRecording> three{recording("b", 200, 20s), recording("c", 300, 10s), recording("a", 100, 30s)};

TEST(KeptRecordings, without_a_limit_none_is_deleted) {
    EXPECT_EQ(names_of_those_that_go(three, {}, 0), "");
    EXPECT_EQ(names_of_those_that_go({}, {1, 1s, 1}, 0), "");
}

TEST(KeptRecordings, the_oldest_are_deleted_until_the_others_fit) {
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 600, .age = {}, .free = 0}), "");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 599, .age = {}, .free = 0}), "a ");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 499, .age = {}, .free = 0}), "a b ");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 1, .age = {}, .free = 0}), "a b ") << "the newest stays";
}

TEST(KeptRecordings, those_older_than_the_age_limit_are_deleted) {
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = 30s, .free = 0}), "");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = 19s, .free = 0}), "a b ");
}

TEST(KeptRecordings, the_oldest_are_deleted_until_enough_of_the_disk_is_free) {
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 1000), "");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 900), "a ");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 899), "a b ");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 700), "a b ");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 699), "") << "the newest stays";
}

TEST(KeptRecordings, the_one_just_saved_and_the_newest_are_kept) {
    EXPECT_EQ(recordings_to_delete(three, {.bytes = 299, .age = {}, .free = 0}, plenty).stays, std::optional<std::size_t>{1});
    EXPECT_EQ(recordings_to_delete(three, {.bytes = 300, .age = {}, .free = 0}, plenty).stays, std::nullopt);
    EXPECT_EQ(names_of_those_that_go({recording("a", 100, 30s)}, {.bytes = 1, .age = {}, .free = 0}), "");
    std::vector<KeptRecording> kept = three;
    kept[0].is_just_saved = true;
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 1, .age = {}, .free = 0}), "a ");
    EXPECT_EQ(recordings_to_delete(kept, {.bytes = 500, .age = {}, .free = 0}, plenty).stays, std::nullopt) << "there is room";
    EXPECT_EQ(recordings_to_delete(kept, {.bytes = 499, .age = {}, .free = 0}, plenty).stays, std::optional<std::size_t>{1});
    kept[0].is_just_saved = false;
    kept[2].is_just_saved = true;
    EXPECT_EQ(recordings_to_delete(kept, {.bytes = 400, .age = {}, .free = 0}, plenty).stays, std::nullopt) << "a newer one goes";
    EXPECT_EQ(recordings_to_delete(kept, {.bytes = 399, .age = {}, .free = 0}, plenty).stays, std::optional<std::size_t>{1});
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 0, .age = {}, .free = 1000}, 900), "b ");
    kept[2].is_just_saved = false;
    kept[0].is_just_saved = true;
    kept[1].is_written = true;
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 1, .age = {}, .free = 0}), "a ");
    EXPECT_EQ(recordings_to_delete(kept, {.bytes = 1, .age = {}, .free = 0}, plenty).stays, std::optional<std::size_t>{0});
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 0, .age = {}, .free = 1000}, 899), "") << "its bytes can't be had";
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 0, .age = 19s, .free = 0}), "a b ") << "the age holds all the same";
}

TEST(KeptRecordings, the_newest_finished_one_is_deleted_only_on_a_full_disk_or_for_its_age) {
    std::vector<KeptRecording> kept = three;
    kept.push_back({"now", 50, now, true, {}});
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 1, .age = {}, .free = 0}), "a b ");
    EXPECT_EQ(recordings_to_delete(kept, {.bytes = 1, .age = {}, .free = 0}, plenty).stays, std::nullopt)
        << "it goes with the next";
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 1, .age = {}, .free = 1000}, 700), "a b ");
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 1, .age = {}, .free = 1000}, 699), "a b c ");
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 0, .age = {}, .free = 1000}, 400), "a b c ");
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 0, .age = {}, .free = 1000}, 399), "") << "they are not enough";
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 0, .age = 9s, .free = 0}), "a b c ");
}

TEST(KeptRecordings, the_files_of_one_recording_are_deleted_in_order_even_if_changed_in_the_same_second) {
    std::vector<KeptRecording> files;
    for (const char* name : {"f-2.pcapng", "f-10.pcapng", "f.pcapng", "f-9.pcapng", "f-11.pcapng"})
        files.push_back(recording(name, 1, 5s));
    EXPECT_EQ(names_of_those_that_go(files, {.bytes = 1, .age = {}, .free = 0}), "f.pcapng f-2.pcapng f-9.pcapng f-10.pcapng ");
}

TEST(KeptRecordings, none_is_deleted_in_vain_when_other_files_fill_the_disk) {
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 399), "");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = 25s, .free = 1000}, 399), "a ") << "the age holds all the same";
}

TEST(KeptRecordings, the_one_being_written_is_never_deleted_but_counts) {
    std::vector<KeptRecording> kept = three;
    kept[2].is_written = true;
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 599, .age = {}, .free = 0}), "b ");
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 1, .age = 1s, .free = plenty}, plenty - 500), "b c ");
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 0, .age = {}, .free = plenty}, plenty - 501), "")
        << "its bytes can't be had";
}

TEST(KeptRecordings, of_the_same_age_are_deleted_in_order_of_change) {
    std::vector<KeptRecording> kept{recording("a", 100, 5s), recording("b", 100, 5s)};
    kept[1].changed -= 1s;
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 100, .age = {}, .free = 0}), "b ");
}

TEST(KeptRecordings, of_the_same_time_are_deleted_in_order_of_name) {
    const std::vector<KeptRecording> kept{recording("f-2", 100, 5s), recording("f-1", 100, 5s)};
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 100, .age = {}, .free = 0}), "f-1 ");
}

/// A folder that is checked repeatedly, while both clocks advance.
class AgesOfRecordings : public testing::Test {
protected:
    /// A recording that is being written.
    void write(const std::string& name) { write(name, real); }
    void write(const std::string& name, std::chrono::seconds changed) {
        for (KeptRecording& one : all)
            if (one.name == name) return void(one.changed = changed);
        all.push_back({name, 100, changed, false, {}});
    }
    std::chrono::seconds age_of(const std::string& name) {
        ages.look(all, real, steady);
        for (const KeptRecording& one : all)
            if (one.name == name) return one.age;
        return -1s;
    }
    void pass(std::chrono::seconds time) {
        real += time;
        steady += time;
    }

    RecordingAges ages;
    std::vector<KeptRecording> all;
    std::chrono::seconds real = now, steady{500};
};

TEST_F(AgesOfRecordings, are_first_computed_from_file_times_and_then_grow_with_time) {
    write("oldest", now - 20h);
    write("old", now - 9h);
    write("new", now - 5h);
    write("later", now + 500h);
    EXPECT_EQ(age_of("oldest"), 4h) << "older than the newest, without the longest pause";
    EXPECT_EQ(age_of("old"), 0s) << "without the only pause";
    EXPECT_EQ(age_of("new"), 0s);
    EXPECT_EQ(age_of("later"), 0s) << "one of the future is not old, and makes no other one old";
    pass(10s);
    EXPECT_EQ(age_of("oldest"), 4h + 10s);
    EXPECT_EQ(age_of("later"), 10s);
}

TEST_F(AgesOfRecordings, do_not_depend_on_a_clock_that_is_far_ahead_at_the_start) {
    for (int day = 0; day < 5; ++day) write("flight-" + std::to_string(day), now - day * 24h);
    real += 80 * 365 * 24h;    // 2106
    all.push_back({"now", 100, real, true, {}});
    EXPECT_EQ(age_of("flight-4"), 72h);
    EXPECT_EQ(age_of("flight-0"), 0s);
    RecordingAges next_start;    // and the clock is back: a file of 2106 exists now
    all.back().is_written = false;
    next_start.look(all, real + 1h, 0s);
    EXPECT_EQ(all[4].age, 96h);
    EXPECT_EQ(all[0].age, 0s);
}

TEST_F(AgesOfRecordings, do_not_depend_on_a_clock_that_is_not_set_at_the_start) {
    for (int day = 0; day < 5; ++day) write("flight-" + std::to_string(day), now - day * 24h);
    real = 100s;    // 1970
    EXPECT_EQ(age_of("flight-4"), 72h);
    pass(10s);
    real = now;
    EXPECT_EQ(age_of("flight-4"), 72h + 10s);
    EXPECT_EQ(age_of("flight-0"), 10s);
}

TEST_F(AgesOfRecordings, are_zero_for_files_from_the_far_future_which_are_deleted_before_others_of_age_zero) {
    for (const auto clock : {now, now - 5 * 365 * 24h, 100s}) {    // set; the time of the system's build; 1970
        all.clear();
        write("flight", now - 1h);
        write("before", now - 9 * 24h);
        write("far", 4'294'967'295s);    // 2106
        write("further", 4'294'967'296s);
        RecordingAges first;
        first.look(all, clock, steady);
        for (const KeptRecording& one : all) EXPECT_EQ(one.age, 0s) << one.name;
        EXPECT_EQ(names_of_those_that_go(all, {.bytes = 300, .age = {}, .free = 0}), "far ");
        EXPECT_EQ(names_of_those_that_go(all, {.bytes = 1, .age = {}, .free = 0}), "far further before ");
    }
}

TEST_F(AgesOfRecordings, of_others_ignore_files_that_are_far_ahead_of_a_clock_that_is_not_set) {
    write("flight", now);
    write("before", now - 100h);
    write("oldest", now - 101h);
    write("far", 4'294'967'295s);
    real = 100s;
    EXPECT_EQ(age_of("oldest"), 1h) << "the longest pause is that of 100 h";
}

TEST_F(AgesOfRecordings, remain_correct_when_the_clock_returns_from_far_ahead) {
    write("before", now);
    write("far", now + 15 * 365 * 24h);
    write("further", now + 15 * 365 * 24h + 1s);
    EXPECT_EQ(age_of("far"), 0s);
    EXPECT_FALSE(all[1].is_far_ahead) << "15 years";
    EXPECT_TRUE(all[2].is_far_ahead);
    pass(10s);
    real += 15 * 365 * 24h;
    write("now");
    EXPECT_EQ(age_of("now"), 0s);
    real -= 15 * 365 * 24h;
    pass(10s);
    EXPECT_EQ(age_of("now"), 10s);
    EXPECT_FALSE(all[3].is_far_ahead) << "it was not when it was seen";
    EXPECT_TRUE(all[2].is_far_ahead);
}

TEST_F(AgesOfRecordings, grow_with_time_if_no_pause_is_left_out) {
    write("flight", now - 500h);
    EXPECT_EQ(age_of("flight"), 0s);
    pass(30h);
    EXPECT_EQ(age_of("flight"), 30h);
}

TEST_F(AgesOfRecordings, restart_with_each_change) {
    write("flight", now - 5h);
    write("others", now);
    write("oldest", now - 11h);
    ASSERT_EQ(age_of("oldest"), 5h);
    pass(8s);
    write("oldest");
    pass(2s);
    EXPECT_EQ(age_of("oldest"), 2s);
    write("later", real + 5h);
    EXPECT_EQ(age_of("later"), 0s) << "one of the future is not old";
    pass(10s);
    EXPECT_EQ(age_of("oldest"), 12s);
}

TEST_F(AgesOfRecordings, are_not_computed_from_times_of_a_clock_that_was_never_set) {
    write("flight", 300s);
    EXPECT_EQ(age_of("flight"), 0s) << "1970";
    write("oldest", 1'577'836'800s);
    write("before", 1'577'836'799s);
    write("second", now - 1h);
    write("third", now);
    RecordingAges others;
    others.look(all, now, steady);
    EXPECT_EQ(all[1].age, 1h);
    EXPECT_EQ(all[2].age, 0s);
}

TEST_F(AgesOfRecordings, do_not_change_when_the_clock_is_set) {
    real = 100s;    // 1970
    write("before", now - 1h);
    EXPECT_EQ(age_of("before"), 0s);
    pass(10s);
    write("flight");
    EXPECT_EQ(age_of("flight"), 0s);
    pass(10s);
    write("landing");
    real = now;
    pass(10s);
    EXPECT_EQ(age_of("flight"), 20s);
    EXPECT_EQ(age_of("landing"), 0s) << "it has no time that tells";
    pass(10s);
    write("next");
    real += std::chrono::hours{24 * 365 * 80};    // 2106
    pass(5s);
    EXPECT_EQ(age_of("next"), 15s) << "since the look before";
    real = now - 1h;
    pass(5s);
    EXPECT_EQ(age_of("flight"), 40s);
    EXPECT_EQ(age_of("before"), 50s);
}

TEST_F(AgesOfRecordings, of_a_recording_that_was_missing_meanwhile_restart) {
    write("flight", now - 5h);
    ASSERT_EQ(age_of("flight"), 0s);
    pass(10s);
    ASSERT_EQ(age_of("flight"), 10s);
    const std::vector<KeptRecording> there = std::exchange(all, {});
    pass(10s);
    EXPECT_EQ(age_of("flight"), -1s);
    all = there;
    pass(10s);
    EXPECT_EQ(age_of("flight"), 10s) << "since the look before";
}

}    // namespace
}    // namespace kept_recordings_tests
