#include <anoctl/anoctl.hpp>
#include <anoctl/gateway.hpp>
#include <anoctl/text/gateway_json.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

namespace anoctl::gateway_json_tests {
namespace {

TEST(GatewayJson, missing_values_and_values_of_another_type_are_empty) {
    const ano::Json answer = parse_answer(
        R"({"text": "a\u001b[2J", "number": 7, "large": "18446744073709551615", "null": null, "list": ["a", 1, "b"]})");
    EXPECT_EQ(text_at(answer, "text"), "a?[2J");
    EXPECT_EQ(text_at(answer, "number"), "7");
    EXPECT_EQ(text_at(answer, "null"), "");
    EXPECT_EQ(text_at(answer, "none"), "");
    EXPECT_EQ(text_at(at(answer, "list"), "none"), "");
    EXPECT_EQ(number_at(answer, "number"), 7);
    EXPECT_EQ(number_at(answer, "large"), 18446744073709551615.0);
    EXPECT_EQ(number_at(answer, "none"), 0);
    EXPECT_EQ(names_at(answer, "list"), "a, b");
    EXPECT_TRUE(at(answer, "none").empty());
    EXPECT_TRUE(at(answer, "number").empty());
    EXPECT_THROW(parse_answer("<html>"), Failure);
}

TEST(GatewayJson, counters_that_are_not_zero_are_listed) {
    const ano::Json link = parse_answer(R"({"bad_check": 3, "stale": 0, "skipped_bytes": "9007199254740993"})");
    EXPECT_EQ(not_zero(link, {"stale", "skipped_bytes", "bad_check", "none"}),
              (std::vector<std::string>{"skipped_bytes 9007199254740993", "bad_check 3"}));
    EXPECT_EQ(drop_causes(false).front(), "superseded");
    EXPECT_EQ(causes_in().front(), "bytes_in");
    EXPECT_EQ(causes_out().front(), "bytes_out");
}

TEST(GatewayJson, frames_without_a_route_are_no_loss_on_a_replay_or_without_a_host) {
    const auto counts_no_route = [](const std::string& link) {
        const auto& causes = drop_causes(is_alone(parse_answer(link)));
        return std::count(causes.begin(), causes.end(), "no_route") == 1;
    };
    EXPECT_TRUE(counts_no_route(R"({"hint_id": "silent"})"));
    EXPECT_FALSE(counts_no_route(R"({"hint_id": "no_host_takes"})"));
    EXPECT_FALSE(counts_no_route(R"({"hint_id": "", "replayed": [{"address": "0xDC"}]})"));
    EXPECT_TRUE(counts_no_route("[]"));
}

TEST(GatewayJson, recordings_and_their_errors_are_listed_in_lines) {
    using Lines = std::vector<std::string>;
    const auto lines_of = [](const std::string& text) { return recording_lines(parse_answer(text)); };
    EXPECT_EQ(lines_of("{}"), Lines{});
    EXPECT_EQ(lines_of(R"({"running": [], "keep_last": null})"), Lines{});
    EXPECT_EQ(
        lines_of(R"({"running": [{"name": "flight", "file": "flight-2.mcap", "frames": 7, "not_written": 0, "error": ""}]})"),
        Lines{"recording: flight-2.mcap: 7 frames"});
    EXPECT_EQ(
        lines_of(R"({"running": [{"name": "flight", "file": "flight-11.mcap", "files": 11, "frames": 27775, "error": ""}]})"),
        Lines{"recording: flight: 27775 frames in 11 files"});
    EXPECT_EQ(lines_of(R"({"running": [{"name": "flight", "file": "flight.mcap", "files": 1, "frames": 1, "error": ""}]})"),
              Lines{"recording: flight.mcap: 1 frame"});
    EXPECT_EQ(
        lines_of(
            R"({"running": [{"name": "flight", "file": "", "frames": 0, "not_written": 12, "error": "/a: Permission denied"}],
                           "keep_last": {"error": ""}})"),
        Lines{"recording: flight: /a: Permission denied; not written: 12"});
    EXPECT_EQ(lines_of(R"({"keep_last": {"error": "last.mcap is not saved: Input/output error"}})"),
              Lines{"recording: cannot save the latest frames: last.mcap is not saved: Input/output error"});
}

TEST(GatewayJson, a_recording_whose_times_are_of_two_clocks_has_no_length) {
    const auto length = [](const std::string& begun, const std::string& time) {
        return length_of_recording(parse_answer("{\"begun\": " + begun + ", \"time\": " + time + "}"));
    };
    EXPECT_EQ(length("1763898044.5", "1763898050"), 5.5);
    EXPECT_EQ(length("1763898044", "1763898044"), 0);
    EXPECT_EQ(length("1577836800", "1577836801"), 1) << "2020";
    EXPECT_EQ(length("1577836799", "1577836801"), std::nullopt) << "the clock was not set";
    EXPECT_EQ(length("0", "100"), std::nullopt);
    EXPECT_EQ(length("1763898044", "1763898043"), std::nullopt) << "it was set back";
    EXPECT_EQ(length("1700000000", "1731622400"), 31'622'400) << "a year";
    EXPECT_EQ(length("1700000000", "1731622401"), std::nullopt);
    EXPECT_EQ(length_of_recording(parse_answer("{}")), std::nullopt);
    EXPECT_EQ(length_of_recording(parse_answer(R"({"begun": 1763898044, "time": 1763898050, "seconds": 0.5})")), 0.5);
    EXPECT_EQ(length_of_recording(parse_answer(R"({"begun": 1763898044, "time": 1763898050, "seconds": null})")), std::nullopt);
}

TEST(GatewayJson, long_lists_are_wrapped_onto_several_lines) {
    EXPECT_EQ(list_text("in: ", {}), "in: ");
    EXPECT_EQ(list_text("in: ", {"a 1", "b 2"}), "in: a 1, b 2");
    const std::string item(30, 'x');
    EXPECT_EQ(list_text("in: ", {item, item, item}), "in: " + item + ", " + item + ",\n    " + item);
    EXPECT_EQ(list_text("in: ", {std::string(100, 'x')}), "in: " + std::string(100, 'x')) << "there is no better place for it";
}

TEST(GatewayJson, text_is_percent_encoded_for_a_request_target) {
    EXPECT_EQ(percent_encoded("0xDC-a_b.c~"), "0xDC-a_b.c~");
    EXPECT_EQ(percent_encoded("flight controller/%?&#\xE5"), "flight%20controller%2F%25%3F%26%23%E5");
}

TEST(GatewayJson, an_error_response_is_reported_with_its_text) {
    anogate::http::Answer answer;
    answer.status = 404;
    answer.body = R"({"error": "there is nothing", "what": "unknown"})";
    EXPECT_EQ(format_failure(answer), "there is nothing");
    for (const char* body : {"", "<html>", "[]", "{}", R"({"error": 7})"}) {
        answer.body = body;
        EXPECT_EQ(format_failure(answer), "the gateway returned HTTP status 404") << body;
    }
}

}    // namespace
}    // namespace anoctl::gateway_json_tests
