// Which recordings go.
#include <record/kept_recordings.hpp>

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

namespace {

using namespace anogate;
using namespace std::chrono_literals;

constexpr std::chrono::seconds now{1'000'000};
constexpr std::uint64_t plenty = 1'000'000'000'000;

KeptRecording recording(std::string name, std::uint64_t bytes, std::chrono::seconds age) {
    return {std::move(name), bytes, now - age};
}

std::string names_of_those_that_go(const std::vector<KeptRecording>& kept, const KeepLimits& limits,
                                   std::uint64_t free = plenty) {
    std::string names;
    for (const std::size_t i : recordings_to_delete(kept, limits, now, free)) names += kept.at(i).name + " ";
    return names;
}

const std::vector<KeptRecording> three{recording("b", 200, 20s), recording("c", 300, 10s), recording("a", 100, 30s)};

TEST(KeptRecordings, without_a_limit_none_goes) {
    EXPECT_EQ(names_of_those_that_go(three, {}, 0), "");
    EXPECT_EQ(names_of_those_that_go({}, {1, 1s, 1}, 0), "");
}

TEST(KeptRecordings, the_oldest_go_until_the_others_fit) {
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 600, .age = {}, .free = 0}), "");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 599, .age = {}, .free = 0}), "a ");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 499, .age = {}, .free = 0}), "a b ");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 1, .age = {}, .free = 0}), "a b c ");
}

TEST(KeptRecordings, what_is_older_than_the_age_goes) {
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = 30s, .free = 0}), "");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = 19s, .free = 0}), "a b ");
}

TEST(KeptRecordings, the_oldest_go_until_enough_of_the_disk_is_free) {
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 1000), "");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 900), "a ");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 899), "a b ");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 400), "a b c ");
}

TEST(KeptRecordings, the_files_of_one_recording_go_in_their_order_though_they_changed_in_the_same_second) {
    std::vector<KeptRecording> files;
    for (const char* name : {"f-2.pcapng", "f-10.pcapng", "f.pcapng", "f-9.pcapng", "f-11.pcapng"})
        files.push_back(recording(name, 1, 5s));
    EXPECT_EQ(names_of_those_that_go(files, {.bytes = 1, .age = {}, .free = 0}), "f.pcapng f-2.pcapng f-9.pcapng f-10.pcapng ");
}

TEST(KeptRecordings, none_goes_in_vain_when_others_filled_the_disk) {
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = {}, .free = 1000}, 399), "");
    EXPECT_EQ(names_of_those_that_go(three, {.bytes = 0, .age = 25s, .free = 1000}, 399), "a ") << "the age holds all the same";
}

TEST(KeptRecordings, the_one_that_is_written_never_goes_and_counts) {
    std::vector<KeptRecording> kept = three;
    kept[2].is_written = true;
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 599, .age = {}, .free = 0}), "b ");
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 1, .age = 1s, .free = plenty}, plenty - 500), "b c ");
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 0, .age = {}, .free = plenty}, plenty - 501), "")
        << "its bytes can't be had";
}

TEST(KeptRecordings, one_of_the_future_is_not_old) {
    const std::vector<KeptRecording> kept{recording("later", 100, -3600s), recording("old", 100, 7200s)};
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 0, .age = 60s, .free = 0}), "old ");
}

TEST(KeptRecordings, of_those_of_one_time_the_first_by_name_goes_first) {
    const std::vector<KeptRecording> kept{recording("f-2", 100, 5s), recording("f-1", 100, 5s)};
    EXPECT_EQ(names_of_those_that_go(kept, {.bytes = 100, .age = {}, .free = 0}), "f-1 ");
}

}    // namespace
