// Recorded, read and recorded again: the bytes are equal. And the seeds of the fuzz target with many mutations.
#include <support/files.hpp>
#include <support/random.hpp>
#include <support/recorded.hpp>

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace recording_tests {

namespace {

using support::Bytes;
using support::KeptItem;
using support::Random;

std::string random_text(Random& random) {
    return random.of<std::string>({"", "fc", "ground", "温度", "a b", "lost: x", "channel 3: y", "dropped: z"});
}

KeptItem random_item(Random& random) {
    KeptItem item;
    if (random.one_in(8)) {
        item.lost = 1 + random.below(1000u);
        item.names = random_text(random);
        return item;
    }
    item.time_ns = random.below(std::uint64_t{1} << 62);
    item.boottime_ns = random.one_in(4) ? 0 : random.below(std::uint64_t{1} << 62);
    item.link = random_text(random);
    item.direction = random.of({anogate::Direction::in, anogate::Direction::out, anogate::Direction::dropped});
    if (item.direction == anogate::Direction::dropped)
        item.cause = random.of<std::string>({"limited", "denied_in", "new_cause", ""});
    if (random.one_in(2)) item.channel = static_cast<std::uint8_t>(random.below(3u));
    if (item.channel) item.peer = random_text(random);
    Bytes data(random.one_in(50) ? ano::max_len : random.below(40u));
    for (auto& byte : data) byte = random.byte();
    item.frame = support::frame(random.byte(), random.byte(), random.byte(), data);
    return item;
}

// Adjacent losses are merged.
std::vector<KeptItem> as_read(const std::vector<KeptItem>& items) {
    std::vector<KeptItem> all;
    for (const KeptItem& item : items) {
        if (item.frame.empty() && !all.empty() && all.back().frame.empty()) {
            all.back().lost += item.lost;
            all.back().names += (all.back().names.empty() || item.names.empty() ? "" : ", ") + item.names;
        } else {
            all.push_back(item);
        }
    }
    return all;
}

class Recording : public testing::TestWithParam<anogate::RecordingFormat> {};

TEST_P(Recording, is_byte_identical_after_it_is_read_and_recorded_again) {
    for (std::uint64_t seed = 0; seed < support::trials(200); ++seed) {
        Random random{seed};
        std::vector<KeptItem> items;
        for (unsigned i = random.below(30u); i > 0; --i) items.push_back(random_item(random));
        const anogate::RecordingHead head{random_text(random), random.below(std::uint64_t{1} << 62),
                                          random.below(std::uint64_t{1} << 62)};
        const bool ended = !random.one_in(3);
        if (!ended) items.push_back(random_item(random)), items.back() = random_item(random);
        while (!ended && !items.empty() && items.back().frame.empty())
            items.pop_back();    // reported with the next frame, or at the end
        const std::string file = support::write_recording(GetParam(), items, head, ended);
        const auto read = support::read_recording(file, 1 + random.below(5000u));
        ASSERT_EQ(read.fault, "") << seed;
        ASSERT_EQ(read.items, as_read(items)) << seed;
        ASSERT_EQ(read.has_end, ended) << seed;
        ASSERT_EQ(support::write_recording(GetParam(), read.items, read.head, ended), file) << seed;
    }
}

TEST_P(Recording, any_bytes_are_read_without_harm) {
    std::vector<std::string> seeds;
    const std::string corpus = "tests/fuzz/corpus/" + std::string{text(GetParam())};
    for (const auto& entry : std::filesystem::directory_iterator{support::source_file(corpus)})
        seeds.push_back(support::file_text(entry.path()));
    ASSERT_FALSE(seeds.empty());
    for (std::uint64_t seed = 0; seed < support::trials(1000); ++seed) {
        Random random{seed};
        std::string file = seeds[random.below(seeds.size())];
        for (unsigned i = 1 + random.below(4u); i > 0 && !file.empty(); --i) {
            const std::size_t at = random.below(file.size());
            if (random.one_in(8)) file.resize(at);
            else file[at] = static_cast<char>(random.one_in(3) ? random.of<std::uint8_t>({0, 1, 0xFF, 0x7F}) : random.byte());
        }
        ASSERT_TRUE(support::holds_the_laws_of_recordings(file)) << seed;
    }
}

std::string name_of(const testing::TestParamInfo<anogate::RecordingFormat>& info) { return std::string{text(info.param)}; }

INSTANTIATE_TEST_SUITE_P(Of, Recording, testing::Values(anogate::RecordingFormat::pcapng, anogate::RecordingFormat::mcap),
                         name_of);

}    // namespace
}    // namespace recording_tests
