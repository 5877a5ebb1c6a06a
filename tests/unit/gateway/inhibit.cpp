#include <ano/conversation.hpp>
#include <gateway/inhibit.hpp>
#include <gateway/tunnel/tunnel.hpp>
#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <set>

namespace inhibit_tests {

using namespace anogate;
using support::Bytes;
using support::operator+;

namespace {

bool control(std::uint8_t id, const Bytes& data = {}) {
    const Bytes bytes = support::frame(0xFE, 0xDC, id, data);
    return ano::is_control(ano::FrameView{bytes});
}

Bytes tunnel(const Bytes& inner, std::uint8_t id = 0xB1) {
    return support::frame(0xFE, 0xE6, id, Bytes(id == 0xB1 ? 10 : 4) + inner);
}
bool brings(const Bytes& bytes) { return may_contain(ano::FrameView{bytes}, ano::is_control); }

const Bytes command = support::frame(0xFE, 0xDC, 0xC0, {1, 2, 3});
const Bytes attitude = support::frame(0xDC, 0xFE, 0x03, Bytes(7));

TEST(Inhibit, control_frames_have_exactly_the_listed_ids) {
    std::set<int> ids;
    for (int id = 0; id < 256; ++id)
        if (control(static_cast<std::uint8_t>(id), {0, 0, 0})) ids.insert(id);
    EXPECT_EQ(ids, (std::set<int>{0x40, 0x41, 0x61, 0xC0, 0xE1, 0xF0}));
}

TEST(Inhibit, a_parameter_command_is_control_unless_it_is_a_read_request) {
    for (std::uint8_t question = 0; question <= 3; ++question) EXPECT_FALSE(control(0xE0, {question, 0, 0})) << int{question};
    EXPECT_TRUE(control(0xE0, {0x10, 0xAA, 0})) << "restore defaults";
    EXPECT_TRUE(control(0xE0, {0x10, 0x20, 0})) << "clear the calibration";
    for (int other = 4; other < 256; ++other)
        EXPECT_TRUE(control(0xE0, {static_cast<std::uint8_t>(other), 0, 0})) << "what it does is not known: " << other;
    EXPECT_TRUE(control(0xE0)) << "says nothing";
}

TEST(Inhibit, a_tunnel_frame_with_a_control_frame_inside_counts_as_control) {
    for (const std::uint8_t id : {std::uint8_t{0xB1}, std::uint8_t{0xB2}}) {
        EXPECT_TRUE(brings(tunnel(command, id)));
        EXPECT_TRUE(brings(tunnel(attitude + command, id)));
        EXPECT_FALSE(brings(tunnel(attitude + attitude, id)));
        EXPECT_FALSE(brings(tunnel({}, id)));
    }
    EXPECT_FALSE(brings(attitude));
    EXPECT_FALSE(brings(command)) << "no tunnel frame: is_control() judges it";
}

TEST(Inhibit, a_tunnel_frame_that_cannot_be_parsed_counts_as_control) {
    EXPECT_TRUE(brings(tunnel(Bytes{0x00} + command))) << "a device may find the frame behind other bytes";
    EXPECT_TRUE(brings(tunnel(attitude + Bytes{0xAB})));
    EXPECT_TRUE(brings(tunnel(tunnel(attitude))));
    EXPECT_TRUE(brings(support::frame(0xFE, 0xE6, 0xB1, Bytes(9)))) << "shorter than its addresses";
}

TEST(Inhibit, a_switch_is_on_until_it_is_read) {
    Inhibit inhibit;
    EXPECT_TRUE(inhibit.links().empty());
    const std::size_t place = inhibit.add(LinkId{3});
    EXPECT_EQ(inhibit.links(), LinkSet{LinkId{3}});
    inhibit.set(place, false);
    EXPECT_TRUE(inhibit.links().empty());
    EXPECT_FALSE(inhibit.is_on(place));
}

TEST(Inhibit, one_of_two_switches_is_enough_to_inhibit_a_link) {
    Inhibit inhibit;
    const std::size_t first = inhibit.add(LinkSet{LinkId{1}} | LinkSet{LinkId{2}});
    const std::size_t second = inhibit.add(LinkId{2});
    inhibit.set(first, false);
    EXPECT_EQ(inhibit.links(), LinkSet{LinkId{2}});
    inhibit.set(second, false);
    EXPECT_TRUE(inhibit.links().empty());
    inhibit.set(first, true);
    EXPECT_EQ(inhibit.links(), LinkSet{LinkId{1}} | LinkSet{LinkId{2}});
}

TEST(Inhibit, a_switch_stays_for_its_other_links_when_one_is_removed) {
    Inhibit inhibit;
    const std::size_t place = inhibit.add(LinkSet{LinkId{1}} | LinkSet{LinkId{2}});
    inhibit.remove_link(LinkId{1});
    EXPECT_EQ(inhibit.links(), LinkSet{LinkId{2}});
    inhibit.set(place, false);
    inhibit.set(place, true);
    EXPECT_EQ(inhibit.links(), LinkSet{LinkId{2}}) << "what gets its number is not kept off";
}

TEST(Inhibit, switches_can_be_added_removed_and_moved_to_other_links) {
    constexpr LinkId a{1}, b{2};
    Inhibit inhibit;
    const std::size_t first = inhibit.add(a), second = inhibit.add(b);
    inhibit.set_links(first, b);
    EXPECT_EQ(inhibit.links(), LinkSet{b});
    inhibit.set(second, false);
    inhibit.set_links(second, a);
    EXPECT_EQ(inhibit.links(), LinkSet{b}) << "it is off";
    inhibit.remove(first);
    EXPECT_TRUE(inhibit.links().empty());
    EXPECT_EQ(inhibit.add(a), first) << "its place is free";
    EXPECT_EQ(inhibit.links(), LinkSet{a}) << "and it is on until it is set off";
}

}    // namespace
}    // namespace inhibit_tests
