// How long a peer of a listening socket stays, depending on received and refused frames.
#include <gateway/peers/peer_book.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace anogate::peer_book_tests {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t host = 0xFE, ros = 0xD2, device = 0xDC;
constexpr ChannelId a{3}, b{4}, c{5}, d{6};
const TimePoint start = TimePoint{} + 1h;

Endpoint at(const char* text) { return *Endpoint::parse(text); }
const Endpoint phone = at("192.168.1.20:5000"), phone_again = at("192.168.1.20:5001"), phone_anew = at("192.168.1.20:5002");
const Endpoint laptop = at("192.168.1.30:5000");

struct Book : PeerBook {
    explicit Book(Duration timeout = 60s, std::size_t most = 64, std::size_t max_of_address = 64)
        : PeerBook{{timeout, most, max_of_address}} {}
    explicit Book(const Options& options) : PeerBook{options} {}
    // A peer of one datagram, and one whose second datagram arrived at once.
    void join_once(ChannelId id, const Endpoint& endpoint, std::uint8_t source, TimePoint now, Rank rank = Rank::ordinary) {
        add(id, endpoint, true, now, rank);
        PeerBook::heard(id, source, now);
    }
    void join(ChannelId id, const Endpoint& endpoint, std::uint8_t source, TimePoint now, bool near = true) {
        add(id, endpoint, near, now);
        heard(id, source, now);
    }
    void heard(ChannelId id, std::uint8_t source, TimePoint now) {
        came(id);
        PeerBook::heard(id, source, now);
    }
};

TEST(PeerBook, a_silent_device_is_overdue_after_the_timeout_and_not_before) {
    Book book;
    book.join(a, phone, device, start);
    EXPECT_EQ(book.next_look(start), start + 60s);
    EXPECT_TRUE(book.overdue(start + 60s - 1ns).empty());
    EXPECT_EQ(book.overdue(start + 60s), ChannelSet{a});
    book.heard(a, device, start + 30s);
    EXPECT_TRUE(book.overdue(start + 90s - 1ns).empty());
    EXPECT_EQ(book.overdue(start + 90s), ChannelSet{a});
}

TEST(PeerBook, a_peer_without_a_frame_is_overdue_like_any_other) {
    Book book;
    book.add(a, phone, true, start);
    EXPECT_EQ(book.overdue(start + 10s), ChannelSet{a});
    book.came(a);
    EXPECT_TRUE(book.overdue(start + 60s - 1ns).empty());
    EXPECT_EQ(book.overdue(start + 60s), ChannelSet{a});
}

TEST(PeerBook, a_host_of_our_networks_that_only_listens_stays_an_hour) {
    for (const std::uint8_t source : {host, ros}) {
        Book book;
        book.join(a, phone, source, start);
        EXPECT_TRUE(book.overdue(start + 61s).empty());
        EXPECT_EQ(book.next_look(start), start + 10s) << "whether it is one of the latest two";
        EXPECT_EQ(book.next_look(start + 10s), start + 1h);
        EXPECT_TRUE(book.overdue(start + 1h - 1ns).empty());
        EXPECT_EQ(book.overdue(start + 1h), ChannelSet{a});
    }
}

TEST(PeerBook, one_host_frame_among_device_frames_makes_the_peer_a_host) {
    Book book;
    book.join(a, phone, device, start);
    book.heard(a, host, start);
    book.heard(a, device, start + 1s);
    EXPECT_TRUE(book.overdue(start + 30min).empty());
}

TEST(PeerBook, a_host_outside_our_networks_is_forgotten_like_a_device) {
    Book book;
    book.join(a, phone, host, start, false);
    EXPECT_EQ(book.overdue(start + 60s), ChannelSet{a});
}

TEST(PeerBook, a_timeout_of_more_than_an_hour_holds_for_hosts_too) {
    Book book{2h};
    book.join(a, phone, host, start);
    EXPECT_TRUE(book.overdue(start + 2h - 1ns).empty());
    EXPECT_EQ(book.overdue(start + 2h), ChannelSet{a});
}

TEST(PeerBook, the_two_latest_silent_hosts_of_an_address_stay) {
    Book book;
    book.join(a, phone, host, start);
    book.join(b, phone_again, host, start + 1s);
    book.join(c, phone_anew, host, start + 2s);
    book.join(d, laptop, host, start);
    EXPECT_TRUE(book.overdue(start + 11s).empty()) << "the third is not silent yet";
    EXPECT_EQ(book.next_look(start + 11s), start + 12s);
    EXPECT_EQ(book.overdue(start + 12s), ChannelSet{a}) << "and another address has places of its own";
    book.heard(a, host, start + 12s);
    EXPECT_TRUE(book.overdue(start + 12s).empty()) << "it was heard, and is silent no more";
    book.remove(b);
    EXPECT_TRUE(book.overdue(start + 10min).empty());
}

TEST(PeerBook, two_of_several_hosts_last_heard_at_the_same_time_stay) {
    Book book;
    for (const ChannelId id : {a, b, c, d}) book.join(id, phone, host, start);
    EXPECT_EQ(book.overdue(start + 60s).size(), 2u);
}

TEST(PeerBook, devices_do_not_displace_a_silent_host) {
    Book book;
    book.join(a, phone, host, start);
    book.join(b, phone_again, device, start + 1s);
    book.join(c, phone_anew, device, start + 2s);
    EXPECT_EQ(book.overdue(start + 5min), ChannelSet{b} | ChannelSet{c});
}

