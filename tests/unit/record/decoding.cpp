// Every recording contains the layouts that decode its frames.
#include <record/decoding.hpp>
#include <record/mcap/mcap_format.hpp>
#include <record/mcap/mcap_index.hpp>
#include <record/recording_reader.hpp>
#include <record/recording_repair.hpp>
#include <record/sender_encodings.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include <support/bytes.hpp>

namespace decoding_tests {
namespace {

using namespace anogate;
using support::Bytes;
using support::operator+;

const Bytes frame = support::frame(5, 0xFE, 0xF1, {7, 1});

DecodingPtr with(const std::string& name, std::size_t fields = 1) {
    ano::FlexibleSpec spec{.id = 0xF1};
    for (std::size_t i = 0; i < fields; ++i)
        spec.fields.push_back({i == 0 ? name : name + std::to_string(i), ano::Type::u8, 1, "µV"});
    return std::make_shared<const Decoding>(std::vector{spec});
}

RecordedFrame passed(std::uint64_t second) {
    return {.time_ns = second * 1'000'000'000, .link = "fc", .frame = ano::FrameView{frame}};
}

/// A frame before a change, and one after it; `size`: the bytes written before the change.
std::string recorded(RecordingFormat format, const DecodingPtr& first, const DecodingPtr& then, std::size_t* size = nullptr) {
    std::string file;
    const auto writer = make_recording_writer(format, {"anogated test", 1, 2, first}, file);
    writer->write(passed(1), file);
    if (size) {
        writer->flush(file);
        *size = file.size();
    }
    writer->use(then, file);
    writer->write(passed(2), file);
    writer->end(file);
    return file;
}

std::string name_in(const DecodingPtr& decoding) {
    return decoding && !decoding->flexible().empty() ? decoding->flexible()[0].fields[0].name : "";
}

/// The name of the first field in the layout of each frame.
std::vector<std::string> names_of(std::string_view file, std::size_t step = 4096) {
    std::vector<std::string> names;
    const auto reader = make_recording_reader(file);
    for (std::size_t at = 0; at < file.size(); at += step) {
        reader->feed(file.substr(at, step));
        while (const auto item = reader->next())
            if (std::holds_alternative<RecordedFrame>(*item)) names.push_back(name_in(reader->head().decoding));
    }
    EXPECT_EQ(reader->fault(), nullptr);
    return names;
}

// 模 in GBK, and ģ in UTF-8.
TEST(SenderEncodings, are_those_of_the_link_that_received_the_sender) {
    const Decoding decoding{{}, {}, {{"gbk", LinkTexts::gbk}, {"utf8", LinkTexts::utf8}, {"old", LinkTexts::expect_gbk}}};
    const auto log = [](std::uint8_t from, std::uint8_t to, const Bytes& text) {
        return support::frame(from, to, 0xA0, Bytes{0} + text);
    };
    const Bytes both{0xC4, 0xA3}, with_letters{'c', 'a', 'f', 0xC3, 0xA9};
    SenderEncodings encodings;
    const auto of = [&](const Bytes& bytes, const std::string& link, bool is_received, const Decoding* by) {
        return encodings.of(ano::FrameView{bytes}, link, is_received, by);
    };
    EXPECT_EQ(of(log(1, 0xFE, both), "utf8", true, &decoding), ano::Encoding::utf8);
    EXPECT_EQ(of(log(2, 0xFE, with_letters), "gbk", true, &decoding), ano::Encoding::gbk);
    EXPECT_EQ(of(log(3, 0xFE, with_letters), "old", true, &decoding), ano::Encoding::gbk);
    EXPECT_EQ(of(log(4, 0xFE, with_letters), "plain", true, &decoding), ano::Encoding::automatic);
    EXPECT_EQ(of(log(2, 0xFE, with_letters), "utf8", false, &decoding), ano::Encoding::gbk) << "it leaves by another link";
    EXPECT_EQ(of(log(0xFE, 2, with_letters), "gbk", false, &decoding), ano::Encoding::gbk) << "for the device there";
    EXPECT_EQ(of(log(5, 0xFE, both), "utf8", true, nullptr), ano::Encoding::gbk) << "found out";
}

using Names = std::vector<std::string>;

TEST(Decoding, is_restored_from_its_text) {
    const Decoding decoding{
        {{.id = 0xF1, .source = 30, .fields = {{"a", ano::Type::i16, 0.1, "V", 4}}, .endian = ano::ByteOrder::big},
         {.id = 0xF1, .fields = {{"kind", ano::Type::u8, 1, ""}}, .when = 3}},
        {"fc", "链路"},
        {{"fc", LinkTexts::gbk}, {"radio", LinkTexts::utf8}, {"old", LinkTexts::expect_gbk}}};
    const DecodingPtr again = Decoding::parse(decoding.text());
    ASSERT_NE(again, nullptr);
    EXPECT_EQ(*again, decoding);
    EXPECT_EQ(again->attitude("fc"), ano::EulerSigns::lx);
    EXPECT_EQ(again->attitude("radio"), ano::EulerSigns::document);
    EXPECT_EQ(again->texts("fc"), LinkTexts::gbk);
    EXPECT_EQ(again->texts("other"), std::nullopt);
    EXPECT_EQ(again->layouts().all().size(), 2u);
    EXPECT_EQ(Decoding{}.text(), "{}");
    for (const char* const wrong : {"", "5", "{", R"({"flexible": 3})", R"({"flexible": [{"id": 3}]})"})
        EXPECT_EQ(Decoding::parse(wrong), nullptr) << wrong;
}

TEST(Decoding, is_stored_in_recordings_of_both_formats_even_when_it_changes) {
    for (const RecordingFormat format : {RecordingFormat::pcapng, RecordingFormat::mcap}) {
        EXPECT_EQ(names_of(recorded(format, with("before"), with("after"))), (Names{"before", "after"})) << text(format);
        EXPECT_EQ(names_of(recorded(format, {}, with("after")), 1), (Names{"", "after"})) << text(format);
        EXPECT_EQ(names_of(recorded(format, with("before"), {})), (Names{"before", ""})) << text(format);
        EXPECT_EQ(names_of(recorded(format, with("long", 1500), with("longer", 1501))), (Names{"long", "longer"}))
            << text(format);
    }
}

TEST(Decoding, turns_flexible_frames_into_messages_in_mcap) {
    const std::string file = recorded(RecordingFormat::mcap, with("before"), with("after"));
    std::string_view rest{file};
    rest.remove_prefix(mcap::magic.size());
    std::vector<std::string> schemas;
    while (const auto record = mcap::next_record(rest)) {
        if (record->opcode != mcap::Opcode::schema) continue;
        mcap::Fields fields{record->body};
        fields.number<std::uint16_t>();
        if (fields.text() != "ano_msgs/msg/Flexible1") continue;
        fields.text();
        schemas.emplace_back(fields.text());
    }
    ASSERT_EQ(schemas.size(), 2u) << "in the summary, which repeats those in the chunks";
    EXPECT_NE(schemas[0].find("uint8 before"), std::string::npos);
    EXPECT_NE(schemas[1].find("uint8 after"), std::string::npos);
}

TEST(Decoding, is_part_of_the_mcap_index) {
    const std::string file = recorded(RecordingFormat::mcap, with("before"), with("after"));
    const auto index = read_mcap_index(
        file.size(), [&](std::uint64_t at, std::size_t size) { return file.substr(static_cast<std::size_t>(at), size); });
    ASSERT_TRUE(index);
    EXPECT_EQ(index->counts.frames, 2u);
    EXPECT_EQ(name_in(index->head.decoding), "after");
}

TEST(Decoding, is_kept_in_a_recording_that_was_truncated_and_repaired) {
    for (const RecordingFormat format : {RecordingFormat::pcapng, RecordingFormat::mcap}) {
        std::size_t until_change = 0;
        const std::string whole = recorded(format, with("before"), with("after"), &until_change);
        for (const std::size_t size : {until_change, until_change + (whole.size() - until_change) / 2, whole.size() - 1}) {
            RecordingRepair repair{format};
            repair.feed(std::string_view{whole}.substr(0, size));
            const auto result = repair.finish();
            const std::string repaired = whole.substr(0, static_cast<std::size_t>(result.keep)) + result.append;
            const Names names = names_of(repaired);
            ASSERT_GE(names.size(), 1u) << text(format) << " " << size;
            EXPECT_EQ(names[0], "before");
            if (names.size() > 1) {
                EXPECT_EQ(names[1], "after");
            }
        }
    }
}

}    // namespace
}    // namespace decoding_tests
