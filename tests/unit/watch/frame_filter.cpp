#include <watch/frame_filter.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

namespace frame_filter_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::frame;

namespace {

constexpr std::string_view links[] = {"fc", "ground", "control"};
constexpr ano::TimePoint start{1h};

FrameQuery read(const std::vector<http::Field>& query) {
    auto parsed = parse_frame_query(query, links);
    const auto* wrong = std::get_if<std::string>(&parsed);
    EXPECT_EQ(wrong ? *wrong : "", "");
    return wrong ? FrameQuery{} : std::get<FrameQuery>(std::move(parsed));
}

std::string fault(const http::Field& field) {
    const auto parsed = parse_frame_query(std::vector<http::Field>{field}, links);
    const auto* wrong = std::get_if<std::string>(&parsed);
    return wrong ? *wrong : "nothing is wrong";
}

bool takes(FrameFilter& filter, const support::Bytes& bytes, Direction direction = Direction::in, std::uint8_t link = 0) {
    return filter.takes(direction, link, ano::FrameView{bytes}, start);
}

const auto euler = frame(0xDC, 0xFE, 0x03, {1});
const auto inertial = frame(0xDC, 0xFE, 0x01, {1});
const auto command = frame(0xFE, 0xDC, 0xE0, {1});

TEST(FrameFilter, accepts_everything_without_a_condition) {
    FrameFilter filter{read({}).filter};
    for (const Direction direction : {Direction::in, Direction::out, Direction::dropped})
        for (const std::uint8_t link : {std::uint8_t{0}, std::uint8_t{63}}) EXPECT_TRUE(takes(filter, euler, direction, link));
    EXPECT_EQ(read({}).format, FrameFormat::json);
    EXPECT_EQ(read({{"format", "binary"}}).format, FrameFormat::binary);
}

TEST(FrameFilter, accepts_frames_that_match_all_conditions) {
    FrameFilter by_id{read({{"id", "euler,0x20-0x2F"}, {"id", "0x01"}}).filter};
    EXPECT_TRUE(takes(by_id, euler));
    EXPECT_TRUE(takes(by_id, inertial));
    EXPECT_TRUE(takes(by_id, frame(1, 2, 0x2F)));
    EXPECT_FALSE(takes(by_id, command));
    FrameFilter by_class{read({{"id", "telemetry"}}).filter};
    EXPECT_TRUE(takes(by_class, euler));
    EXPECT_FALSE(takes(by_class, command));
    FrameFilter by_address{read({{"from", "0xDC"}, {"to", "host,30-40"}}).filter};
    EXPECT_TRUE(takes(by_address, euler));
    EXPECT_TRUE(takes(by_address, frame(220, 31, 3)));
    EXPECT_FALSE(takes(by_address, frame(220, 41, 3)));
    EXPECT_FALSE(takes(by_address, command));
}

TEST(FrameFilter, accepts_the_named_directions_and_links) {
    FrameFilter way{read({{"direction", "in,dropped"}}).filter};
    EXPECT_TRUE(takes(way, euler, Direction::in));
    EXPECT_TRUE(takes(way, euler, Direction::dropped));
    EXPECT_FALSE(takes(way, euler, Direction::out));
    const FrameQuery query = read({{"link", "fc,ground,fc"}});
    EXPECT_EQ(query.filter.links, (std::vector<std::string>{"fc", "ground"}));
    FrameFilter link{query.filter};
    link.set_links(LinkSet{LinkId{1}});
    EXPECT_TRUE(takes(link, euler, Direction::in, 1));
    EXPECT_FALSE(takes(link, euler, Direction::in, 0));
}

TEST(FrameFilter, a_limit_applies_to_one_id_in_each_direction) {
    FrameFilter filter{read({{"limit.euler", "10"}}).filter};
    const auto at = [&](ano::Duration time, const support::Bytes& bytes, Direction direction) {
        return filter.takes(direction, 0, ano::FrameView{bytes}, start + time);
    };
    EXPECT_TRUE(at(0ms, euler, Direction::in));
    EXPECT_TRUE(at(0ms, euler, Direction::out));
    EXPECT_FALSE(at(99ms, euler, Direction::in));
    EXPECT_TRUE(at(99ms, inertial, Direction::in));
    EXPECT_TRUE(at(100ms, euler, Direction::in));
}

TEST(FrameFilter, batch_sets_how_long_frames_wait_for_each_other_and_all_are_accepted) {
    EXPECT_EQ(read({}).filter.batch, 10ms);
    EXPECT_EQ(read({{"batch", "1ms"}}).filter.batch, 1ms);
    EXPECT_EQ(read({{"batch", "1s"}}).filter.batch, 1s);
    EXPECT_NE(read({{"batch", "40ms"}}).filter, FrameFilterSettings{}) << "another stream";
    FrameFilter filter{read({{"batch", "40ms"}}).filter};
    EXPECT_TRUE(takes(filter, euler, Direction::dropped, 63));
}

TEST(FrameFilter, frames_of_sources_elsewhere_can_be_omitted_and_do_not_use_up_a_limit) {
    EXPECT_TRUE(read({{"elsewhere", "yes"}}).filter.elsewhere);
    EXPECT_TRUE(read({}).filter.elsewhere);
    EXPECT_EQ(fault({"elsewhere", "nope"}), "elsewhere='nope' is neither yes nor no");
    const auto take = [](FrameFilter& filter, bool is_elsewhere) {
        return filter.takes(Direction::in, 0, ano::FrameView{euler}, start, is_elsewhere);
    };
    FrameFilter all{read({}).filter};
    EXPECT_TRUE(take(all, true));
    FrameFilter believed{read({{"elsewhere", "no"}, {"samples", "1"}}).filter};
    EXPECT_FALSE(take(believed, true));
    EXPECT_TRUE(take(believed, false));
    FrameFilter whole{read({{"elsewhere", "no"}}).filter};
    EXPECT_FALSE(take(whole, true));
}

TEST(FrameFilter, samples_count_separately_for_each_link_sender_and_id) {
    FrameFilterSettings settings;
    settings.samples = 2;
    FrameFilter filter{settings};
    const auto at = [&](ano::Duration time, const support::Bytes& bytes, std::uint8_t link = 0) {
        return filter.takes(Direction::in, link, ano::FrameView{bytes}, start + time);
    };
    EXPECT_TRUE(at(0ms, euler));
    EXPECT_TRUE(at(1ms, inertial));
    EXPECT_TRUE(at(2ms, euler, 1));
    EXPECT_TRUE(at(3ms, frame(0xDD, 0xFE, 0x03, {1})));
    EXPECT_FALSE(at(499ms, euler));
    EXPECT_FALSE(at(500ms, inertial));
    EXPECT_TRUE(at(500ms, euler));
    EXPECT_FALSE(at(999ms, euler));
}

TEST(FrameFilter, samples_of_a_slow_device_are_not_crowded_out_by_a_fast_one) {
    const FrameFilterSettings settings = read({{"samples", "10"}, {"direction", "in"}}).filter;
    EXPECT_EQ(settings.samples, 10u);
    FrameFilter filter{settings};
    const support::Bytes slow = frame(0xDD, 0xFE, 0x03, {1});
    unsigned of_slow = 0, of_fast = 0;
    for (unsigned ms = 0; ms < 1000; ++ms) {
        of_fast += filter.takes(Direction::in, 0, ano::FrameView{euler}, start + std::chrono::milliseconds{ms});
        if (ms % 200 == 0) of_slow += filter.takes(Direction::in, 0, ano::FrameView{slow}, start + std::chrono::milliseconds{ms});
    }
    EXPECT_EQ(of_fast, 10u);
    EXPECT_EQ(of_slow, 5u);
    EXPECT_EQ(fault({"samples", "0"}), "samples='0' is not a number from 1 to 100");
    EXPECT_EQ(fault({"samples", "101"}), "samples='101' is not a number from 1 to 100");
    EXPECT_EQ(fault({"samples", "x"}), "samples='x' is not a number from 1 to 100");
}

TEST(FrameFilter, invalid_filters_are_rejected_with_an_explanation) {
    EXPECT_EQ(fault({"form", "0xDC"}),
              "unknown filter 'form' (did you mean 'from'?); filters are from, to, id, link, direction, limit.ID, samples, "
              "elsewhere, batch, format and raw");
    EXPECT_EQ(fault({"id", "eular"}),
              "id='eular' is not an id, range of ids, message or class of messages (did you mean 'euler'?)");
    EXPECT_EQ(fault({"id", ""}), "id= has no value: omit it");
    EXPECT_EQ(fault({"link", "grund"}), "there is no link 'grund' (did you mean 'ground'?); use one of fc, ground, control");
    EXPECT_EQ(fault({"direction", "inn"}), "direction='inn' is not in, out or dropped (did you mean 'in'?)");
    for (const char* time : {"0ms", "2s", "1001ms", "-5ms", "40", "soon"})
        EXPECT_EQ(fault({"batch", time}), std::string{"batch='"} + time + "' is not a time from 1ms to 1s");
    EXPECT_EQ(fault({"format", "xml"}), "format='xml' is neither json nor binary");
    EXPECT_NE(fault({"from", "DC"}).find("did you mean '0xDC'?"), std::string::npos) << fault({"from", "DC"});
    EXPECT_NE(fault({"from", "256"}), "nothing is wrong");
    EXPECT_NE(fault({"to", "40-30"}), "nothing is wrong");
    EXPECT_NE(fault({"from", "1,,2"}), "nothing is wrong");
    EXPECT_NE(fault({"limit.euler", "0"}), "nothing is wrong");
    EXPECT_NE(fault({"limit.", "1"}), "nothing is wrong");
    EXPECT_NE(fault({"limit.telemetry", "1"}).find("several"), std::string::npos);
    const auto twice = parse_frame_query(std::vector<http::Field>{{"limit.euler", "1"}, {"limit.0x03", "2"}}, links);
    EXPECT_EQ(std::get<std::string>(twice), "0x03 already has a limit");
}

}    // namespace
}    // namespace frame_filter_tests