TEST(PeerBook, three_refusals_over_five_seconds_end_a_peer) {
    Book book;
    book.join(a, phone, host, start);
    EXPECT_FALSE(book.refused(a, start));
    EXPECT_FALSE(book.refused(a, start + 1s));
    EXPECT_FALSE(book.refused(a, start + 5s - 1ns)) << "a program that starts anew";
    EXPECT_TRUE(book.overdue(start + 10s).empty()) << "nothing was refused since";
    EXPECT_TRUE(book.refused(a, start + 5s));
    EXPECT_EQ(book.overdue(start + 5s), ChannelSet{a});
    EXPECT_EQ(book.next_look(start + 5s), start + 5s);
}

TEST(PeerBook, two_refusals_are_not_enough_however_far_apart) {
    Book book;
    book.join(a, phone, host, start);
    EXPECT_FALSE(book.refused(a, start));
    EXPECT_FALSE(book.refused(a, start + 20min));
    EXPECT_TRUE(book.overdue(start + 20min).empty());
}

TEST(PeerBook, a_frame_of_the_peer_resets_the_count_of_refusals) {
    Book book;
    book.join(a, phone, host, start);
    book.refused(a, start);
    book.refused(a, start + 4s);
    book.heard(a, host, start + 4500ms);
    EXPECT_FALSE(book.refused(a, start + 6s));
    EXPECT_FALSE(book.refused(a, start + 9s));
    EXPECT_TRUE(book.refused(a, start + 11s));
    book.heard(a, host, start + 11s);
    EXPECT_TRUE(book.overdue(start + 11s).empty()) << "it came back before it was forgotten";
}

TEST(PeerBook, a_reused_number_has_no_history) {
    Book book;
    book.join(a, phone, host, start);
    for (const Duration later : {0s, 3s, 6s}) book.refused(a, start + later);
    book.remove(a);
    EXPECT_TRUE(book.overdue(start + 6s).empty());
    EXPECT_EQ(book.next_look(start), TimePoint::max());
    book.join(a, laptop, device, start + 6s);
    EXPECT_TRUE(book.overdue(start + 7s).empty());
    EXPECT_EQ(book.overdue(start + 66s), ChannelSet{a});
}

TEST(PeerBook, a_peer_is_accepted_until_the_quota_is_used_up) {
    Book book{60s, 2};
    book.join(a, phone, device, start);
    EXPECT_TRUE(book.place_for(laptop, start).free);
    EXPECT_FALSE(book.place_for(laptop, start).evicted);
    book.join(b, laptop, device, start);
    EXPECT_FALSE(book.place_for(phone_again, start).free);
}

TEST(PeerBook, a_new_sender_displaces_only_a_silent_one_that_sent_once) {
    Book book{60s, 3};
    book.join(a, phone, host, start);
    book.join(b, phone_again, host, start);
    book.heard(b, host, start + 1s);
    book.join(c, laptop, host, start + 30s);
    EXPECT_FALSE(book.place_for(at("10.0.0.1:1"), start + 60s - 1ns).free);
    EXPECT_EQ(book.place_for(at("10.0.0.1:2"), start + 60s).evicted, a);
    book.remove(a);
    book.join(a, phone, device, start + 60s);
    EXPECT_FALSE(book.place_for(at("10.0.0.1:3"), start + 80s).free) << "one that listens came more than once, two spoke";
}

TEST(PeerBook, a_sender_that_returns_later_displaces_one_that_sent_once_of_an_address_with_several_peers) {
    Book book{60s, 3};
    book.join(a, phone, host, start);
    book.heard(a, host, start + 1s);
    book.join(c, laptop, host, start);
    book.join(b, phone_again, host, start);
    const Endpoint stranger = at("10.0.0.1:1");
    EXPECT_FALSE(book.place_for(stranger, start + 2s).free);
    EXPECT_FALSE(book.place_for(stranger, start + 3s - 1ns).free);
    EXPECT_EQ(book.place_for(stranger, start + 3s).evicted, b);
    EXPECT_FALSE(book.place_for(at("10.0.0.1:2"), start + 3s).free) << "another port is another stranger";
    book.heard(b, host, start + 3s);
    EXPECT_FALSE(book.place_for(stranger, start + 4s).free) << "those came more than once, and an address keeps its only place";
    book.heard(c, host, start + 5s);
    EXPECT_EQ(book.place_for(stranger, start + 61s).evicted, a) << "one that listens, when its place is needed";
}

TEST(PeerBook, a_stranger_that_returns_after_the_timeout_counts_as_new) {
    Book book{60s, 1};
    book.join(a, phone, host, start);
    book.heard(a, host, start + 1s);
    const Endpoint stranger = at("10.0.0.1:1");
    EXPECT_FALSE(book.place_for(stranger, start).free);
    EXPECT_FALSE(book.place_for(stranger, start + 61s).free);
    EXPECT_EQ(book.place_for(stranger, start + 62s).evicted, a);
}

TEST(PeerBook, a_stranger_that_returns_within_the_timeout_counts_as_returning) {
    Book book{60s, 1};
    book.join(a, phone, host, start);
    book.heard(a, host, start + 2s);
    const Endpoint stranger = at("10.0.0.1:1");
    EXPECT_FALSE(book.place_for(stranger, start + 10s).free);
    EXPECT_FALSE(book.place_for(stranger, start + 40s).free);
    EXPECT_EQ(book.place_for(stranger, start + 70s).evicted, a);
}

