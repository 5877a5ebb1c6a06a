// Interfaces that come, go and change, between two machines that a veth connects.
#include "bridged.hpp"

#include <algorithm>
#include <csignal>
#include <optional>

namespace networks_tests {
namespace {

using namespace ros2_tests;
using support::Bytes;

class Ros2Networks : public Bridged {
protected:
    /// A machine with a subscriber, at 10.77.0.2 on the interface `eth`; ours is 10.77.0.1.
    void join() { net.join(far, "eth", "10.77.0.1/24", "10.77.0.2/24"); }
    std::unique_ptr<Listener> far_listener() {
        const support::Inside inside{far};
        return std::make_unique<Listener>(std::vector<std::string>{"/fc/imu/data=Imu"}, "eth");
    }
    /// The time until it receives the next message.
    Seconds until_data(Listener& listener) {
        const std::size_t before = listener.count("/fc/imu/data");
        const auto since = Steady::now();
        EXPECT_TRUE(send_until(0x01, Bytes(13), [&] { return listener.count("/fc/imu/data") > before; })) << bridge->output();
        return Steady::now() - since;
    }
    std::ptrdiff_t log_lines() {
        const std::string& log = bridge->output();
        return std::count(log.begin(), log.end(), '\n');
    }
    void ends_at_once() {
        const auto since = Steady::now();
        bridge->signal(SIGTERM);
        EXPECT_EQ(bridge->wait(), 0) << bridge->output();
        RecordProperty("seconds_to_exit", std::to_string(Seconds{Steady::now() - since}.count()));
    }

    support::Namespace far;
};

TEST_F(Ros2Networks, an_interface_that_is_absent_at_the_start_is_waited_for) {
    start_gateway();
    start_bridge("{}", {"--interface", "eth"});
    ASSERT_TRUE(bridge->until_says("no address on eth; waiting for it")) << bridge->output();
    join();
    const auto listener = far_listener();
    until_data(*listener);
    ends_at_once();
}

TEST_F(Ros2Networks, another_address_reaches_subscribers_from_before_and_after) {
    join();
    start_gateway();
    start_bridge("{}", {"--interface", "eth"});
    const auto before = far_listener();
    until_data(*before);
    net.ip("address del 10.77.0.1/24 dev eth");
    net.ip("address add 10.77.0.9/24 dev eth");
    const Seconds old_one = until_data(*before);
    const auto after = far_listener();
    const Seconds new_one = until_data(*after);
    RecordProperty("seconds_old_subscriber", std::to_string(old_one.count()));
    RecordProperty("seconds_new_subscriber", std::to_string(new_one.count()));
    std::printf("after another address: data at the old subscriber after %.2f s, at a new one %.2f s after its start\n",
                old_one.count(), new_one.count());
    EXPECT_LT(log_lines(), 15) << bridge->output();
    ends_at_once();
}

TEST_F(Ros2Networks, an_address_of_another_interface_reaches_its_subscribers) {
    start_gateway();
    start_bridge("{}", {});
    ASSERT_TRUE(until_connected()) << bridge->output();
    join();
    const auto listener = far_listener();
    until_data(*listener);
    ends_at_once();
}

TEST_F(Ros2Networks, an_interface_that_is_removed_while_messages_are_published_may_return) {
    join();
    start_gateway();
    start_bridge("{}", {"--interface", "eth"});
    until_data(*far_listener());
    for (int round = 0; round < 3; ++round) {
        net.ip("link del eth");
        const auto until = Steady::now() + 2s;
        support::wait_until([&] { return Steady::now() >= until; }, 12s,
                            [&] {
                                send(0x01, Bytes(13));
                                std::this_thread::sleep_for(10ms);
                            });
        join();
        const auto listener = far_listener();
        until_data(*listener);
    }
    EXPECT_LT(log_lines(), 60) << bridge->output();
    net.ip("link del eth");
    ends_at_once();
}

TEST_F(Ros2Networks, a_cable_that_was_off_for_5_s_or_15_s) {
    join();
    start_gateway();
    start_bridge("{}", {"--interface", "eth"});
    const auto listener = far_listener();
    until_data(*listener);
    for (const auto off : {5s, 15s}) {    // within and beyond the time after which a silent participant is forgotten
        far.ip("link set eth down");
        const auto until = Steady::now() + off;
        support::wait_until([&] { return Steady::now() >= until; }, off + 10s,
                            [&] {
                                send(0x01, Bytes(13));
                                std::this_thread::sleep_for(20ms);
                            });
        far.ip("link set eth up");
        const Seconds back = until_data(*listener);
        std::printf("cable off for %d s: data %.2f s after it is back\n", static_cast<int>(off.count()), back.count());
    }
    EXPECT_LT(log_lines(), 15) << bridge->output();
    ends_at_once();
}

}    // namespace
}    // namespace networks_tests
