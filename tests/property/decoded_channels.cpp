// Decoded messages for other programs, read by their definition alone, have the values of our own decoding, for every message of
// the table and any bytes of DATA. The reader of CDR is Fast-CDR, which ROS 2 uses, if it is installed.
#include <ano/messages.hpp>
#include <ano/reading.hpp>
#include <ano_json/frame_json.hpp>
#include <record/decoded_channels.hpp>
#include <ros/cdr_encoder.hpp>
#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/ros_definition.hpp>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#if ANOGATE_FAST_CDR
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#endif

namespace decoded_channels_tests {

namespace {

using ano::Json;
using anogate::DecodedChannels;
using anogate::DecodedEncoding;
using support::Bytes;
using support::Random;
using support::RosDefinition;

anogate::RecordedFrame passed(const Bytes& frame, std::uint64_t time_ns = 1) {
    return {.time_ns = time_ns, .link = "fc", .frame = ano::FrameView{frame}};
}

/// DATA that fits a layout, and shorter or longer DATA.
Bytes random_data(const ano::Message& row, Random& random) {
    std::size_t size = row.variant.length != 0 ? row.variant.length : row.fixed_size;
    if (row.is_open()) size += random.below(40u);
    if (random.one_in(8)) size = random.below(60u);
    Bytes data(size);
    for (auto& byte : data) byte = random.one_in(4) ? random.of<std::uint8_t>({0, 1, 0x80, 0xFF}) : random.byte();
    for (const ano::Field& f : row.fields()) {
        if (f.type == ano::Type::text)
            for (std::size_t i = f.offset; i < (f.is_open() ? size : std::min<std::size_t>(f.offset + f.size(), size)); ++i)
                if (random.below(4u) != 0) data[i] = static_cast<std::uint8_t>('a' + random.below(26u));
        if (!f.selects || f.offset + f.size() > size) continue;
        const std::uint32_t value = f.selects->first + random.below(f.selects->last - f.selects->first + 1);
        for (std::size_t i = 0; i < f.size(); ++i) data[f.offset + i] = static_cast<std::uint8_t>(value >> (8 * i));
    }
    return data;
}

/// A value of our decoding in the form of the message, in which bytes are numbers.
Json as_in_the_message(const ano::Reading& reading, const ano::Field& field, const Json& value) {
    if (field.type != ano::Type::bytes && field.type != ano::Type::frames) return value;
    Json bytes = Json::array();
    for (const std::uint8_t byte : reading.bytes_of(field)) bytes.push_back(byte);
    return bytes;
}

/// The differences between `told` and our own decoding; empty: none. A field with two units is found by its second name.
std::string difference(const Json& told, const Bytes& frame) {
    const ano::Reading reading = ano::read(ano::FrameView{frame});
    const Json own = ano::frame_to_json(ano::FrameView{frame}, {.encoding = ano::Encoding::automatic})["fields"];
    std::set<std::string> said;
    for (const ano::Field& f : reading.fields()) {
        std::string name{f.name};
        if (name == "dist" && f.unit == "cm") name += "_field";
        if (!told.contains(name)) return "no " + name;
        const Json expected = as_in_the_message(reading, f, own[std::string{f.name}]);
        if (told[name] != expected) return name + ": " + told[name].dump() + ", not " + expected.dump();
        said.insert(name);
    }
    for (const auto& [name, value] : told.items())
        if (!said.contains(name) && !value.is_null() && value != "" && value != Json::array()) return name + " is told";
    return {};
}

#if ANOGATE_FAST_CDR
class FastCdrReader {
public:
    explicit FastCdrReader(std::string_view data)
        : bytes_{data.begin(), data.end()},
          buffer_{bytes_.data(), bytes_.size()},
          cdr_{buffer_, eprosima::fastcdr::Cdr::LITTLE_ENDIANNESS, eprosima::fastcdr::Cdr::DDS_CDR} {
        cdr_.read_encapsulation();
    }
    template <class T>
    T number() {
        T value{};
        cdr_ >> value;
        return value;
    }
    std::string text() { return number<std::string>(); }
    std::size_t length() { return number<std::uint32_t>(); }
    bool is_at_end() const { return cdr_.getSerializedDataLength() == bytes_.size(); }

private:
    std::vector<char> bytes_;
    eprosima::fastcdr::FastBuffer buffer_;
    eprosima::fastcdr::Cdr cdr_;
};
#endif

/// Calls `see(frame, definition, data)` for each message made from `usual` random frames of every layout, our own message first.
template <class See>
void with_random_messages(std::uint64_t usual, See&& see) {
    std::map<std::size_t, RosDefinition> definitions;
    DecodedChannels decoded{DecodedEncoding::cdr};
    for (const ano::Message& row : ano::messages)
        for (std::uint64_t seed = 0; seed < support::trials(usual); ++seed) {
            Random random{seed};
            const Bytes frame = support::frame(5, 6, row.id, random_data(row, random));
            const auto messages = decoded.decode(passed(frame, random.below(std::uint64_t{1} << 34)));
            ASSERT_EQ(messages.empty(), !ano::read(ano::FrameView{frame})) << row.name << " " << seed;
            for (std::size_t i = 0; i < messages.size(); ++i) {
                const std::size_t schema = decoded.channels()[messages[i].channel].schema;
                const RosDefinition& definition = definitions.try_emplace(schema, decoded.schemas()[schema].text).first->second;
                see(frame, i == 0, definition, messages[i].data);
                if (testing::Test::HasFatalFailure()) FAIL() << row.name << " " << row.variant.label << " " << seed;
            }
        }
}

TEST(DecodedChannels, a_cdr_reader_reads_the_values_that_we_decode) {
    with_random_messages(200, [](const Bytes& frame, bool is_ours, const RosDefinition& definition, std::string_view data) {
        support::CdrReader reader{data};
        const Json told = definition.decode(reader);
        ASSERT_TRUE(reader.is_at_end());
        if (is_ours) {
            ASSERT_EQ(difference(told, frame), "");
        }
    });
}

TEST(DecodedChannels, fast_cdr_reads_the_values_that_we_decode) {
#if ANOGATE_FAST_CDR
    with_random_messages(200, [](const Bytes& frame, bool is_ours, const RosDefinition& definition, std::string_view data) {
        FastCdrReader reader{data};
        const Json told = definition.decode(reader);
        ASSERT_TRUE(reader.is_at_end());
        if (is_ours) {
            ASSERT_EQ(difference(told, frame), "");
        }
    });
#else
    GTEST_SKIP() << "built without Fast-CDR (libfastcdr-dev)";
#endif
}

TEST(DecodedChannels, every_definition_is_a_valid_ros_definition) {
    for (const ano::Message& row : ano::messages) {
        DecodedChannels decoded{DecodedEncoding::cdr};
        Random random{1};
        for (int i = 0; i < 20; ++i) decoded.decode(passed(support::frame(5, 6, row.id, random_data(row, random))));
        for (const anogate::DecodedSchema& schema : decoded.schemas()) EXPECT_NO_THROW(RosDefinition{schema.text}) << schema.text;
    }
}

TEST(DecodedChannels, names_of_flexible_values_result_in_valid_ros_definitions) {
    for (std::uint64_t seed = 0; seed < support::trials(300); ++seed) {
        Random random{seed};
        std::vector<ano::FlexibleField> fields(1 + random.below(20u));
        std::set<std::string> names;
        for (auto& field : fields) {
            do {
                field.name.clear();
                for (unsigned n = 1 + random.below(6u); n > 0; --n)
                    field.name += random.of<std::string>({"a", "B", "_", "9", " ", "#", "温", "[", "/", "-", "\xFF"});
            } while (!names.insert(field.name).second);
            field.type = random.of({ano::Type::u8, ano::Type::i16, ano::Type::u32, ano::Type::f32});
            field.scale = random.one_in(2) ? 1 : 0.1;
            field.unit = random.of<std::string>({"", "°C", "\n", "#", "a\nuint8 b"});
        }
        ano::FlexibleLayouts layouts;
        ASSERT_FALSE(layouts.add(0xF1, {}, fields)) << seed;
        Bytes data(layouts.all().front().size());
        for (auto& byte : data) byte = random.byte();
        const Bytes frame = support::frame(5, 6, 0xF1, data);
        const auto decoding = std::make_shared<const anogate::Decoding>(
            std::vector{ano::FlexibleSpec{.id = 0xF1, .fields = fields}});
        DecodedChannels cdr{DecodedEncoding::cdr, decoding}, json{DecodedEncoding::json, decoding};
        const auto messages = cdr.decode(passed(frame));
        ASSERT_EQ(messages.size(), 1u) << seed;
        EXPECT_EQ(support::decoded_cdr(cdr.schemas()[0].text, messages[0].data).size(), fields.size()) << seed;
        const auto objects = json.decode(passed(frame));
        ASSERT_EQ(objects.size(), 1u) << seed;
        EXPECT_TRUE(Json::accept(objects[0].data)) << seed;
        EXPECT_TRUE(Json::accept(json.schemas()[0].text)) << seed;
    }
}

TEST(DecodedChannels, any_frame_is_decoded_without_harm) {
    DecodedChannels cdr{DecodedEncoding::cdr}, json{DecodedEncoding::json};
    for (std::uint64_t seed = 0; seed < support::trials(20'000); ++seed) {
        Random random{seed};
        Bytes data(random.one_in(500) ? ano::max_len : random.below(64u));
        for (auto& byte : data) byte = random.byte();
        const Bytes frame = support::frame(random.byte(), random.byte(), random.byte(), data);
        anogate::RecordedFrame record = passed(frame, random.below(UINT64_MAX));
        record.link = random.of<std::string_view>({"", "fc", "/", "\xFF\n", "_"});
        for (DecodedChannels* decoded : {&cdr, &json})
            for (const anogate::DecodedMessage& message : decoded->decode(record)) {
                ASSERT_LT(message.channel, decoded->channels().size());
                ASSERT_LT(decoded->channels()[message.channel].schema, decoded->schemas().size());
                if (decoded == &json) {
                    ASSERT_TRUE(Json::accept(message.data)) << seed;
                }
            }
    }
}

TEST(DecodedChannels, cdr_allocates_nothing_for_a_message_decoded_before) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    std::vector<Bytes> frames;
    for (const ano::Message& row : ano::messages) {
        if (row.name.starts_with("ip_tunnel")) continue;    // an address as text
        frames.push_back(support::frame(5, 6, row.id, Bytes(std::max<std::size_t>(row.fixed_size, row.variant.length))));
    }
    for (int i = 0; i < 2; ++i)
        for (const Bytes& frame : frames) decoded.decode(passed(frame));
    const std::uint64_t before = support::allocations;
    for (const Bytes& frame : frames) decoded.decode(passed(frame));
    EXPECT_EQ(support::allocations, before);
}

TEST(DecodedChannels, names_beyond_the_last_channel_allocate_nothing) {
    DecodedChannels decoded{DecodedEncoding::cdr};
    const Bytes frame = support::frame(5, 6, 0x06, Bytes(5));
    anogate::RecordedFrame record = passed(frame);
    for (std::size_t i = 0; i < DecodedChannels::max_channels; ++i) {
        const std::string link = "link " + std::to_string(i);
        record.link = link;
        ASSERT_EQ(decoded.decode(record).size(), 1u);
    }
    record.link = "a name that nobody had before it";
    const std::uint64_t before = support::allocations;
    EXPECT_TRUE(decoded.decode(record).empty());
    EXPECT_EQ(support::allocations, before);
}

}    // namespace
}    // namespace decoded_channels_tests