TEST(PeerBook, an_address_that_tries_many_ports_does_not_displace_the_attempts_of_others) {
    Book book{60s, 1};
    book.join(a, phone, host, start);
    book.heard(a, host, start + 1s);
    const TimePoint silent = start + 62s;
    EXPECT_FALSE(book.place_for(laptop, silent).free);
    for (std::uint16_t port = 1; port <= 100; ++port) book.place_for({IpAddress::v4(10, 0, 0, 1), port}, silent + port * 1ms);
    EXPECT_EQ(book.place_for(laptop, silent + 1s).evicted, a);
}

TEST(PeerBook, an_address_has_a_limited_quota_and_replaces_only_peers_of_the_same_address) {
    Book book{60s, 8, 2};
    book.join(a, phone, host, start);
    book.join(b, phone_again, host, start + 1s);
    EXPECT_FALSE(book.place_for(phone_anew, start + 1s).free);
    EXPECT_TRUE(book.place_for(laptop, start + 1s).free);
    book.join(c, laptop, host, start);
    EXPECT_EQ(book.place_for(phone_anew, start + 2s).evicted, a) << "one of its own, when it comes again";
}

TEST(PeerBook, one_address_displaces_no_peer_of_another_however_many_ports_it_uses) {
    Book book{60s, 8, 2};
    book.join(a, laptop, host, start);
    ChannelSet strangers;
    for (int i = 0; i < 20000; ++i) {
        const TimePoint now = start + i * 50ms;
        const Endpoint stranger{IpAddress::v4(192, 168, 1, 66), static_cast<std::uint16_t>(1000 + i)};
        const auto place = book.place_for(stranger, now);
        if (!place.free) continue;
        ASSERT_NE(place.evicted, a);
        if (place.evicted) book.remove(*place.evicted), strangers.erase(*place.evicted);
        const ChannelId id = strangers.contains(b) ? c : b;
        book.join(id, stranger, host, now);
        strangers.insert(id);
        ASSERT_LE(strangers.size(), 2u);
    }
}

TEST(PeerBook, programs_of_this_machine_displace_each_other_and_have_no_share) {
    Book book{60s, 3, 1};
    book.join(a, at("127.0.0.1:1"), host, start);
    EXPECT_TRUE(book.place_for(at("127.0.0.1:2"), start).free);
    book.join(b, at("127.0.0.1:2"), host, start + 1ms);
    book.join(c, laptop, host, start - 1s);
    EXPECT_EQ(book.place_for(at("127.0.0.1:3"), start + 2ms).evicted, a);
    book.heard(a, host, start + 3ms);
    EXPECT_EQ(book.place_for(at("[::1]:3"), start + 4ms).evicted, b);
}

TEST(PeerBook, broadcast_multicast_and_unspecified_addresses_and_port_0_are_never_peers) {
    const std::vector<Network> own{*Network::parse("192.168.1.5/24"), *Network::parse("10.0.0.1/31")};
    for (const char* good : {"192.168.1.20:5000", "8.8.8.8:53", "10.0.0.0:1", "[fe80::1]:1", "127.0.0.1:1"})
        EXPECT_TRUE(can_be_peer(at(good), own)) << good;
    for (const char* bad : {"192.168.1.20:0", "192.168.1.255:5000", "192.168.1.0:5000", "255.255.255.255:1", "224.0.0.1:1",
                            "0.0.0.0:1", "[ff02::1]:1", "[::]:1"})
        EXPECT_FALSE(can_be_peer(at(bad), own)) << bad;
}

TEST(PeerBook, the_state_of_a_peer_can_be_moved_to_another_book) {
    Book book, next;
    book.join(a, phone, host, start);
    book.heard(a, host, start + 2s);
    book.join(b, laptop, device, start + 1s);
    for (const ChannelId id : {a, b}) {
        next.add(id, id == a ? phone : laptop, true, start + 10s);
        next.remember(id, book.memory(id));
    }
    EXPECT_EQ(next.overdue(start + 61s), ChannelSet{b}) << "it was heard at 1 s, and not when it was added";
    EXPECT_TRUE(next.memory(a).is_host && next.memory(a).has_returned);
    EXPECT_FALSE(next.memory(b).is_host || next.memory(b).has_returned);
    EXPECT_EQ(next.overdue(start + 2s + PeerBook::listener_stays), (ChannelSet{a} | ChannelSet{b}));
}

TEST(PeerBook, a_device_that_sent_a_single_datagram_is_overdue_after_ten_seconds) {
    Book book;
    book.join_once(a, phone, device, start);
    EXPECT_EQ(book.next_look(start), start + 10s);
    EXPECT_TRUE(book.overdue(start + 10s - 1ns).empty());
    EXPECT_EQ(book.overdue(start + 10s), ChannelSet{a});
    book.heard(a, device, start + 9s);
    EXPECT_TRUE(book.overdue(start + 69s - 1ns).empty());
    Book impatient{5s};
    impatient.join_once(a, phone, device, start);
    EXPECT_EQ(impatient.overdue(start + 5s), ChannelSet{a});
}

TEST(PeerBook, hosts_that_sent_one_datagram_may_listen_two_per_address_and_eight_in_total) {
    Book book;
    book.join_once(a, phone, host, start);
    EXPECT_EQ(book.listening_since(a), start);
    EXPECT_TRUE(book.overdue(start + 59min).empty());
    book.join_once(b, phone_again, host, start + 1s);
    book.join_once(c, phone_anew, host, start + 2s);
    EXPECT_EQ(book.overdue(start + 12s), ChannelSet{a}) << "of an address the latest stay";
    book.heard(c, host, start + 3s);
    EXPECT_EQ(book.listening_since(c), std::nullopt);
    for (std::uint8_t n = 0; n < 10; ++n)
        book.join_once(static_cast<ChannelId>(20 + n), {IpAddress::v4(10, 0, 0, n), 5000}, host, start + 4s + n * 1ms);
    EXPECT_EQ(book.overdue(start + 15s), ChannelSet{ChannelId{26}} | ChannelId{27} | ChannelId{28} | ChannelId{29})
        << "in all the first stay";
}

