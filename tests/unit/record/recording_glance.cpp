#include <record/recording_glance.hpp>
#include <support/recorded.hpp>

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <utility>

namespace anogate {
namespace {

using support::Bytes;

const RecordingHead head{"anogated 0.1.0", 1763898044123456789, 1234567890};

std::string recording(std::size_t frames, bool end, std::size_t links = 2) {
    std::vector<support::KeptItem> items;
    for (std::size_t i = 0; i < frames; ++i) {
        support::KeptItem item;
        item.time_ns = head.time_ns + i;
        item.link = "link" + std::to_string(i % links);
        item.frame = support::frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
        items.push_back(item);
    }
    return support::write_pcapng(items, head, end);
}

RecordingGlance glance(const std::string& file, std::size_t size = glance_size) {
    return glance_at(RecordingFormat::pcapng, std::string_view{file}.substr(0, size),
                     std::string_view{file}.substr(file.size() > size ? file.size() - size : 0));
}

TEST(RecordingGlance, tells_who_wrote_it_when_it_began_and_how_many_frames_it_has) {
    const RecordingGlance seen = glance(recording(5000, true, 64));
    EXPECT_EQ(seen.head.program, head.program);
    EXPECT_EQ(seen.head.time_ns, head.time_ns);
    EXPECT_TRUE(seen.is_ended);
    EXPECT_EQ(seen.frames, 5000u);
}

TEST(RecordingGlance, of_one_without_frames_has_an_end) {
    const RecordingGlance seen = glance(recording(0, true));
    EXPECT_TRUE(seen.is_ended);
    EXPECT_EQ(seen.frames, 0u);
}

TEST(RecordingGlance, of_one_that_was_not_ended_says_so) {
    const RecordingGlance seen = glance(recording(5000, false));
    EXPECT_EQ(seen.head.program, head.program);
    EXPECT_FALSE(seen.is_ended);
    EXPECT_FALSE(seen.frames.has_value());
}

TEST(RecordingGlance, of_what_is_no_recording_has_no_program) {
    for (const std::string& text : {std::string{}, std::string{"hello"}, std::string(100'000, 'x'), std::string(40, '\0')})
        EXPECT_EQ(glance(text).head.program, "");
}

TEST(RecordingGlance, of_one_cut_anywhere_neither_fails_nor_takes_it_for_whole) {
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

void put(std::string& out, std::uint64_t number, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) out += static_cast<char>(number >> 8 * i & 0xFF);
}
void put_text(std::string& out, std::string_view text) {
    put(out, text.size(), 4);
    out += text;
}
void put_record(std::string& out, std::uint8_t opcode, const std::string& body) {
    out += static_cast<char>(opcode);
    put(out, body.size(), 8);
    out += body;
}

std::string mcap_begin(std::string_view program) {
    std::string header, pairs, metadata, file{"\x89MCAP0\r\n", 8};
    put_text(header, "ros2");
    put_text(header, "library");
    for (const auto& [key, value] : {std::pair<std::string_view, std::string_view>{"program", program},
                                     {"time_ns", "1763898044123456789"},
                                     {"boottime_ns", "5"}}) {
        put_text(pairs, key);
        put_text(pairs, value);
    }
    put_text(metadata, "anogate.recording");
    put_text(metadata, pairs);
    put_record(file, 1, header);
    put_record(file, 12, metadata);
    return file;
}

TEST(RecordingGlance, knows_whose_an_mcap_file_is_and_whether_it_was_ended) {
    const std::string begun = mcap_begin("anogated 0.1.0") + std::string(1000, 'x');
    const auto seen = [](const std::string& file) { return glance_at(RecordingFormat::mcap, file, file); };
    EXPECT_EQ(seen(begun).head.program, "anogated 0.1.0");
    EXPECT_EQ(seen(begun).head.time_ns, 1763898044123456789u);
    EXPECT_EQ(seen(begun).head.boottime_ns, 5u);
    EXPECT_FALSE(seen(begun).is_ended);
    EXPECT_TRUE(seen(begun + std::string{"\x89MCAP0\r\n", 8}).is_ended);
    EXPECT_EQ(glance_at(RecordingFormat::pcapng, begun, begun).head.program, "");
    for (std::size_t size = 0; size < mcap_begin("x").size(); ++size)
        EXPECT_EQ(seen(begun.substr(0, size)).head.program, "") << size;
}

}    // namespace
}    // namespace anogate
