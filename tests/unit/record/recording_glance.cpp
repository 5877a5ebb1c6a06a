#include <record/mcap/mcap_format.hpp>
#include <record/mcap/mcap_writer.hpp>
#include <record/recording_glance.hpp>
#include <support/recorded.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::recording_glance_tests {
namespace {

using support::Bytes;

const RecordingHead head{"anogated 0.1.0", 1763898044123456789, 1234567890};

std::vector<support::KeptItem> items_of(std::size_t frames, std::size_t links) {
    std::vector<support::KeptItem> items;
    for (std::size_t i = 0; i < frames; ++i) {
        support::KeptItem item;
        item.time_ns = head.time_ns + i;
        item.link = "link" + std::to_string(i % links);
        item.frame = support::frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
        items.push_back(item);
    }
    return items;
}

std::string recording(std::size_t frames, bool end, std::size_t links = 2) {
    return support::write_pcapng(items_of(frames, links), head, end);
}

RecordingGlance glance(const std::string& file, std::size_t size = glance_size) {
    return glance_at(RecordingFormat::pcapng, std::string_view{file}.substr(0, size),
                     std::string_view{file}.substr(file.size() > size ? file.size() - size : 0));
}

TEST(RecordingGlance, reports_the_program_the_start_time_and_the_number_of_frames) {
    const RecordingGlance seen = glance(recording(5000, true, 64));
    EXPECT_EQ(seen.head.program, head.program);
    EXPECT_EQ(seen.head.time_ns, head.time_ns);
    EXPECT_TRUE(seen.is_ended);
    EXPECT_EQ(seen.frames, 5000u);
}

TEST(RecordingGlance, reports_the_duration_from_the_first_frame_to_the_last) {
    const auto seconds = [](std::uint64_t first, std::uint64_t last, std::uint64_t first_boot = 0, std::uint64_t last_boot = 0,
                            bool end = true) {
        auto items = items_of(3000, 3);
        items.front().time_ns = first;
        items.back().time_ns = last;
        for (auto& item : items) item.time_ns = std::min(item.time_ns, std::max(first, last));
        items.front().boottime_ns = first_boot;
        items.back().boottime_ns = last_boot;
        return glance(support::write_pcapng(items, head, end)).seconds;
    };
    constexpr std::uint64_t second = 1'000'000'000;
    const std::uint64_t begin = head.time_ns - 60 * second;    // stored before it was saved
    EXPECT_EQ(seconds(begin, begin + 61 * second), 61.0);
    EXPECT_EQ(seconds(begin, begin + 3600 * second, 5 * second, 7 * second), 2.0) << "the clock was set";
    EXPECT_EQ(seconds(begin, begin + 61 * second, 0, 0, false), std::nullopt);
    EXPECT_EQ(seconds(begin, begin + 61 * second, 5 * second, 7 * second, false), std::nullopt) << "it is not ended";
    EXPECT_EQ(glance(recording(1, true)).seconds, 0.0);
    EXPECT_EQ(glance(recording(0, true)).seconds, std::nullopt);
}

TEST(RecordingGlance, of_a_file_without_frames_has_an_end) {
    const RecordingGlance seen = glance(recording(0, true));
    EXPECT_TRUE(seen.is_ended);
    EXPECT_EQ(seen.frames, 0u);
}

TEST(RecordingGlance, of_a_file_that_was_not_ended_reports_this) {
    const RecordingGlance seen = glance(recording(5000, false));
    EXPECT_EQ(seen.head.program, head.program);
    EXPECT_FALSE(seen.is_ended);
    EXPECT_FALSE(seen.frames.has_value());
}

TEST(RecordingGlance, of_a_file_that_is_not_a_recording_has_no_program) {
    for (const std::string& text : {std::string{}, std::string{"hello"}, std::string(100'000, 'x'), std::string(40, '\0')})
        EXPECT_EQ(glance(text).head.program, "");
}

TEST(RecordingGlance, of_a_file_cut_anywhere_neither_fails_nor_reports_it_as_complete) {
    const std::string whole = recording(20, true);
    const std::string frames_alone = recording(20, false);
    for (std::size_t size = 0; size <= whole.size(); ++size) {
        const std::string cut = whole.substr(0, size);
        const RecordingGlance seen = glance(cut);
        if (size < frames_alone.size()) {
            EXPECT_FALSE(seen.is_ended) << size;
        }
    }
}

RecordingGlance glance_at_mcap(const std::string& file) {
    const std::string_view bytes = file;
    return glance_at(RecordingFormat::mcap, bytes.substr(0, glance_size),
                     bytes.substr(file.size() > glance_size ? file.size() - glance_size : 0));
}

TEST(RecordingGlance, reports_the_program_of_an_mcap_file_and_whether_it_was_ended) {
    const auto items = items_of(300, 2);
    const std::string begun = support::write_recording(RecordingFormat::mcap, items, head, false);
    const std::string ended = support::write_recording(RecordingFormat::mcap, items, head);
    for (const std::string& file : {begun, ended}) {
        EXPECT_EQ(glance_at_mcap(file).head.program, head.program);
        EXPECT_EQ(glance_at_mcap(file).head.time_ns, head.time_ns);
        EXPECT_EQ(glance_at_mcap(file).head.boottime_ns, head.boottime_ns);
        EXPECT_EQ(glance(file).head.program, "") << "it is no pcapng";
    }
    EXPECT_FALSE(glance_at_mcap(begun).is_ended);
    std::string with_frame = begun;
    const std::size_t record = mcap::begin_record(with_frame, mcap::Opcode::message);
    with_frame.append(20, 'x').append(mcap::magic);
    EXPECT_FALSE(glance_at_mcap(with_frame).is_ended) << "a frame may have these bytes";
    with_frame.resize(with_frame.size() - mcap::magic.size());
    mcap::end_record(with_frame, record);
    EXPECT_FALSE(glance_at_mcap(with_frame + std::string{mcap::magic}).is_ended) << "no Footer is in front";
    EXPECT_FALSE(glance_at_mcap(ended.substr(0, ended.size() - 1) + "x").is_ended);
    EXPECT_TRUE(glance_at_mcap(ended).is_ended);
    for (std::size_t size = 0; size < ended.size(); ++size) EXPECT_FALSE(glance_at_mcap(ended.substr(0, size)).is_ended) << size;
    std::string empty;
    const McapWriter writer{head, empty};
    for (std::size_t size = 0; size < empty.size(); ++size)
        EXPECT_EQ(glance_at_mcap(empty.substr(0, size)).head.program, "") << size;
}

// As made by a program that filters recordings: it keeps their Metadata, but writes its own before it.
TEST(RecordingGlance, does_not_recognize_an_mcap_file_saved_by_another_program) {
    std::string file{mcap::magic};
    for (const std::string_view program : {"filter", "anogated 0.1.0"})
        mcap::append_metadata(file, mcap::head_name, {{"program", program}});
    EXPECT_EQ(glance_at_mcap(file).head.program, "") << "no Header is in front";
    std::string ours;
    const McapWriter writer{head, ours};
    const std::string_view own = ours;
    std::string_view rest = own.substr(mcap::magic.size());
    ASSERT_TRUE(mcap::next_record(rest));
    std::string saved{own.substr(0, own.size() - rest.size())};
    mcap::append_metadata(saved, "filter", {{"program", "filter"}});
    saved += rest;
    EXPECT_EQ(glance_at_mcap(saved).head.program, "");
}

}    // namespace
}    // namespace anogate::recording_glance_tests