TEST(PeerBook, programs_of_this_machine_may_listen_for_a_minute_beyond_the_limit) {
    Book book;
    for (std::uint8_t n = 0; n < 10; ++n)
        book.join_once(static_cast<ChannelId>(n), {IpAddress::v4(127, 0, 0, 1), static_cast<std::uint16_t>(5000 + n)}, host,
                       start);
    EXPECT_TRUE(book.overdue(start + 59s).empty());
    EXPECT_EQ(book.overdue(start + 60s).size(), 8u);
}

// The sources of single datagrams can be forged, so eight of them must not end the telemetry of an operator.
TEST(PeerBook, of_hosts_that_only_receive_trusted_and_commanding_ones_are_among_the_eight) {
    Book book;
    for (std::uint8_t n = 0; n < 8; ++n)
        book.join_once(static_cast<ChannelId>(20 + n), {IpAddress::v4(10, 0, 0, n), 5000}, host, start);
    book.join_once(a, phone, host, start + 1s, PeerBook::Rank::trusted);
    book.join(b, laptop, host, start + 1s);
    book.commanded(b, start + 1s);
    EXPECT_EQ(book.overdue(start + 12s), ChannelSet{ChannelId{26}} | ChannelId{27});
}

TEST(PeerBook, hosts_that_sent_once_do_not_displace_a_silent_one_of_their_address_that_sent_again) {
    for (const Endpoint& first : {phone, Endpoint{IpAddress::v4(127, 0, 0, 1), 5000}}) {
        Book book;
        book.join(a, first, host, start);
        book.heard(a, host, start + 3s);
        for (const ChannelId id : {b, c})
            book.join_once(id, {first.address, static_cast<std::uint16_t>(first.port + index(id))}, host, start + 4s);
        EXPECT_EQ(book.overdue(start + 5min), ChannelSet{b});
        book.heard(c, host, start + 8s);
        book.heard(b, host, start + 9s);
        EXPECT_EQ(book.overdue(start + 5min), ChannelSet{a}) << "of those that sent again the latest stay";
    }
}

// As behind a firewall that sends no ICMP: the old ports seem to listen.
TEST(PeerBook, a_host_that_restarted_twice_and_sent_once_stays) {
    Book book;
    for (const ChannelId id : {a, b}) {
        book.join(id, {phone.address, static_cast<std::uint16_t>(phone.port + index(id))}, host, start + index(id) * 1min);
        book.heard(id, host, start + index(id) * 1min + 3s);
    }
    book.join_once(c, phone, host, start + 10min);
    EXPECT_EQ(book.overdue(start + 15min), ChannelSet{a});
}

TEST(PeerBook, one_refusal_ends_a_peer_that_sent_a_single_datagram) {
    Book book;
    book.join_once(a, phone, host, start);
    EXPECT_TRUE(book.refused(a, start + 1s));
    EXPECT_EQ(book.overdue(start + 1s), ChannelSet{a});
}

TEST(PeerBook, quota_is_reserved_for_hosts_that_command_and_for_trusted_ones) {
    using enum PeerBook::Rank;
    Book book{PeerBook::Options{60s, 4, 4, 2, 1}};
    book.join_once(a, phone, host, start);
    EXPECT_TRUE(book.place_for(laptop, start).free);
    book.join_once(b, laptop, device, start);
    EXPECT_FALSE(book.place_for(at("10.0.0.1:1"), start).free);
    EXPECT_TRUE(book.place_for(at("10.0.0.1:1"), start, commands).free);
    book.join_once(c, at("10.0.0.1:1"), host, start, commands);
    EXPECT_EQ(book.place_for(at("10.0.0.2:1"), start, commands).evicted, c) << "the last is kept for one of a trusted network";
    EXPECT_TRUE(book.place_for(at("10.0.0.3:1"), start, trusted).free);
    book.join_once(d, at("10.0.0.3:1"), host, start, trusted);
    EXPECT_EQ(book.place_for(at("10.0.0.4:1"), start + 61s).evicted, a) << "of its own rank";
    book.heard(a, host, start + 61s);
    book.heard(b, host, start + 61s);
    EXPECT_FALSE(book.place_for(at("10.0.0.5:1"), start + 61s).free) << "and of no higher one";
    EXPECT_EQ(book.place_for(at("10.0.0.6:1"), start + 61s, commands).evicted, c);
}

TEST(PeerBook, a_peer_that_starts_to_command_uses_the_reserved_quota) {
    Book book{PeerBook::Options{60s, 2, 2, 1, 0}};
    book.join(a, phone, host, start);
    EXPECT_FALSE(book.place_for(laptop, start).free);
    book.commanded(a, start);
    EXPECT_TRUE(book.place_for(laptop, start).free);
}

