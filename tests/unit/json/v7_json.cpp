// Frames of V7 as JSON, and back.
#include <ano/hex.hpp>
#include <ano_json/v7_json.hpp>
#include <support/random.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace v7_json_tests {

using ano::Json;
using support::Bytes;
using support::v7_frame;
namespace v7 = ano::v7;

namespace {

std::string fault(const Json& json) {
    const auto result = ano::v7_frame_from_json(json);
    const auto* const fault = std::get_if<ano::JsonFault>(&result);
    return fault == nullptr ? "" : fault->pointer + " " + fault->what;
}

TEST(V7Json, every_frame_is_restored_unchanged) {
    for (std::uint64_t seed = 0; seed < support::trials(3000); ++seed) {
        support::Random random{seed};
        const auto id = static_cast<std::uint8_t>(seed);
        const auto layouts = v7::layouts_of(id);
        const std::size_t usual = layouts.empty() ? 8u : layouts.front().fixed_size;
        Bytes data(random.one_in(2) ? usual : random.below(random.one_in(4) ? 256u : 30u));
        for (auto& byte : data) byte = random.of<std::uint8_t>({0, 1, 'a', 0xFF, random.byte()});
        const Bytes frame = v7_frame(random.byte(), id, data);
        const Json json = ano::v7_frame_to_json(v7::FrameView{frame}, {nullptr, ano::Encoding::automatic});
        const auto again = ano::v7_frame_from_json(Json::parse(json.dump()));
        ASSERT_TRUE(std::holds_alternative<Bytes>(again)) << json << ' ' << fault(json);
        EXPECT_EQ(std::get<Bytes>(again), frame) << json;
    }
}

TEST(V7Json, fields_of_a_whole_frame_are_enough) {
    for (const auto& vector : support::v7_vectors("valid")) {
        const auto frame = v7::frame_at(vector.v7);
        const Json json = ano::v7_frame_to_json(*frame);
        const bool has_fields = !v7::layouts_of(frame->id()).empty() && !ano::is_flexible(frame->id());
        EXPECT_EQ(json.contains("data"), !has_fields) << json;
    }
}

TEST(V7Json, flexible_messages_have_their_configured_fields) {
    ano::FlexibleField n, x;
    n.name = "n";
    x.name = "x";
    x.type = ano::Type::f32;
    const std::vector<ano::FlexibleSpec> specs{{.id = 0xF2, .fields = {n, x}}};
    const ano::FlexibleLayouts layouts{specs};
    const Bytes frame = support::hex("AAFFF20501000048422B85");
    const Json json = ano::v7_frame_to_json(v7::FrameView{frame}, {&layouts});
    EXPECT_EQ(json["fields"], (Json{{"n", 1}, {"x", 50.0}}));
    EXPECT_EQ(std::get<Bytes>(ano::v7_frame_from_json(json, {&layouts})), frame);
}

TEST(V7Json, faults_name_the_place) {
    EXPECT_EQ(fault({{"name", "euler"}, {"from", 5}}), "/from unknown key 'from'");
    EXPECT_EQ(fault({{"name", "euler"}, {"to", "hots"}}),
              "/to to: 'hots' is not an address from 0 to 255 (did you mean 'host'?)");
    EXPECT_EQ(fault({{"name", "device_info"}}).substr(0, 45), "/name version 7 has no message 'device_info'");
    EXPECT_EQ(fault({{"id", 0xF1}, {"data", std::string(512, '0')}}),
              " 256 bytes of DATA are more than the 255 a frame of version 7 can carry");
    EXPECT_EQ(fault({{"name", "ranging"}, {"fields", {{"dist", 5e9}}}}),
              "/fields/dist ranging dist: 5000000000.0 is out of range (u32, 0 to 4294967295 cm)");
}

}    // namespace
}    // namespace v7_json_tests
