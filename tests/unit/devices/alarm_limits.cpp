// Alarm limits: rejected ones, and their storage over a restart.
#include <devices/alarm_limits.hpp>
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

namespace alarm_limits_tests {
namespace {

using namespace support;
using anogate::AlarmLimits;
using Json = nlohmann::ordered_json;

std::string fault(const std::string& row) {
    const auto list = AlarmLimits::parse(Json::parse(R"({"limits": [)" + row + "]}"));
    const auto* const wrong = std::get_if<std::string>(&list);
    return wrong != nullptr ? *wrong : "";
}

TEST(AlarmLimits, report_their_errors) {
    EXPECT_EQ(fault(R"({"field": "power.voltage", "side": "below", "amber": 3.6, "red": 3.4, "cells": 4, "for_s": 2})"), "");
    EXPECT_EQ(fault(R"({"field": "power.voltage", "side": "below", "amber": 3.4, "red": 3.6})"),
              "limit 1: 'red' must be beyond 'amber'");
    EXPECT_EQ(fault(R"({"field": "power.voltage", "side": "above", "amber": 3.4, "red": 3.6})"), "");
    EXPECT_EQ(fault(R"({"field": "power.voltage", "side": "below"})"), "limit 1: 'amber' or 'red' is needed");
    EXPECT_EQ(fault(R"({"field": "power.voltage", "side": "below", "red": "3"})"), "limit 1: 'amber' and 'red' must be numbers");
    EXPECT_EQ(fault(R"({"field": "power", "side": "below", "red": 3})"),
              "limit 1: 'field' must be a message and its field, such as 'power.voltage'");
    EXPECT_NE(fault(R"({"field": "<b>.x", "side": "below", "red": 3})"), "");
    EXPECT_EQ(fault(R"({"field": "a.b", "side": "left", "red": 3})"), "limit 1: 'side' must be 'below' or 'above'");
    EXPECT_EQ(fault(R"({"field": "a.b", "side": "above", "red": 3, "cells": 0})"),
              "limit 1: 'cells' must be a number from 1 to 32");
    EXPECT_EQ(fault(R"({"field": "a.b", "side": "above", "red": 3, "for_s": 61})"),
              "limit 1: 'for_s' must be seconds from 0 to 60");
    EXPECT_EQ(fault(R"({"field": "a.b", "side": "above", "redd": 3})"), "limit 1: unknown key 'redd' (did you mean 'red'?)");
    EXPECT_EQ(fault(R"({"field": "a.b", "side": "above", "red": 3}, {"field": "a.b", "side": "above", "red": 4})"),
              "a.b has two limits above it");
    EXPECT_EQ(fault("1"), "limit 1: must be an object");
    std::string many = "1";
    for (int i = 0; i < 32; ++i) many += ", 1";
    EXPECT_EQ(fault(many), "there are 33 limits; at most 32 are kept");
    EXPECT_TRUE(std::holds_alternative<std::string>(AlarmLimits::parse(Json::parse("[]"))));
}

TEST(AlarmLimits, of_a_field_that_does_not_exist_are_refused_with_the_nearest_names) {
    SimulatedNet net;
    const auto put = [&](const std::string& field) {
        const auto answer = net.ask("PUT", "/devices/0xDC/limits",
                                    R"({"limits":[{"field":")" + field + R"(","side":"below","red":3.4}]})");
        return std::to_string(answer.status) + " " + (answer.status == 200 ? "" : answer.json.at("error").get<std::string>());
    };
    EXPECT_EQ(put("power.voltage"), "200 ");
    EXPECT_EQ(put("nope.x"), "422 no message has the numeric field 'nope.x'; GET /messages lists the messages and their fields");
    const std::string meant =
        "422 no message has the numeric field 'power.voltag' (did you mean 'power.voltage'?); there are power.voltage, ";
    EXPECT_EQ(put("power.voltag").substr(0, meant.size()), meant);
    const std::string listed = "422 no message has the numeric field 'power.x'; there are power.voltage, power.current, ";
    EXPECT_EQ(put("power.x").substr(0, listed.size()), listed);
    EXPECT_NE(put("powr.voltage").find("(did you mean 'power.voltage'?)"), std::string::npos) << put("powr.voltage");
    EXPECT_EQ(put("log.str").substr(0, 3), "422") << "a text";
    EXPECT_EQ(put("flexible1.percent").substr(0, 3), "422") << "it has no layout";
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/limits").json.at("limits").size(), 1u);
}

TEST(AlarmLimits, flexible_fields_exist_where_a_layout_has_them) {
    ano::FlexibleLayouts layouts;
    ano::FlexibleSpec spec;
    spec.id = 0xF1;
    spec.source = 0xDC;
    spec.fields = {{"percent", ano::Type::u8, 1, "%", 1}, {"many", ano::Type::u8, 1, "", 4}};
    layouts.add(spec);
    const auto fault = [&](const std::string& field, std::uint8_t source) {
        anogate::AlarmLimit limit;
        limit.field = field;
        return AlarmLimits::unknown_field({limit}, source, layouts);
    };
    EXPECT_EQ(fault("flexible1.percent", 0xDC), "");
    EXPECT_NE(fault("flexible1.percent", 0xDD), "");
    EXPECT_EQ(fault("flexible1.many", 0xDC), "no message has the numeric field 'flexible1.many'; there are flexible1.percent");
}

TEST(AlarmLimits, are_kept_in_a_file_of_the_device) {
    EXPECT_EQ(anogate::limits_file(0xDC), "limits-0xDC.json");
    EXPECT_EQ(anogate::address_of_limits_file("limits-0xDC.json"), 0xDC);
    for (const char* other :
         {"limits-0xdc.json", "limits-0xFF.json", "limits-0x.json", "limits-0xDC.json.1", "firmware-0xDC.json"})
        EXPECT_EQ(anogate::address_of_limits_file(other), std::nullopt) << other;
    SimulatedNet net;
    const std::string body = R"({"limits":[{"field":"power.voltage","side":"below","red":3.4,"cells":4}]})";
    const auto put = net.ask("PUT", "/devices/0xDC/limits", body);
    EXPECT_EQ(put.status, 200u);
    EXPECT_EQ(put.json.at("kept"), true);
    ASSERT_TRUE(net.kept.contains("limits-0xDC.json"));
    SimulatedNet after;
    EXPECT_EQ(after.service.remember_limits(0xDC, net.kept.at("limits-0xDC.json")), "");
    EXPECT_EQ(after.ask("GET", "/devices/0xDC/limits").json, net.ask("GET", "/devices/0xDC/limits").json);
    EXPECT_NE(after.service.remember_limits(0xDD, "{\"limits\": 1}"), "");
    EXPECT_NE(after.service.remember_limits(0xDD, std::string(5000, '[')), "");
    net.ask("PUT", "/devices/0xDC/limits", R"({"limits":[]})");
    EXPECT_FALSE(net.kept.contains("limits-0xDC.json"));
}

}    // namespace
}    // namespace alarm_limits_tests
