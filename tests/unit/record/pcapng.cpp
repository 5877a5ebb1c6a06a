#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include <record/pcapng_reader.hpp>
#include <support/bytes.hpp>
#include <support/recorded.hpp>
#include <support/recorded_items.hpp>

namespace pcapng_tests {
namespace {

using namespace anogate;
using support::Bytes;
using support::came;
using support::KeptItem;
using support::lost;
using support::read_pcapng;
using support::write_pcapng;

const RecordingHead& head = support::anoctl_head;
const Bytes& euler = support::euler_frame;
const Bytes& wind = support::wind_frame;

std::vector<KeptItem> a_bit_of_everything() {
    KeptItem first = came(euler);
    first.description = "serial /dev/ttyUSB0";
    KeptItem sent = came(wind, "ground");
    sent.direction = Direction::out;
    sent.channel = 3;
    sent.peer = "192.168.1.20:6000";
    KeptItem dropped = sent;
    dropped.direction = Direction::dropped;
    dropped.cause = "limited";
    KeptItem other = sent;
    other.peer = "192.168.1.21:6000";
    other.boottime_ns = 0;
    KeptItem again = first;
    return {first, sent, lost(7, "euler 4, power 3"), dropped, other, again, lost(2, "euler 2")};
}

template <class T>
void put(std::string& bytes, std::size_t at, T value) {
    for (std::size_t i = 0; i < sizeof value; ++i) bytes[at + i] = static_cast<char>(value >> 8 * i & 0xFF);
}

TEST(Pcapng, reads_back_everything_that_was_written) {
    const auto items = a_bit_of_everything();
    const auto read = read_pcapng(write_pcapng(items, head), 5);
    EXPECT_EQ(read.items, items);
    EXPECT_EQ(read.head.program, head.program);
    EXPECT_EQ(read.head.time_ns, head.time_ns);
    EXPECT_EQ(read.head.boottime_ns, head.boottime_ns);
    EXPECT_TRUE(read.has_end);
    EXPECT_EQ(read.fault + std::to_string(read.unfinished), "0");
}

TEST(Pcapng, reports_that_a_recording_was_not_ended) {
    const auto read = read_pcapng(write_pcapng({came(euler)}, head, false));
    EXPECT_FALSE(read.has_end);
    EXPECT_EQ(read.items.size(), 1u);
    const auto none = read_pcapng(write_pcapng({}, head));
    EXPECT_TRUE(none.has_end);
    EXPECT_TRUE(none.items.empty());
}

TEST(Pcapng, returns_all_complete_items_before_a_cut_at_any_byte) {
    const auto items = a_bit_of_everything();
    const std::string file = write_pcapng(items, head);
    std::size_t before = 0;
    for (std::size_t size = 0; size <= file.size(); ++size) {
        const auto read = read_pcapng(std::string_view{file}.substr(0, size));
        ASSERT_EQ(read.fault, "") << size;
        ASSERT_EQ(read.position + read.unfinished, size);
        ASSERT_GE(read.items.size(), before) << size;
        before = read.items.size();
        ASSERT_TRUE(std::equal(read.items.begin(), read.items.end(), items.begin())) << size;
    }
    EXPECT_EQ(before, items.size());
}

TEST(Pcapng, reads_files_of_the_other_byte_order) {
    // A section, an interface in microseconds, and a packet, all big endian.
    std::string file;
    const auto big = [&](std::uint64_t number, int bytes) {
        while (bytes-- > 0) file += static_cast<char>(number >> 8 * bytes & 0xFF);
    };
    big(0x0A0D0D0A, 4), big(28, 4), big(0x1A2B3C4D, 4), big(1, 2), big(0, 2), big(~std::uint64_t{0}, 8), big(28, 4);
    big(1, 4), big(28, 4), big(147, 2), big(0, 2), big(0, 4), big(2, 2), big(2, 2), file += "fc", big(0, 2), big(28, 4);
    const std::uint64_t time_us = 1'763'898'044'123'456;
    big(6, 4), big(48, 4), big(0, 4), big(time_us >> 32, 4), big(time_us & 0xFFFFFFFF, 4), big(euler.size(), 4),
        big(euler.size(), 4);
    file.append(euler.begin(), euler.end());
    big(0, 1), big(48, 4);
    const auto read = read_pcapng(file, 1);
    ASSERT_EQ(read.fault, "");
    ASSERT_EQ(read.items.size(), 1u);
    EXPECT_EQ(read.items[0].time_ns, time_us * 1000);
    EXPECT_EQ(read.items[0].link, "fc");
    EXPECT_EQ(read.items[0].frame, euler);
}

TEST(Pcapng, reads_all_of_several_joined_files) {
    const auto first = a_bit_of_everything();
    const auto read = read_pcapng(write_pcapng(first, head) + write_pcapng({came(wind, "radio")}, head));
    ASSERT_EQ(read.items.size(), first.size() + 1);
    EXPECT_EQ(read.items.back().link, "radio");
    EXPECT_FALSE(read_pcapng(write_pcapng(first, head) + write_pcapng({came(wind)}, head, false)).has_end);
}

TEST(Pcapng, counts_packets_that_are_not_a_complete_frame_and_continues) {
    Bytes broken = euler;
    broken.back() ^= 1;
    const auto read = read_pcapng(write_pcapng({came(broken), came(wind)}, head));
    EXPECT_EQ(read.foreign, 1u);
    ASSERT_EQ(read.items.size(), 1u);
    EXPECT_EQ(read.items[0].frame, wind);
}

TEST(Pcapng, a_packet_is_one_frame_and_nothing_else) {
    std::string file = write_pcapng({came(euler)}, head, false);
    const std::size_t packet = file.size() - 72;
    for (const std::size_t at : {20u, 24u}) put(file, packet + at, std::uint32_t{16});    // with the byte of padding
    const auto read = read_pcapng(file);
    EXPECT_EQ(read.foreign, 1u);
    EXPECT_TRUE(read.items.empty());
}

TEST(Pcapng, names_the_peer_of_a_channel_once) {
    const std::string file = write_pcapng(a_bit_of_everything(), head);
    const auto first = file.find("channel 3: 192.168.1.20:6000");
    ASSERT_NE(first, std::string::npos);
    EXPECT_EQ(file.find("channel 3: 192.168.1.20:6000", first + 1), std::string::npos);
}

TEST(Pcapng, skips_unknown_blocks) {
    const std::string one = write_pcapng({came(euler)}, head);
    std::string other(16, '\0');
    put(other, 0, std::uint32_t{0x0BAD});
    put(other, 4, std::uint32_t{16});
    put(other, 12, std::uint32_t{16});
    EXPECT_EQ(read_pcapng(one + other + one).items.size(), 2u);
}

TEST(Pcapng, stops_at_an_invalid_block_and_reports_why) {
    const std::string good = write_pcapng({came(euler)}, head);
    const auto fault_behind = [&](std::uint32_t type, std::uint32_t size, std::uint32_t end) {
        std::string block(16, '\0');
        put(block, 0, type);
        put(block, 4, size);
        put(block, 12, end);
        const auto read = read_pcapng(good + block + good);
        EXPECT_EQ(read.items.size(), 1u);
        EXPECT_EQ(read.position, good.size());
        return read.fault;
    };
    EXPECT_EQ(fault_behind(0, 0, 0), "a block has an invalid length");    // zeros: power was lost
    EXPECT_EQ(fault_behind(6, 13, 0), "a block has an invalid length");
    EXPECT_EQ(fault_behind(6, PcapngReader::max_block + 4, 0), "a block is longer than 16 MiB");
    EXPECT_EQ(fault_behind(0x0BAD, 16, 20), "the two lengths of a block differ");
    EXPECT_EQ(read_pcapng("not a capture at all").fault, "it is neither pcapng nor MCAP");
}

TEST(Pcapng, a_packet_must_stay_within_its_block) {
    const std::string good = write_pcapng({came(euler)}, head, false);
    const std::size_t packet = good.size() - 72;    // 28 and 16 bytes of it, its options, and the last length
    ASSERT_EQ(static_cast<std::uint8_t>(good[packet]), 6);
    std::string too_long = good, stranger = good;
    put(too_long, packet + 20, std::uint32_t{60000});
    const auto why_skipped = [](const std::string& file) -> std::string {
        const auto read = read_pcapng(file);
        return read.skipped.count == 1 ? std::string{read.skipped.first.front().why} : read.fault;
    };
    EXPECT_EQ(why_skipped(too_long), "a packet is longer than its block");
    put(stranger, packet + 8, std::uint32_t{1});
    EXPECT_EQ(why_skipped(stranger), "a packet belongs to an interface without a description");
    std::string name = good;
    put(name, name.find("fc") - 2, std::uint16_t{0xFF});    // the length of if_name
    EXPECT_EQ(read_pcapng(name).items.at(0).link, "");
    std::string option = good;
    put(option, packet + 28 + 16 + 2, std::uint16_t{0xFFFF});    // the length of epb_flags
    const auto read = read_pcapng(option);
    ASSERT_EQ(read.items.size(), 1u);
    EXPECT_EQ(read.items[0].boottime_ns, 0u);    // invalid options are ignored from there on
}

std::string block_of(std::uint32_t type, std::uint32_t size) {
    std::string block(size, '\0');
    put(block, 0, type);
    put(block, 4, size);
    put(block, size - 4, size);
    return block;
}

TEST(Pcapng, continues_after_a_damaged_block_with_valid_lengths) {
    const std::string good = write_pcapng({came(euler)}, head, false);
    const std::string_view packet = std::string_view{good}.substr(good.size() - 72);
    const std::string damaged = block_of(6, 16);    // a packet of 4 bytes
    std::string file = good + damaged;
    file += packet;
    const auto read = read_pcapng(file, 5);
    EXPECT_EQ(read.fault, "");
    EXPECT_EQ(read.items, (std::vector<KeptItem>{came(euler), came(euler)}));
    EXPECT_EQ(read.position, file.size());
    ASSERT_EQ(read.skipped.count, 1u);
    EXPECT_EQ(read.skipped.frames, 1u);
    EXPECT_EQ(read.skipped.bytes, damaged.size());
    EXPECT_EQ(read.skipped.first.at(0), (SkippedPart{good.size(), damaged.size(), 1, "a packet is too short"}));
}

TEST(Pcapng, interfaces_keep_their_numbers_after_a_damaged_one) {
    const std::string good = write_pcapng({came(euler)}, head, false);
    const std::size_t section = static_cast<unsigned char>(good[4]);
    std::string file = good.substr(0, section) + block_of(1, 12) + good.substr(section);
    put(file, file.size() - 72 + 8, std::uint32_t{1});
    const auto read = read_pcapng(file);
    EXPECT_EQ(read.items, std::vector<KeptItem>{came(euler)});
    ASSERT_EQ(read.skipped.count, 1u);
    EXPECT_EQ(read.skipped.frames, 0u);
    EXPECT_EQ(read.skipped.first[0].why, "the description of an interface is too short");
}

TEST(Pcapng, long_texts_are_cut_between_characters) {
    KeptItem item = came(euler, std::string(1023, 'x') + "温度");
    EXPECT_EQ(read_pcapng(write_pcapng({item}, head)).items.at(0).link, std::string(1023, 'x'));
}

TEST(Pcapng, reads_times_of_any_resolution) {
    const std::string good = write_pcapng({came(euler)}, head, false);
    const auto time_with = [&](std::uint8_t resolution, std::uint64_t units) {
        std::string file = good;
        const std::size_t option = file.find(std::string{"\x09\x00\x01\x00\x09", 5});
        file[option + 4] = static_cast<char>(resolution);
        const std::size_t packet = good.size() - 72;
        put(file, packet + 12, static_cast<std::uint32_t>(units >> 32));
        put(file, packet + 16, static_cast<std::uint32_t>(units));
        return read_pcapng(file).items.at(0).time_ns;
    };
    EXPECT_EQ(time_with(0, 1'763'898'044), 1'763'898'044'000'000'000u);
    EXPECT_EQ(time_with(3, 1'763'898'044'123), 1'763'898'044'123'000'000u);
    EXPECT_EQ(time_with(0x80 | 10, 1'763'898'044ull * 1024 + 512), 1'763'898'044'500'000'000u);
    EXPECT_EQ(time_with(12, 1'500'000'000'000), 1'500'000'000u);
    EXPECT_EQ(time_with(20, 1), 0u);    // not supported
    EXPECT_EQ(time_with(0xFF, 1), 0u);
}

}    // namespace
}    // namespace pcapng_tests
