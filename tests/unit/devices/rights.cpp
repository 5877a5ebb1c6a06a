// Places and turns at devices: ordered by right, then by client.
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

namespace rights_tests {
namespace {

using namespace support;
using anogate::http::Access;
using Asked = std::shared_ptr<std::optional<SimulatedNet::Answer>>;

struct ConnectionCounts {
    SimulatedNet net;
    FakeDevice& fake = net.add();

    ConnectionCounts() {
        fake.make_parameters(300);
        fake.commands = {{{1, 0, 1}, {3}, "TAKE_OFF", "height"}, {{1, 0, 2}, {}, "LAND", ""}};
    }
    Asked as(Access access, const std::string& peer, const std::string& method, const std::string& target) {
        net.access = access;
        net.peer = peer;
        return net.asked(method, target);
    }
    /// Each client reads something else, so that they do not share a job.
    std::vector<Asked> viewers(int count) {
        std::vector<Asked> all;
        for (int i = 0; i < count; ++i) {
            std::string names = "?name=PAR_" + std::to_string(i);
            for (int p = 0; p < 290; ++p) names += "&name=PAR_" + std::to_string(p);
            all.push_back(as(Access::view, "10.0.0." + std::to_string(i), "GET", "/devices/0xDC/parameters" + names));
        }
        return all;
    }
    Duration time_of_land() {
        const TimePoint begin = net.time;
        const Asked land = as(Access::control, "10.0.1.1", "POST", "/devices/0xDC/commands/LAND");
        EXPECT_TRUE(net.until([&] { return land->has_value(); }));
        EXPECT_EQ((*land)->status, 200u) << (*land)->json;
        return net.time - begin;
    }
};
struct Rights : testing::Test, ConnectionCounts {};

TEST_F(Rights, twenty_two_viewers_that_read_block_no_command) {
    const auto reading = viewers(22);
    for (int i = 0; i < 20; ++i) time_of_land();
    EXPECT_GT(std::count_if(reading.begin(), reading.end(), [](const auto& one) { return !one->has_value(); }), 0);
}

// Its first call reads the descriptions of commands, with questions like those of the viewers.
TEST_F(Rights, eight_viewers_that_read_delay_no_command) {
    ConnectionCounts alone;
    const Duration without = alone.time_of_land();
    const auto reading = viewers(8);
    net.pass(300ms);
    ASSERT_FALSE(reading.back()->has_value());
    EXPECT_LE(time_of_land(), without + without / 4) << "of those on their way before, the last answer is waited for";
}

TEST_F(Rights, viewers_continue_reading_after_a_command) {
    const auto reading = viewers(4);
    net.pass(100ms);
    time_of_land();
    ASSERT_TRUE(
        net.until([&] { return std::all_of(reading.begin(), reading.end(), [](const auto& r) { return r->has_value(); }); }));
    for (const auto& one : reading) EXPECT_EQ((*one)->status, 200u) << (*one)->json;
}

// A lost question is equal to one for the command: it must be sent again, otherwise the command would wait for it for ever.
TEST_F(Rights, a_lost_request_of_a_viewer_does_not_block_a_command) {
    fake.deaf = true;
    const Asked reads = as(Access::view, "10.0.0.1", "GET", "/devices/0xDC/commands");
    net.pass(20ms);
    const Asked land = as(Access::control, "10.0.1.1", "POST", "/devices/0xDC/commands/LAND");
    net.pass(20ms);
    fake.deaf = false;
    ASSERT_TRUE(net.until([&] { return land->has_value(); }, 10s));
    EXPECT_EQ((*land)->status, 200u) << (*land)->json;
    EXPECT_TRUE(net.until([&] { return reads->has_value(); }, 10s));
}

TEST_F(Rights, one_viewer_cannot_use_up_the_quota_of_the_others) {
    fake.deaf = true;
    std::vector<Asked> greedy;
    for (int i = 0; i < 100; ++i)
        greedy.push_back(as(Access::view, "10.0.0.1", "GET", "/devices/0xDC/parameters/PAR_" + std::to_string(i)));
    EXPECT_TRUE(greedy.back()->has_value()) << "refused";
    const Asked other = as(Access::view, "10.0.0.2", "GET", "/devices/0xDC/parameters/PAR_0");
    EXPECT_FALSE(other->has_value());
}

TEST_F(Rights, viewers_that_abandon_their_jobs_do_not_use_up_the_quota) {
    fake.deaf = true;
    for (int i = 0; i < 100; ++i) {
        as(Access::view, "10.0.0." + std::to_string(i), "GET", "/devices/0xDC/parameters/PAR_" + std::to_string(i));
        net.leave();
    }
    const Asked own = as(Access::control, "10.0.1.1", "GET", "/devices/0xDC/parameters/PAR_0");
    EXPECT_FALSE(own->has_value());
}

// Questions of a program before a command, such as the types of its values, have the same right as that command.
TEST_F(Rights, readers_with_the_same_right_do_not_block_requests_that_precede_a_command) {
    for (const bool is_known : {true, false}) {
        ConnectionCounts all;
        if (is_known) all.as(Access::control, "10.0.1.2", "GET", "/devices/0xDC/commands"), all.net.pass(1s);
        all.fake.deaf = true;
        std::vector<Asked> readers;
        for (int i = 0; i < 30; ++i)
            readers.push_back(all.as(Access::control, "10.0.0." + std::to_string(i), "GET",
                                     "/devices/0xDC/parameters/PAR_" + std::to_string(i)));
        EXPECT_TRUE(readers.back()->has_value()) << "refused";
        all.net.pass(100ms);
        all.fake.deaf = !is_known;
        const auto is_taken = [&](const std::string& method, const std::string& target) {
            const Asked asked = all.as(Access::control, "10.0.1.1", method, target);
            all.net.pass(100ms);
            return !asked->has_value() || (*asked)->status == 200;
        };
        EXPECT_FALSE(is_taken("GET", "/devices/0xDC/commands?known")) << "it only reads";
        EXPECT_TRUE(is_taken("GET", "/devices/0xDC/commands?known&to_act"));
        EXPECT_TRUE(is_taken("GET", "/devices/0xDC/commands?to_act"));
        EXPECT_TRUE(is_taken("POST", "/devices/scan?to_act"));
    }
}

TEST_F(Rights, viewers_get_no_larger_quota_by_adding_to_act) {
    fake.deaf = true;
    std::vector<Asked> all;
    for (int i = 0; i < 100; ++i)
        all.push_back(as(Access::view, "10.0.0." + std::to_string(i), "GET",
                         "/devices/0xDC/parameters/PAR_" + std::to_string(i) + (i % 2 == 0 ? "?to_act" : "")));
    EXPECT_EQ(std::count_if(all.begin(), all.end(), [](const auto& one) { return !one->has_value(); }), 8);
}

}    // namespace
}    // namespace rights_tests
