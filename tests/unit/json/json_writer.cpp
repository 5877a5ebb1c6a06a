#include <ano_json/json_writer.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <bit>
#include <cmath>
#include <limits>
#include <string>

namespace json_writer_tests {
namespace {

using ano::JsonWriter;
using Json = nlohmann::ordered_json;

std::string written(auto&& write) {
    std::string text;
    JsonWriter out{text};
    write(out);
    return text;
}

std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

TEST(JsonWriter, puts_commas_between_members_and_elements) {
    EXPECT_EQ(written([](JsonWriter& out) {
                  out.begin_object();
                  out.key("a");
                  out.begin_array();
                  out.null();
                  out.begin_object();
                  out.end_object();
                  out.boolean(true);
                  out.end_array();
                  out.key("b");
                  out.number(std::int64_t{-1});
                  out.end_object();
              }),
              R"({"a":[null,{},true],"b":-1})");
}

TEST(JsonWriter, leaves_out_members_that_are_null) {
    EXPECT_EQ(written([](JsonWriter& out) {
                  out.begin_object();
                  out.member_unless_null("a", [&] { out.null(); });
                  out.member_unless_null("b", [&] { out.text("null"); });
                  out.member_unless_null("c", [&] { out.number(std::nan("")); });
                  out.member_unless_null("d", [&] { out.number(std::uint64_t{7}); });
                  out.end_object();
              }),
              R"({"b":"null","d":7})");
}

TEST(JsonWriter, writes_texts_and_numbers_like_the_library) {
    for (std::uint64_t seed = 0; seed < support::trials(5000); ++seed) {
        support::Random random{seed};
        std::string text(random.below(12u), 'a');
        for (char& c : text)
            c = random.one_in(3) ? random.of({'"', '\\', '\n', '\x7F', '\0', '\xE6', '\xB8', '\xA9'})
                                 : static_cast<char>(random.byte());
        EXPECT_EQ(written([&](JsonWriter& out) { out.text(text); }), dumped(text));
        const auto bits = random.below(std::uint64_t{1} << 63) * 2 + random.below(2u);
        const double whole = static_cast<double>(static_cast<std::int64_t>(bits) >> random.below(63u));
        const double hundredths = std::round(static_cast<double>(random.below(1'000'000u))) / 100;
        for (const double number : {std::bit_cast<double>(bits), whole, -hundredths, hundredths})
            EXPECT_EQ(written([&](JsonWriter& out) { out.number(number); }), dumped(number));
        EXPECT_EQ(written([&](JsonWriter& out) { out.number(bits); }), dumped(bits));
    }
    for (const double number : {0.0, -0.0, 2.0, 1e15, 1e16, 1e-5})
        EXPECT_EQ(written([&](JsonWriter& out) { out.number(number); }), dumped(number));
    EXPECT_EQ(written([&](JsonWriter& out) { out.number(-std::numeric_limits<double>::infinity()); }), "null");
}

}    // namespace
}    // namespace json_writer_tests
