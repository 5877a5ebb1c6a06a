#include <gtest/gtest.h>
#include <ano/reading.hpp>
#include <ano_json/frame_json.hpp>

#include <algorithm>
#include <set>
#include <string>
#include <variant>

#include <support/vectors.hpp>

namespace vectors_tests {
namespace {

using namespace ano;

TEST(GoldenVectors, decode_to_their_json) {
    for (const auto& v : support::golden_vectors()) {
        const auto frame = frame_at(v.bytes);
        ASSERT_TRUE(frame) << v.name;
        EXPECT_EQ(frame->bytes().size(), v.bytes.size()) << v.name;
        EXPECT_EQ(frame_to_json(*frame), v.json) << v.name << "\n" << frame_to_json(*frame).dump();
    }
}

TEST(GoldenVectors, encode_to_their_bytes) {
    for (const auto& v : support::golden_vectors()) {
        const auto encoded = frame_from_json(v.json);
        const auto* fault = std::get_if<JsonFault>(&encoded);
        ASSERT_EQ(fault, nullptr) << v.name << ": " << fault->pointer << ": " << fault->what;
        EXPECT_EQ(std::get<0>(encoded), v.bytes) << v.name;
    }
}

TEST(GoldenVectors, hold_every_layout_of_every_message) {
    std::set<const Message*> seen;
    for (const auto& v : support::golden_vectors())
        if (const auto frame = frame_at(v.bytes))
            if (const Message* row = select_layout(layouts_of(frame->id()), frame->data())) seen.insert(row);
    for (const Message& row : messages) EXPECT_TRUE(seen.contains(&row)) << row.name << " " << row.variant.label;
}

}    // namespace
}    // namespace vectors_tests
