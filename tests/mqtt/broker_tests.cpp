// The broker's thread with a real mosquitto.
#include "mosquitto.hpp"

#include <support/namespaces.hpp>

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>

#include <thread>

namespace broker_tests {
namespace {

using namespace anogate;
using namespace mqtt_tests;

class MqttBroker : public testing::Test {
protected:
    void SetUp() override { ANOGATE_NEEDS_MOSQUITTO(); }
};

TEST_F(MqttBroker, publishes_with_properties_and_reports_acknowledgements) {
    Mosquitto mosquitto;
    Client reader{mosquitto.port(), "reader", {{"t/#", 1}}}, writer{mosquitto.port(), "writer"};
    EXPECT_EQ(writer.window(), 20u) << "max_inflight_messages of mosquitto";
    std::this_thread::sleep_for(
        100ms);    // until the subscription is active; the next message would be unread, which is tested below
    ASSERT_TRUE(writer.broker().publish({.id = 7,
                                         .topic = "t/a",
                                         .payload = std::string("x\0y", 3),
                                         .expiry_s = 60,
                                         .correlation = std::string("c\0", 2),
                                         .content_type = "application/json"}));
    ASSERT_TRUE(reader.until_messages(1));
    const BrokerMessage message = reader.messages()[0];
    EXPECT_EQ(message.topic, "t/a");
    EXPECT_EQ(message.payload, std::string("x\0y", 3));
    EXPECT_EQ(message.correlation, std::string("c\0", 2));
    ASSERT_TRUE(message.expiry_s);
    EXPECT_LE(*message.expiry_s, 60u);
    EXPECT_FALSE(message.is_retained);
    ASSERT_TRUE(writer.until_answers(1));
    EXPECT_EQ(writer.answers()[0], (Answer{7, 0}));
    writer.broker().publish({.id = 8, .topic = "nobody/reads", .payload = "x"});
    ASSERT_TRUE(writer.until_answers(2));
    EXPECT_EQ(writer.answers()[1], (Answer{8, 0x10}));
    writer.broker().publish({.id = 9, .topic = "not/#/valid", .payload = "x"});
    ASSERT_TRUE(writer.until_answers(3));
    EXPECT_GE(writer.answers()[2].reason, 0x80);
}

TEST_F(MqttBroker, many_publications_are_acknowledged_each_once) {
    Mosquitto mosquitto;
    Client writer{mosquitto.port(), "writer"};
    std::uint64_t sent = 0;
    ASSERT_TRUE(support::wait_until([&] {
        while (sent < 2000 && writer.broker().publish({.id = sent + 1, .topic = "t", .payload = std::string(100, 'x')})) ++sent;
        return sent == 2000;
    }));
    ASSERT_TRUE(writer.until_answers(2000));
    auto answers = writer.answers();
    std::sort(answers.begin(), answers.end(), [](const Answer& a, const Answer& b) { return a.id < b.id; });
    for (std::uint64_t i = 0; i < 2000; ++i) ASSERT_EQ(answers[i].id, i + 1);
}

TEST_F(MqttBroker, connects_again_after_the_broker_was_killed) {
    Mosquitto mosquitto;
    Client client{mosquitto.port(), "c"};
    mosquitto.kill();
    ASSERT_TRUE(client.until([&] { return true; }));
    ASSERT_TRUE(support::wait_until([&] { return client.faults().size() == 1; }));
    mosquitto.start();
    ASSERT_TRUE(client.until_connected(2));
    EXPECT_EQ(client.faults().size(), 1u) << "one line for an outage";
}

TEST_F(MqttBroker, a_will_is_published_after_a_lost_connection_and_not_after_an_orderly_end) {
    Mosquitto mosquitto;
    Client reader{mosquitto.port(), "reader", {{"will", 1}}};
    BrokerSettings settings = Client::settings_of(mosquitto.port(), "c");
    settings.will_topic = "will";
    {
        Client orderly{settings};
        ASSERT_TRUE(orderly.until_connected());
    }
    settings.client_id = "lost";
    const pid_t child = ::fork();
    if (child == 0) {
        Client lost{settings};
        lost.until_connected();
        ::raise(SIGKILL);
    }
    ASSERT_TRUE(reader.until_messages(1));
    EXPECT_EQ(reader.payloads("will"), std::vector<std::string>{"will 1"});
    int status = 0;
    ::waitpid(child, &status, 0);
}

TEST_F(MqttBroker, denied_topics_are_refused_and_nothing_of_others_is_delivered) {
    support::TempDir dir;
    ASSERT_EQ(support::run("mosquitto_passwd -b -c " + dir / "passwords" + " a secret && mosquitto_passwd -b " +
                           dir / "passwords" + " b secret && chmod 600 " + dir / "passwords"),
              0);
    dir.write("password", "secret\n");
    Mosquitto mosquitto{"allow_anonymous false\npassword_file " + dir / "passwords" + "\nacl_file " +
                        dir.write("acl", "pattern readwrite anogate/v1/%u/#\n") + "\n"};
    const auto settings = [&](const std::string& user, const std::string& topic) {
        BrokerSettings one = Client::settings_of(mosquitto.port(), user, {{topic, 1}});
        one.username = user;
        one.password_file = dir / "password";
        return one;
    };
    Client a{settings("a", "anogate/v1/a/#")}, b{settings("b", "anogate/v1/a/#")};
    ASSERT_TRUE(a.until_connected());
    ASSERT_TRUE(b.until_connected());
    std::this_thread::sleep_for(100ms);    // until the subscriptions are active
    b.broker().publish({.id = 1, .topic = "anogate/v1/a/up/x/y", .payload = "forged"});
    ASSERT_TRUE(b.until_answers(1));
    EXPECT_EQ(b.answers()[0].reason, 0x87);
    a.broker().publish({.id = 1, .topic = "anogate/v1/a/up/x/y", .payload = "true"});
    ASSERT_TRUE(a.until_messages(1));
    EXPECT_EQ(a.messages()[0].payload, "true");
    std::this_thread::sleep_for(200ms);    // a message that does not come
    EXPECT_TRUE(b.messages().empty());
}

TEST_F(MqttBroker, uses_client_certificates_and_takes_renewed_ones_at_the_next_connection) {
    support::TempDir dir;
    Certificates certificates{dir};
    certificates.issue("server");
    certificates.issue("drone", 10);
    Mosquitto mosquitto{"cafile " + certificates / "ca.crt" + "\ncertfile " + certificates / "server.crt" + "\nkeyfile " +
                        certificates / "server.key" + "\nrequire_certificate true\nuse_identity_as_username true\n"};
    BrokerSettings settings = Client::settings_of(mosquitto.port(), "c", {{"t", 1}});
    settings.tls_ca = certificates / "ca.crt";
    Client without{settings};
    settings.client_id = "d";
    settings.tls_certificate = certificates / "drone.crt";
    settings.tls_key = certificates / "drone.key";
    Client drone{settings};
    ASSERT_TRUE(drone.until_connected());
    const auto life = certificate_life(settings.tls_certificate);
    ASSERT_TRUE(life);
    EXPECT_NEAR(static_cast<double>(life->end - life->begin), 10 * 86400, 10);
    certificates.issue("drone", 20);
    EXPECT_NE(certificate_life(settings.tls_certificate), life);
    drone.broker().reconnect();
    ASSERT_TRUE(drone.until_connected(2));
    const std::string large(100'000, 'x');    // more than one TLS record
    drone.broker().publish({.id = 1, .topic = "t", .payload = large});
    ASSERT_TRUE(drone.until_messages(1));
    EXPECT_EQ(drone.messages()[0].payload, large);
    EXPECT_FALSE(without.faults().empty());
    EXPECT_EQ(certificate_life(dir / "nothing"), std::nullopt);
}

// The attempt is given up after `patience`; publish() and stop() never wait for it.
void expect_no_answer(BrokerSettings settings) {
    settings.patience = 300ms;
    const auto begin = ano::Clock::now();
    Client client{settings};
    std::uint64_t queued = 0;
    while (client.broker().publish({.id = 1, .topic = "t"})) ++queued;
    EXPECT_EQ(queued, Broker::max_queued);
    EXPECT_LT(ano::Clock::now() - begin, 5s);
    ASSERT_TRUE(support::wait_until([&] {
        client.broker().check(ano::Clock::now());
        return !client.faults().empty();
    }));
    EXPECT_EQ(client.faults()[0], "no answer");
}

TEST_F(MqttBroker, a_broker_behind_a_network_that_drops_everything_is_given_up) {
    ANOGATE_NEEDS_NAMESPACES();
    const NetworkThatDrops net;
    BrokerSettings settings = Client::settings_of(1883, "c");
    settings.host = "10.9.0.2";
    expect_no_answer(settings);
}

TEST_F(MqttBroker, a_peer_that_accepts_and_never_speaks_is_given_up) {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), size), 0);
    ASSERT_EQ(::listen(fd, 100), 0);
    ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
    BrokerSettings settings = Client::settings_of(ntohs(address.sin_port), "c");
    expect_no_answer(settings);
    support::TempDir dir;
    const Certificates certificates{dir};
    settings.tls_ca = certificates / "ca.crt";
    expect_no_answer(settings);
    ::close(fd);
}

TEST_F(MqttBroker, a_connection_that_is_cut_is_noticed_within_twice_the_keep_alive) {
    ANOGATE_NEEDS_NAMESPACES();
    const support::Namespace away;
    const support::NetworkNamespace net;
    net.join(away, "v0", "10.9.0.1/24", "10.9.0.2/24");
    std::unique_ptr<support::Process> broker;
    support::TempDir dir;
    const std::string file = dir.write("m.conf", "user root\nlistener 1883 10.9.0.2\nallow_anonymous true\n");
    {
        const support::Inside inside{away};
        broker = std::make_unique<support::Process>("mosquitto", std::vector<std::string>{"-c", file});
    }
    BrokerSettings settings = Client::settings_of(1883, "c");
    settings.host = "10.9.0.2";
    settings.keep_alive = 5s;    // the least that the library allows
    Client client{settings};
    ASSERT_TRUE(client.until_connected());
    const std::size_t before = client.faults().size();    // while the broker started
    away.ip("link set v0 down");
    const auto begin = ano::Clock::now();
    ASSERT_TRUE(support::wait_until([&] { return client.faults().size() > before; }));
    EXPECT_LT(ano::Clock::now() - begin, 15s);
}

}    // namespace
}    // namespace broker_tests