// So its command is forwarded, however many other hosts send commands, and the earlier peers stay.
TEST(PeerBook, the_latest_commanding_host_is_replaced_by_another_one) {
    using enum PeerBook::Rank;
    Book book{PeerBook::Options{60s, 3, 3, 1, 0}};
    book.join_once(a, phone, host, start, commands);
    book.join_once(b, laptop, host, start + 1s, commands);
    book.join_once(c, at("10.0.0.1:1"), host, start + 2s, commands);
    const TimePoint now = start + 3s;
    for (const ChannelId id : {a, b, c}) book.heard(id, host, now);
    EXPECT_EQ(book.place_for(at("10.0.0.2:1"), now, commands).evicted, c);
    EXPECT_FALSE(book.place_for(at("10.0.0.2:1"), now).free) << "not to one that only listens";
    Book with_trusted{PeerBook::Options{60s, 2, 2, 1, 1}};
    with_trusted.join_once(a, phone, host, start, commands);
    with_trusted.join_once(b, laptop, host, start + 1s, trusted);
    with_trusted.heard(a, host, now);
    EXPECT_EQ(with_trusted.place_for(at("10.0.0.2:1"), now, commands).evicted, a) << "no trusted one";
}

TEST(PeerBook, a_flood_of_commanding_hosts_costs_little) {
    using enum PeerBook::Rank;
    Book book{PeerBook::Options{60s, 3, 3, 1, 0}};
    book.join_once(a, phone, host, start, commands);
    book.join_once(b, laptop, host, start, commands);
    book.join_once(c, at("10.0.0.1:1"), host, start, commands);
    const auto replaced_by = [&](std::size_t strangers, TimePoint now) {
        std::size_t count = 0;
        for (std::size_t i = 0; i < strangers; ++i) {
            const Endpoint stranger{IpAddress::v4(10, 0, 1, static_cast<std::uint8_t>(i)), 1};
            const auto place = book.place_for(stranger, now, commands);
            if (!place.evicted) continue;
            book.remove(*place.evicted);
            book.join_once(*place.evicted, stranger, host, now, commands);
            ++count;
        }
        return count;
    };
    EXPECT_EQ(replaced_by(200, start + 3s), std::size_t{PeerBook::turns_at_once}) << "simultaneously";
    EXPECT_EQ(replaced_by(200, start + 3s + PeerBook::turn - 1us), 0u);
    EXPECT_EQ(replaced_by(200, start + 3s + PeerBook::turn), 1u);
    EXPECT_EQ(replaced_by(200, start + 30s), std::size_t{PeerBook::turns_at_once});
}

// As with forged sources, or several computers behind one router.
TEST(PeerBook, one_place_of_an_address_is_kept_for_a_host_that_commands) {
    using enum PeerBook::Rank;
    for (const PeerBook::Rank rank : {ordinary, trusted}) {
        Book book{PeerBook::Options{60s, 16, 3, 4, 2}};
        book.join_once(a, at("10.0.0.60:1"), host, start, rank);
        book.join_once(b, at("10.0.0.60:2"), host, start, rank);
        const TimePoint now = start + 5s;
        for (const ChannelId id : {a, b}) book.heard(id, host, now);
        EXPECT_FALSE(book.place_for(at("10.0.0.60:3"), now, rank).free) << "not for one that listens";
        const PeerBook::Rank of_operator = std::max(rank, commands);
        const auto place = book.place_for(at("10.0.0.60:4"), now, of_operator, true);
        EXPECT_TRUE(place.free && !place.evicted);
        book.join_once(c, at("10.0.0.60:4"), host, now, of_operator);
        book.commanded(c, now);
        book.heard(c, host, now + 1s);
        EXPECT_EQ(book.place_for(at("10.0.0.60:5"), now + 1s, of_operator, true).evicted, c) << "the devices there stay";
        book.commanded(a, now + 2s);
        book.commanded(a, now + 3s);
        EXPECT_EQ(book.place_for(at("10.0.0.60:6"), now + 3s, of_operator, true).evicted, c) << "it commands less often";
    }
}

TEST(PeerBook, a_trusted_host_that_commands_replaces_one_that_is_not_trusted_and_no_device) {
    using enum PeerBook::Rank;
    Book book{PeerBook::Options{60s, 4, 4, 1, 1}};
    book.join(a, phone, device, start);
    book.join_once(b, laptop, host, start, commands);
    book.join_once(c, at("10.0.0.1:1"), host, start, trusted);
    book.join_once(d, at("10.0.0.2:1"), host, start, commands);
    for (const ChannelId id : {a, b, c, d}) book.heard(id, host, start + 5s);
    EXPECT_FALSE(book.place_for(at("10.0.0.3:1"), start + 5s, trusted).free) << "its source may be forged";
    ASSERT_EQ(book.place_for(at("10.0.0.4:1"), start + 5s, trusted, true).evicted, d);
    book.remove(d);
    book.join_once(d, at("10.0.0.4:1"), host, start + 5s, trusted);
    ASSERT_EQ(book.place_for(at("10.0.0.5:1"), start + 5s, trusted, true).evicted, b);
    book.remove(b);
    book.join_once(b, at("10.0.0.5:1"), host, start + 5s, trusted);
    EXPECT_FALSE(book.place_for(at("10.0.0.6:1"), start + 5s, trusted, true).free);
}

