#include <gtest/gtest.h>
#include <anoctl/text/hex_text.hpp>

#include <string>
#include <string_view>

#include <support/bytes.hpp>

namespace hex_text_tests {
namespace {

using namespace anoctl;
using support::Bytes;

TEST(HexText, accepts_the_usual_notations_for_bytes) {
    const Bytes expected{0xAB, 0xFE, 1};
    for (const char* text : {"AB FE 01", "abfe01", "0xAB 0xFE 0x01", "0XAB, 0xfe, 0x1,", "0xABFE01", "ABFE\r\n01\n", "AB,FE,01"})
        EXPECT_EQ(from_hex_text(text), expected) << text;
    EXPECT_EQ(from_hex_text(""), Bytes{});
    EXPECT_EQ(from_hex_text("00 0x00 000x0"), std::nullopt);
    EXPECT_EQ(from_hex_text("00 0x00 00"), (Bytes{0, 0, 0}));
    for (const char* wrong : {"A", "A B", "0x", "0x ", "0xABC", "xAB", "AB0xFE", "0x0xAB", "1x2", "zz", "AB;", "AB-FE",
                              "\xEF"
                              "12",
                              "\xEF\xBB"
                              "12"})
        EXPECT_EQ(from_hex_text(wrong), std::nullopt) << wrong;
}

// The result for `input`, passed in pieces of `size` bytes.
Bytes read(std::string_view input, std::size_t size, std::size_t* bad_line = nullptr) {
    BytesOrText reader;
    Bytes all;
    const auto take = [&](std::span<const std::uint8_t> bytes) { all.insert(all.end(), bytes.begin(), bytes.end()); };
    for (std::size_t at = 0; at < input.size(); at += size) {
        const std::string_view piece = input.substr(at, size);
        take(reader.read({reinterpret_cast<const std::uint8_t*>(piece.data()), piece.size()}));
    }
    take(reader.finish());
    if (bad_line != nullptr) *bad_line = reader.bad_line();
    return all;
}
Bytes raw(std::string_view text) { return {text.begin(), text.end()}; }

TEST(BytesOrText, is_recognized_however_the_input_is_split) {
    const std::string frame = "AB DB FE A0 0C 00 02 74 65 73 74 46 75 6E 20 4F 4B 21 F6 1C\n";
    const Bytes bytes = from_hex_text(frame).value();
    const std::string raw_frame{bytes.begin(), bytes.end()};
    for (std::size_t size = 1; size < 70; ++size) {
        EXPECT_EQ(read(frame, size), bytes);
        EXPECT_EQ(read("12 34\n" + frame, size).size(), bytes.size() + 2);
        EXPECT_EQ(read(raw_frame, size), bytes);
        EXPECT_EQ(read("abc" + raw_frame, size), raw("abc" + raw_frame));
        EXPECT_EQ(read("12 34\n" + raw_frame, size), raw("12 34\n" + raw_frame));
        EXPECT_EQ(read("abc", size), raw("abc"));
        EXPECT_EQ(read(" \n", size), raw(" \n"));
        EXPECT_EQ(read("12", size), Bytes{0x12});
        EXPECT_EQ(read("\xEF\xBB\xBF" + frame, size), bytes) << "a byte order mark";
        EXPECT_EQ(read("\xEF\xBB\xBF" + raw_frame, size), raw("\xEF\xBB\xBF" + raw_frame));
        EXPECT_EQ(read("\xEF\xBB", size), raw("\xEF\xBB"));
        EXPECT_EQ(read("", size), Bytes{});
    }
}

TEST(BytesOrText, returns_the_bytes_of_text_that_begins_like_a_frame_at_once) {
    BytesOrText reader;
    const Bytes text = raw("AB DB FE A0 00 00 24 4");
    EXPECT_EQ(reader.read({text.data(), text.size() - 3}).size(), 0u);    // 6 bytes
    EXPECT_EQ(reader.read({text.data() + text.size() - 3, 3}).size(), 0u);
    const Bytes rest = raw("E 12");
    const auto bytes = reader.read(rest);
    EXPECT_EQ(bytes.size(), 9u);
    EXPECT_EQ(reader.finish().size(), 0u);
}

TEST(BytesOrText, buffers_at_most_one_mebibyte_of_text_that_does_not_begin_like_a_frame) {
    BytesOrText reader;
    std::string text;
    while (text.size() < (1u << 20) - 3) text += "12 ";
    EXPECT_EQ(reader.read(raw(text)).size(), 0u);
    EXPECT_EQ(reader.read(raw("12 34 ")).size(), text.size() / 3 + 2);
}

TEST(BytesOrText, names_the_first_line_that_is_not_hex_text) {
    const std::string line = "AB DB FE A0 00 00 24 4E\n";
    for (std::size_t size = 1; size < 60; ++size) {
        std::size_t bad_line = 0;
        EXPECT_EQ(read(line + line + "hello\n" + line, size, &bad_line).size(), 16u);
        EXPECT_EQ(bad_line, 3u);
        read(line + "A", size, &bad_line);
        EXPECT_EQ(bad_line, 2u);
        read(line, size, &bad_line);
        EXPECT_EQ(bad_line, 0u);
    }
}

}    // namespace
}    // namespace hex_text_tests
