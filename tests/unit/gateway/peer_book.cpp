// How long a peer of a listening socket stays: arithmetic on what was heard and what was refused.
#include <gateway/peer_book.hpp>

#include <gtest/gtest.h>

namespace anogate {
namespace {

using namespace std::chrono_literals;

constexpr std::uint8_t host = 0xFE, ros = 0xD2, device = 0xDC;
constexpr ChannelId a{3}, b{4}, c{5}, d{6};
const TimePoint start = TimePoint{} + 1h;

Endpoint at(const char* text) { return *Endpoint::parse(text); }
const Endpoint phone = at("192.168.1.20:5000"), phone_again = at("192.168.1.20:5001"), phone_anew = at("192.168.1.20:5002");
const Endpoint laptop = at("192.168.1.30:5000");

struct Book : PeerBook {
    explicit Book(Duration timeout = 60s) : PeerBook{{timeout}} {}
    void join(ChannelId id, const Endpoint& endpoint, std::uint8_t source, TimePoint now, bool near = true) {
        add(id, endpoint, near, now);
        heard(id, source, now);
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

TEST(PeerBook, a_peer_that_never_brought_its_frame_is_overdue_like_any_other) {
    Book book;
    book.add(a, phone, true, start);
    EXPECT_EQ(book.overdue(start + 60s), ChannelSet{a});
}

TEST(PeerBook, a_host_of_our_networks_that_only_listens_stays_an_hour) {
    for (const std::uint8_t source : {host, ros}) {
        Book book;
        book.join(a, phone, source, start);
        EXPECT_TRUE(book.overdue(start + 61s).empty());
        EXPECT_EQ(book.next_look(start), start + 60s) << "whether it is one of the latest two";
        EXPECT_EQ(book.next_look(start + 60s), start + 1h);
        EXPECT_TRUE(book.overdue(start + 1h - 1ns).empty());
        EXPECT_EQ(book.overdue(start + 1h), ChannelSet{a});
    }
}

TEST(PeerBook, one_frame_of_a_host_among_those_of_devices_is_enough) {
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

TEST(PeerBook, of_the_silent_ones_of_an_address_the_two_latest_stay) {
    Book book;
    book.join(a, phone, host, start);
    book.join(b, phone_again, host, start + 1s);
    book.join(c, phone_anew, host, start + 2s);
    book.join(d, laptop, host, start);
    EXPECT_TRUE(book.overdue(start + 61s).empty()) << "the third is not silent yet";
    EXPECT_EQ(book.next_look(start + 61s), start + 62s);
    EXPECT_EQ(book.overdue(start + 62s), ChannelSet{a}) << "and another address has places of its own";
    book.heard(a, host, start + 62s);
    EXPECT_TRUE(book.overdue(start + 62s).empty()) << "it was heard, and is silent no more";
    book.remove(b);
    EXPECT_TRUE(book.overdue(start + 10min).empty());
}

TEST(PeerBook, of_those_heard_at_the_same_time_two_stay) {
    Book book;
    for (const ChannelId id : {a, b, c, d}) book.join(id, phone, host, start);
    EXPECT_EQ(book.overdue(start + 60s).size(), 2u);
}

TEST(PeerBook, a_device_takes_no_place_of_a_silent_host) {
    Book book;
    book.join(a, phone, host, start);
    book.join(b, phone_again, device, start + 1s);
    book.join(c, phone_anew, device, start + 2s);
    EXPECT_EQ(book.overdue(start + 5min), ChannelSet{b} | ChannelSet{c});
}

TEST(PeerBook, three_refusals_over_five_seconds_end_it) {
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

TEST(PeerBook, two_refusals_are_not_enough_however_long_between_them) {
    Book book;
    book.join(a, phone, host, start);
    EXPECT_FALSE(book.refused(a, start));
    EXPECT_FALSE(book.refused(a, start + 20min));
    EXPECT_TRUE(book.overdue(start + 20min).empty());
}

TEST(PeerBook, a_frame_of_the_peer_makes_refusals_count_from_the_beginning) {
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

TEST(PeerBook, a_number_used_again_begins_anew) {
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

}  // namespace
}  // namespace anogate