// Strangers send commands five times a second, simultaneously or one after the other, also at the same time as the operator.
TEST(PeerBook, a_late_operator_keeps_its_place_among_hosts_that_command_less_often_and_loses_no_command) {
    using enum PeerBook::Rank;
    for (const int strangers : {16, 30})
        for (const int apart : {0, 1, 6})
            for (const int phase : {0, 37, 99}) {
                Book book{PeerBook::Options{60s, 16, 4, 4, 0}};
                std::array<Endpoint, 17> who;
                std::size_t places = 0;
                const auto has_place = [&](const Endpoint& one) { return std::count(who.begin(), who.end(), one) > 0; };
                const auto sends = [&](const Endpoint& from, TimePoint now) {
                    auto at = static_cast<std::size_t>(std::find(who.begin(), who.end(), from) - who.begin());
                    if (at == who.size()) {
                        const auto place = book.place_for(from, now, commands);
                        if (!place.free) return false;
                        at = place.evicted ? anogate::index(*place.evicted) : places++;
                        if (place.evicted) book.remove(*place.evicted);
                        who[at] = from;
                        book.add(ChannelId{static_cast<std::uint8_t>(at)}, from, true, now, commands);
                    }
                    const ChannelId id{static_cast<std::uint8_t>(at)};
                    book.heard(id, host, now);
                    book.commanded(id, now);
                    return true;
                };
                const Endpoint pilot = at("10.0.0.40:1"), earlier = at("10.0.0.41:1"), operator_ = at("10.0.0.1:1");
                sends(pilot, start);
                sends(earlier, start);
                int through = 0, kept = 0;
                for (int ms = 1; ms < 8000; ++ms) {
                    const TimePoint now = start + std::chrono::milliseconds{ms};
                    for (int i = 0; i < strangers; ++i)
                        if (ms % 200 == apart * i % 200) sends({IpAddress::v4(10, 0, 1, static_cast<std::uint8_t>(i)), 1}, now);
                    if (ms < 3000 || ms % 100 != phase) continue;
                    kept += has_place(operator_) ? 1 : 0;
                    through += sends(operator_, now) ? 1 : 0;
                }
                EXPECT_EQ(through, 50) << strangers << " " << apart << " " << phase;
                EXPECT_GE(kept, 47) << strangers << " " << apart << " " << phase;
                EXPECT_TRUE(has_place(pilot) && has_place(earlier)) << "the earlier ones stay, and command rarely";
            }
}

TEST(PeerBook, on_this_machine_too_a_new_sender_does_not_displace_one_that_sent_repeatedly) {
    const Endpoint local = at("127.0.0.1:1"), stranger = at("127.0.0.1:2");
    Book book{60s, 1};
    book.join(a, local, host, start);
    EXPECT_EQ(book.place_for(at("127.0.0.1:3"), start).evicted, a);
    book.heard(a, host, start + 1s);
    EXPECT_FALSE(book.place_for(stranger, start + 1s).free);
    EXPECT_EQ(book.place_for(stranger, start + 2s).evicted, a) << "it came again, too";
}

// A device that sends repeatedly, among strangers that send one datagram each.
struct Flood {
    explicit Flood(const PeerBook::Options& options = {60s, 16, 4, 4, 2}) : book{options} {}

    Book book;
    bool book_waits = false;    // with connections, overdue peers leave only when their places are needed
    std::array<Endpoint, 16> who{};

    bool has_place(const Endpoint& one) const { return std::find(who.begin(), who.end(), one) != who.end(); }
    void sends(const Endpoint& from, TimePoint now, PeerBook::Rank rank = PeerBook::Rank::ordinary) {
        const std::uint8_t source = rank == PeerBook::Rank::commands ? host : device;
        if (!book_waits)
            for (const ChannelId id : book.overdue(now)) leave(id);
        const auto found = std::find(who.begin(), who.end(), from);
        if (found != who.end()) return book.heard(static_cast<ChannelId>(found - who.begin()), source, now);
        const auto place = book.place_for(from, now, rank);
        if (!place.free) return;
        if (place.evicted) leave(*place.evicted);
        const auto unused = std::find(who.begin(), who.end(), Endpoint{});
        *unused = from;
        const auto id = static_cast<ChannelId>(unused - who.begin());
        book.join_once(id, from, source, now, rank);
        if (rank == PeerBook::Rank::commands) book.commanded(id, now);
    }
    void leave(ChannelId id) {
        book.remove(id);
        who[anogate::index(id)] = {};
    }
};

// The endpoint number n of many: ports of this machine, or addresses of other networks.
Endpoint stranger(bool is_local, std::uint32_t n) {
    const auto byte = [n](int at) { return static_cast<std::uint8_t>(n >> 8 * at); };
    if (!is_local) return {IpAddress::v4(10, byte(2), byte(1), byte(0)), 5000};
    return {IpAddress::v4(127, 0, byte(2), 1), static_cast<std::uint16_t>(1 + n % 60000)};
}

TEST(PeerBook, a_device_gets_its_place_for_good_within_seconds_however_many_strangers_send_once) {
    for (const bool is_local : {true, false})
        for (const Duration period : {Duration{1s} / 7, Duration{100ms}, Duration{20ms}})
            for (const auto& [strangers_per_second, within] : {std::pair{140, 2s}, {1000, 2s}, {10000, 5s}}) {
                Flood flood;
                const Endpoint late = is_local ? at("127.0.0.1:60001") : at("192.168.1.20:5000");
                const TimePoint first = start + 1s;
                TimePoint next = first, lost = first;
                std::uint32_t n = 0;
                for (TimePoint now = start; now < first + within + 4s; now = start + n * (Duration{1s} / strangers_per_second)) {
                    for (; next < now; next += period) flood.sends(late, next);
                    flood.sends(stranger(is_local, n++), now);
                    if (!flood.has_place(late)) lost = now;
                }
                EXPECT_LT((lost - start) / 1ms, (first + within - start) / 1ms)
                    << is_local << " every " << period / 1ms << " ms, " << strangers_per_second << "/s";
            }
}

