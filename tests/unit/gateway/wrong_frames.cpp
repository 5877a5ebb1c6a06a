// Devices with one error in their frames, and the names of the errors.
#include <gateway/hints.hpp>
#include <gateway/wrong_frames.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <variant>

namespace wrong_frames_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::operator+;

namespace {

Bytes sealed(Bytes bytes) {
    const ano::Checks checks = ano::checks_of(bytes);
    return bytes + Bytes{checks.sum, checks.add};
}

// A second of telemetry: attitude, position, log.
Bytes stream_of(Bytes (*frame)(std::uint8_t id, const Bytes& data)) {
    Bytes all;
    support::Random random{3};
    for (std::uint8_t n = 0; n < 30; ++n) {
        Bytes data(random.of<std::size_t>({7, 9, 13, 40}));
        for (auto& byte : data) byte = random.byte();
        all = all + frame(random.of<std::uint8_t>({0x03, 0x07, 0xA0}), data);
    }
    return all;
}

Bytes swapped(std::uint8_t id, const Bytes& data) {
    Bytes bytes = support::frame(0xDC, 0xFE, id, data);
    std::swap(bytes[bytes.size() - 2], bytes[bytes.size() - 1]);
    return bytes;
}
Bytes one_byte(std::uint8_t id, const Bytes& data) {
    return sealed(Bytes{0xAB, 0xDC, 0xFE, id, static_cast<std::uint8_t>(data.size())} + data);
}
Bytes big_endian(std::uint8_t id, const Bytes& data) {
    return sealed(Bytes{0xAB, 0xDC, 0xFE, id, 0, static_cast<std::uint8_t>(data.size())} + data);
}
Bytes old_body(std::uint8_t id, const Bytes& data) {
    return sealed(Bytes{0xAB, 0xFF, id, static_cast<std::uint8_t>(data.size())} + data);
}
Bytes bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

// The counters and stored bytes of a link after these bytes.
LinkFigures after(const Bytes& bytes) {
    ano::FrameParser parser{{}};
    for (std::span<const std::uint8_t> rest{bytes}; !rest.empty();) {
        const std::size_t n = std::min<std::size_t>(rest.size(), 50);
        std::copy_n(rest.begin(), n, parser.prepare().begin());
        parser.commit(n, {});
        while (parser.next()) {}
        rest = rest.subspan(n);
    }
    parser.finish();
    while (parser.next()) {}
    LinkFigures figures;
    figures.up = true;
    figures.up_for = 10s;
    add(figures.received, parser.counters());
    add_skipped(figures, parser);
    return figures;
}

TEST(WrongFrames, of_a_device_with_one_error_are_identified_by_that_error) {
    const auto hint_of = [](Bytes (*frame)(std::uint8_t, const Bytes&)) { return find_hint(after(stream_of(frame))); };
    EXPECT_EQ(hint_of(swapped).id, "checks_swapped");
    EXPECT_EQ(hint_of(one_byte).id, "length_of_one_byte");
    EXPECT_EQ(hint_of(big_endian).id, "length_big_endian");
    EXPECT_EQ(hint_of(old_body).id, "older_body");
    EXPECT_NE(hint_of(swapped).text.find("SC first, then AC"), std::string::npos);
}

TEST(WrongFrames, are_also_identified_where_another_device_sends_valid_frames) {
    const auto good = [](std::uint8_t id, const Bytes& data) { return support::frame(0xDF, 0xFE, id, data); };
    EXPECT_EQ(find_hint(after(stream_of(good) + stream_of(swapped))).id, "checks_swapped");
    EXPECT_NE(find_hint(after(stream_of(good) +
                              bytes_of("a line of a log that is printed between the frames\r\nand one more line\r\n")))
                  .id,
              "text");
}

TEST(WrongFrames, show_the_first_characters_of_received_text_with_control_characters_escaped) {
    const Hint english = find_hint(
        after(bytes_of("ts boot\r\n+READY \x1b[31m'AT'\r\nESP-ROM:esp32c3-api1-20210207\r\nBuild:Feb  7 2021\r\nrst:0x1\r\n")));
    EXPECT_EQ(english.id, "text");
    EXPECT_TRUE(english.text.ends_with("; received: '+READY \\x1B[31m\\x27AT\\x27\\r\\nESP-ROM:esp'")) << english.text;
    ASSERT_EQ(english.args.size(), 1u);
    // "启动完成" in GBK
    const Hint gbk = find_hint(after(bytes_of(
        "x\n\xC6\xF4\xB6\xAF\xCD\xEA\xB3\xC9: level 3, battery 11.1 V, all sensors are ready now and the motors are locked\n")));
    EXPECT_EQ(gbk.id, "text");
}

TEST(WrongFrames, text_without_line_ends_is_recognized_as_text) {
    Bytes all;
    for (int i = 0; i < 40; ++i) all = all + bytes_of("x=1.00,y=2.00,");
    EXPECT_EQ(find_hint(after(all)).id, "text");
    all[100] = 0x80;
    EXPECT_NE(find_hint(after(all)).id, "text") << "data that happens to be printable";
    EXPECT_NE(find_hint(after(Bytes(1000, 'U'))).id, "text") << "a wrong baud rate";
}

TEST(WrongFrames, mainly_chinese_text_is_recognized_as_text_and_shown_in_readable_form) {
    const std::string_view utf8 = "姿态 横滚=7\r\n错误：传感器没有回答，第8次\r\n";
    const std::string_view gbk =
        "\xD7\xCB\xCC\xAC \xBA\xE1\xB9\xF6=7\r\n\xB4\xED\xCE\xF3\xA3\xBA\xB4\xAB\xB8\xD0\xC6\xF7\xC3\xBB"
        "\xD3\xD0\xBB\xD8\xB4\xF0\xA3\xAC\xB5\xDA"
        "8\xB4\xCE\r\n";
    for (const std::string_view line : {utf8, gbk}) {
        Bytes all;
        for (int i = 0; i < 12; ++i) all = all + bytes_of(line);
        LinkFigures link = after(all);
        EXPECT_EQ(find_hint(link).id, "text");
        link.to_utf8 = [](std::span<const std::uint8_t> text) { return std::string{text.begin(), text.end()}; };
        const auto shown = std::get<std::string>(find_hint(link).args.at(0).second);
        if (line == utf8) {
            EXPECT_EQ(shown.substr(0, std::string_view{"错误：传感器"}.size()), "错误：传感器");
        }
        EXPECT_EQ(shown.find('\r'), std::string::npos);
    }
}

TEST(WrongFrames, noise_and_a_wrong_baud_rate_are_reported_as_neither_wrong_frames_nor_text) {
    support::Random random{1};
    for (int i = 0; i < 300; ++i) {
        Bytes noise(1024);
        const bool few = i % 2 == 0;
        for (auto& byte : noise)
            byte = few ? random.of<std::uint8_t>({0x00, 0x80, 0xF8, 0xFE, 0xAB, 0x06, 0x66, 0x7E, 0xE0}) : random.byte();
        ASSERT_EQ(find_wrong_frames(noise), WrongFrames::none) << i;
    }
    EXPECT_EQ(find_wrong_frames({}), WrongFrames::none);
    EXPECT_EQ(find_wrong_frames(Bytes(1024, 0xAB)), WrongFrames::none);
}

// Only the newest bytes are kept, whatever the sizes of the pieces.
TEST(WrongFrames, stored_bytes_are_the_newest_in_order_of_arrival) {
    ano::FrameParser parser{{}};
    Bytes all;
    support::Random random{2};
    for (int i = 0; i < 300; ++i) {
        const std::size_t n = 1 + random.below(random.of<std::size_t>({5, 100, 3000}));
        Bytes piece(n);
        for (auto& byte : piece) byte = static_cast<std::uint8_t>(random.byte() | 1u) & 0x7F;    // no header
        std::copy(piece.begin(), piece.end(), parser.prepare().begin());
        parser.commit(n, {});
        while (parser.next()) {}
        all = all + piece;
        Bytes kept(ano::FrameParser::kept_skipped);
        kept.resize(parser.copy_skipped(kept));
        const std::size_t expected = std::min(all.size(), ano::FrameParser::kept_skipped);
        ASSERT_EQ(kept, Bytes(all.end() - static_cast<std::ptrdiff_t>(expected), all.end()));
    }
}

}    // namespace
}    // namespace wrong_frames_tests
