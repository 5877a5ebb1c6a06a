#include <ano/frame.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

using ano::Checks;
using support::Bytes;

namespace frame_tests {
namespace {

// As the protocol text defines it.
Checks plain_checks(const Bytes& bytes) {
    unsigned sum = 0;
    unsigned add = 0;
    for (const auto byte : bytes) {
        sum = (sum + byte) % 256;
        add = (add + sum) % 256;
    }
    return {static_cast<std::uint8_t>(sum), static_cast<std::uint8_t>(add)};
}

const std::vector<Bytes> vendor_frames{
    {0xAB, 0xFE, 0xFF, 0xE0, 0x03, 0x00, 0x00, 0x00, 0x00, 0x8B, 0x3B},
    {0xAB, 0xDB, 0xFE, 0xE3, 0x0F, 0x00, 0xDB, 0x64, 0x00, 0x64, 0x00, 0x00,
     0x00, 0x20, 0x03, 0x41, 0x6E, 0x6F, 0x4D, 0x43, 0x55, 0x3F, 0x2E},
    {0xAB, 0xFE, 0xDB, 0xE1, 0x03, 0x00, 0x00, 0x00, 0xFA, 0x62, 0x3F},
    {0xAB, 0xDB, 0xFE, 0x00, 0x03, 0x00, 0xE1, 0x62, 0x3F, 0x09, 0x82},
    {0xAB, 0xFE, 0xBA, 0xC0, 0x0B, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x2F, 0x3B},
};

TEST(Frame, of_the_vendor_is_read_correctly) {
    for (const Bytes& bytes : vendor_frames) {
        const auto frame = ano::frame_at(bytes);
        ASSERT_TRUE(frame);
        EXPECT_TRUE(std::ranges::equal(frame->bytes(), bytes));
    }
    const auto info = ano::frame_at(vendor_frames[1]);
    EXPECT_EQ(info->source(), 0xDB);
    EXPECT_EQ(info->destination(), 0xFE);
    EXPECT_EQ(info->id(), 0xE3);
    EXPECT_EQ(info->data().size(), 15u);
    EXPECT_EQ(info->data().front(), 0xDB);
    EXPECT_EQ(info->data().back(), 0x55);
    EXPECT_EQ(info->checks(), (Checks{0x3F, 0x2E}));
}

TEST(Frame, is_encoded_as_by_the_vendor) {
    for (const Bytes& bytes : vendor_frames)
        EXPECT_EQ(support::frame(bytes[1], bytes[2], bytes[3], {bytes.begin() + 6, bytes.end() - 2}), bytes);
}

TEST(Frame, is_made_at_compile_time_as_well) {
    constexpr auto bytes = [] {
        std::array<std::uint8_t, 48> out{};
        ano::encode(out, 0xFE, 0xFF, 0xE0, std::array<std::uint8_t, 40>{0, 1, 2});
        return out;
    }();
    static_assert(ano::frame_at(bytes).has_value());
    EXPECT_EQ(support::frame(0xFE, 0xFF, 0xE0,
                             [] {
                                 Bytes data(40);
                                 data[1] = 1;
                                 data[2] = 2;
                                 return data;
                             }()),
              Bytes(bytes.begin(), bytes.end()));
}

TEST(Frame, has_the_checks_of_the_protocol_text_at_every_length) {
    support::Random random{1};
    Bytes bytes;
    for (int n = 0; n < 300; ++n) {
        EXPECT_EQ(ano::checks_of(Bytes(bytes)), plain_checks(bytes)) << n;    // a copy has exactly its size
        bytes.push_back(random.byte());
    }
    for (const auto filler : Bytes{0x00, 0x01, 0xAB, 0xFF}) {
        const Bytes longest(ano::header_size + ano::max_len, filler);
        EXPECT_EQ(ano::checks_of(longest), plain_checks(longest));
    }
}

TEST(Frame, can_be_empty_or_as_large_as_LEN_can_express) {
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{256}, ano::max_len}) {
        const Bytes bytes = support::frame(1, 2, 3, Bytes(size, 0x5A));
        ASSERT_EQ(bytes.size(), ano::overhead + size);
        const auto frame = ano::frame_at(bytes);
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->data().size(), size);
    }
}

TEST(Frame, is_refused_when_any_bit_of_it_is_wrong) {
    const Bytes good = vendor_frames[0];
    for (std::size_t i = 0; i < good.size(); ++i) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            Bytes bytes = good;
            bytes[i] ^= static_cast<std::uint8_t>(1u << bit);
            EXPECT_FALSE(ano::frame_at(bytes)) << "bit " << bit << " of byte " << i;
        }
    }
}

TEST(Frame, is_refused_when_cut_short_and_read_when_more_follows) {
    const Bytes good = vendor_frames[1];
    for (std::size_t n = 0; n < good.size(); ++n)
        EXPECT_FALSE(ano::frame_at(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(n)))) << n;
    Bytes more = good;
    more.push_back(0xAB);
    ASSERT_TRUE(ano::frame_at(more));
    EXPECT_EQ(ano::frame_at(more)->bytes().size(), good.size());
}

TEST(Frame, is_refused_when_its_data_exceed_max_data) {
    const Bytes bytes = support::frame(1, 2, 3, Bytes(10));
    EXPECT_TRUE(ano::frame_at(bytes, 10));
    EXPECT_FALSE(ano::frame_at(bytes, 9));
}

TEST(Encode, writes_nothing_without_room_for_all_of_it) {
    const Bytes data(10, 0x5A);
    Bytes out(ano::overhead + data.size() - 1, 0x77);
    EXPECT_EQ(ano::encode(out, 1, 2, 3, data), 0u);
    EXPECT_EQ(out, Bytes(out.size(), 0x77));
    EXPECT_EQ(ano::encode(out, 1, 2, 3, Bytes(9)), out.size());
}

TEST(Encode, rejects_data_longer_than_LEN_can_express) {
    Bytes out(ano::max_frame_size + 1);
    EXPECT_EQ(ano::encode(out, 1, 2, 3, Bytes(ano::max_len + 1)), 0u);
    EXPECT_EQ(ano::encode(out, 1, 2, 3, Bytes(ano::max_len)), ano::max_frame_size);
}

TEST(Seal, makes_a_changed_frame_valid_again) {
    Bytes bytes = vendor_frames[0];
    bytes[1] = 0x1E;
    EXPECT_FALSE(ano::frame_at(bytes));
    ano::seal(bytes);
    EXPECT_TRUE(ano::frame_at(bytes));
}

}    // namespace
}    // namespace frame_tests