TEST(PeerBook, a_device_gets_its_place_for_good_within_seconds_however_many_strangers_send_pairs) {
    for (const bool is_local : {true, false})
        for (const Duration period : {Duration{1s} / 7, Duration{20ms}})
            for (const Duration apart : {Duration{100us}, Duration{20ms}, Duration{100ms}, Duration{700ms}})
                for (const auto& [pairs_per_second, within] : {std::pair{1000, 3s}, {5000, 5s}}) {
                    Flood flood;
                    const Endpoint late = is_local ? at("127.0.0.1:60001") : at("192.168.1.20:5000");
                    const Duration between_pairs = Duration{1s} / pairs_per_second;
                    const TimePoint first = start + 1s;
                    TimePoint next = first, lost = first;
                    std::uint32_t n = 0, again = 0;
                    for (TimePoint now = start; now < first + within + 4s; now = start + n * between_pairs) {
                        for (; next < now; next += period) flood.sends(late, next);
                        for (; start + again * between_pairs + apart <= now; ++again)
                            flood.sends(stranger(is_local, again), start + again * between_pairs + apart);
                        flood.sends(stranger(is_local, n++), now);
                        if (!flood.has_place(late)) lost = now;
                    }
                    EXPECT_LT((lost - start) / 1ms, (first + within - start) / 1ms)
                        << is_local << " every " << period / 1ms << " ms, pairs " << apart / 1us << " us apart, "
                        << pairs_per_second << "/s";
                }
}

TEST(PeerBook, senders_of_one_address_that_alternate_do_not_keep_each_other_from_their_places) {
    const auto port = [](std::uint16_t number) { return Endpoint{IpAddress::v4(10, 0, 0, 9), number}; };
    for (const Duration period : {Duration{1s} / 4, Duration{1s} / 7, Duration{1s} / 10}) {
        Flood flood{{60s, 16, 4, 2, 0}};
        for (const auto& old : {port(1), port(3), port(5)}) {
            flood.sends(old, start - 30s);
            flood.sends(old, start - 30s + 200ms);
        }
        const std::array late{port(5001), port(5003)};
        for (TimePoint now = start; now < start + 10s; now += period) {
            flood.sends(late[0], now);
            flood.sends(late[1], now + period / 2);
        }
        for (const Endpoint& one : late) EXPECT_TRUE(flood.has_place(one)) << period / 1ms << " ms";
    }
}

TEST(PeerBook, a_device_that_restarts_with_new_ports_waits_for_no_place) {
    Flood flood{{60s, 16, 4, 2, 0}};
    const auto port = [](int n) { return Endpoint{IpAddress::v4(10, 0, 0, 9), static_cast<std::uint16_t>(5000 + 7 * n)}; };
    for (int n = 0; n < 12; ++n) {
        const TimePoint began = start + n * 6s;
        for (TimePoint now = began; now < began + 5s; now += 100ms) flood.sends(port(n), now);
        EXPECT_TRUE(flood.has_place(port(n))) << "start " << n;
    }
}

TEST(PeerBook, a_quiet_host_that_commanded_leaves_neither_for_strangers_of_its_network_nor_of_its_address) {
    for (const bool connections : {true, false}) {
        PeerBook::Options options{60s, 16, 4, 2, 0};
        options.has_connections = connections;
        Flood flood{options};
        flood.book_waits = connections;
        const Endpoint station = at("[fd00::10]:5000");
        flood.sends(station, start, PeerBook::Rank::commands);
        flood.sends(station, start + 1200ms, PeerBook::Rank::commands);
        for (TimePoint now = start + 2s; now < start + 120s; now += 200ms)
            for (std::uint16_t n = 0; n < 6; ++n) {
                Endpoint one = n % 2 == 0 ? station : at("[fd00::20]:1");
                one.port = static_cast<std::uint16_t>(6000 + n);
                flood.sends(one, now);
            }
        EXPECT_TRUE(flood.has_place(station)) << connections;
    }
}

TEST(PeerBook, hosts_that_sent_twice_in_a_moment_may_listen_as_those_that_sent_once) {
    Book book{60s, 64};
    for (std::uint8_t n = 0; n < 12; ++n) {
        const Endpoint one{IpAddress::v4(192, 168, 1, n), 5000};
        book.add(ChannelId{n}, one, true, start);
        book.heard(ChannelId{n}, host, start + 100ms);
    }
    EXPECT_EQ(book.overdue(start + 11s).size(), 4u) << "eight in all";
}

TEST(PeerBook, several_devices_and_a_quiet_ground_station_keep_their_places_among_strangers_that_send_once) {
    constexpr Duration between_strangers = 500us, between_frames = Duration{1s} / 7, between_questions = 5s;
    const auto local = [](std::uint16_t port) { return Endpoint{IpAddress::v4(127, 0, 0, 1), port}; };
    const Endpoint station = local(60001);
    const std::array devices{local(60002), local(60003), local(60004), local(60005)};
    Flood flood;
    flood.sends(station, start);
    flood.sends(station, start + 1200ms);
    TimePoint question = start + between_questions, frame = start + 2s, lost = start;
    std::uint32_t n = 0;
    for (TimePoint now = start + 2s; now < start + 20s; now += between_strangers) {
        if (now >= question) flood.sends(station, std::exchange(question, question + between_questions));
        if (now >= frame) {
            for (const Endpoint& one : devices) flood.sends(one, frame);
            frame += between_frames;
        }
        flood.sends(stranger(true, n++), now);
        EXPECT_TRUE(flood.has_place(station));
        if (!std::all_of(devices.begin(), devices.end(), [&](const Endpoint& one) { return flood.has_place(one); })) lost = now;
    }
    EXPECT_LT((lost - start) / 1ms, 7000);
}

TEST(PeerBook, a_device_that_sends_again_displaces_no_host_that_may_listen_and_no_peer_that_sent_again) {
    Book book{60s, 3};
    book.join(a, phone, host, start);
    book.join(b, laptop, device, start);
    book.heard(b, device, start + 1s);
    book.join_once(c, at("10.0.0.1:1"), device, start);
    const Endpoint late = at("10.0.0.2:1");
    EXPECT_FALSE(book.place_for(late, start + 2s).free);
    EXPECT_EQ(book.place_for(late, start + 3s).evicted, c);
    book.remove(c);
    book.add(c, late, true, start + 3s);
    EXPECT_TRUE(book.memory(c).has_returned) << "from the start";
    EXPECT_FALSE(book.memory(c).once);
    const Endpoint later = at("10.0.0.3:1");
    EXPECT_FALSE(book.place_for(later, start + 4s).free);
    EXPECT_FALSE(book.place_for(later, start + 5s).free);
}

PeerBook::Options of_connections(std::size_t max, std::size_t of_address = 64) {
    PeerBook::Options options;
    options.max_peers = max;
    options.max_of_address = of_address;
    options.has_connections = true;
    return options;
}

TEST(PeerBook, an_overdue_connection_is_replaced_only_when_its_place_is_needed) {
    Book book{of_connections(2)};
    book.join_once(a, phone, device, start);
    book.join(b, laptop, device, start + 9s);
    EXPECT_FALSE(book.place_for(at("192.168.1.40:5000"), start + 9s).free);
    EXPECT_EQ(book.place_for(at("192.168.1.41:5000"), start + 10s).evicted, a) << "it sent a single frame";
}

TEST(PeerBook, a_connection_from_any_network_without_a_second_frame_leaves_its_place_after_10_s) {
    Book book{of_connections(1)};
    book.add(a, at("10.9.0.1:5000"), false, start);
    EXPECT_FALSE(book.place_for(phone, start + 10s - 1ns).free);
    EXPECT_EQ(book.place_for(phone, start + 10s).evicted, a);
    book.heard(a, device, start + 9s);
    EXPECT_FALSE(book.place_for(laptop, start + 30s).free);
}

TEST(PeerBook, an_ipv6_network_of_strangers_counts_as_one_address_of_connections) {
    const auto host_at = [](int n) { return at(("[fd00::" + std::to_string(n) + "]:5000").c_str()); };
    for (const bool has_connections : {true, false}) {
        PeerBook::Options options = of_connections(8, 2);
        options.has_connections = has_connections;
        Book book{options};
        book.join(a, host_at(1), host, start);
        book.join(b, host_at(2), host, start);
        EXPECT_EQ(book.place_for(host_at(3), start).free, !has_connections);
        EXPECT_TRUE(book.place_for(host_at(3), start, PeerBook::Rank::commands).free);
        EXPECT_TRUE(book.place_for(host_at(3), start, PeerBook::Rank::trusted).free);
    }
}

// Their addresses can't be forged, unlike those of datagrams.
TEST(PeerBook, a_trusted_connection_is_replaced_only_by_a_trusted_one) {
    using enum PeerBook::Rank;
    for (const bool has_connections : {true, false}) {
        PeerBook::Options options{60s, 4, 4, 2, 1};
        options.has_connections = has_connections;
        Book book{options};
        book.join_once(a, at("10.8.0.1:1"), host, start, trusted);
        book.join_once(b, at("10.8.0.1:2"), host, start, trusted);
        book.join_once(c, at("10.8.0.2:1"), host, start, trusted);
        book.join_once(d, phone, host, start, commands);
        const Endpoint late = at("10.0.0.1:1");
        book.heard(d, host, start + 1s);
        EXPECT_FALSE(book.place_for(late, start).free);
        EXPECT_EQ(book.place_for(late, start + 1s).free, !has_connections) << "within the second of their first frame";
        EXPECT_EQ(book.place_for(late, start + 20s).free, !has_connections) << "they only receive";
        EXPECT_EQ(book.place_for(at("10.0.0.2:1"), start + 20s, commands).evicted, d);
        EXPECT_EQ(book.place_for(at("10.8.0.3:1"), start + 20s, trusted, true).evicted, d);
    }
}

TEST(PeerBook, a_trusted_connection_is_not_replaced_by_another_host_of_its_ipv6_network) {
    const auto host_at = [](int n) { return at(("[fd00::" + std::to_string(n) + "]:5000").c_str()); };
    Book book{of_connections(8, 2)};
    book.join_once(a, host_at(1), device, start, PeerBook::Rank::trusted);
    book.join_once(b, host_at(2), device, start, PeerBook::Rank::trusted);
    EXPECT_FALSE(book.place_for(host_at(3), start + 20s).free);
}

TEST(PeerBook, the_longest_silent_ordinary_peer_frees_its_channel_for_another_link) {
    Book book;
    book.join_once(a, phone, host, start, PeerBook::Rank::trusted);
    book.join_once(b, phone_again, host, start);
    book.commanded(b, start);
    book.join(c, laptop, device, start + 1s);
    book.join(d, laptop, device, start + 2s);
    EXPECT_EQ(book.longest_silent(PeerBook::Rank::trusted, start + 3s), std::nullopt) << "both devices are active";
    EXPECT_EQ(book.longest_silent(PeerBook::Rank::trusted, start + 4s), c);
    EXPECT_EQ(book.longest_silent(PeerBook::Rank::commands, start + 4s), c);
    EXPECT_EQ(book.longest_silent(PeerBook::Rank::ordinary, start + 4s), std::nullopt);
    EXPECT_EQ(book.longest_silent(PeerBook::Rank::ordinary, start + 61s), c);
}

}    // namespace
}    // namespace anogate::peer_book_tests
