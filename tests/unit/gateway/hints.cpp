#include <gateway/hints.hpp>

#include <gtest/gtest.h>

namespace anogate {
namespace {

LinkFigures line_that_sent(std::uint64_t frames) {
    LinkFigures link{};
    link.kind = "serial";
    link.up = true;
    link.received.frames_in = link.received.bytes_in = 1000;
    link.sent.frames_out = frames;
    return link;
}

TEST(Hint, a_link_too_slow_for_what_is_sent_is_named_whatever_the_cause_of_the_drops) {
    for (const auto cause : {&SendCounters::superseded, &SendCounters::stale, &SendCounters::queue_full}) {
        LinkFigures link = line_that_sent(100);
        link.sent.*cause = 10;
        EXPECT_EQ(hint(link), "") << "one in ten is no news";
        link.sent.*cause = 11;
        EXPECT_EQ(hint(link), "frames are dropped: the link is slower than what is sent to it");
        link.sent.frames_out = 0;
        EXPECT_EQ(hint(link), "frames are dropped: the link is slower than what is sent to it");
    }
}

TEST(Hint, what_filters_and_limits_keep_back_is_meant_so) {
    LinkFigures link = line_that_sent(1);
    link.sent.limited = link.sent.denied_out = 1000;
    EXPECT_EQ(hint(link), "");
}

TEST(Hint, strangers_and_their_tricks_are_named) {
    LinkFigures link = line_that_sent(1000);
    link.kind = "udp-listen";
    link.listens = true;
    link.channels = 1;
    link.sent.held_back = 1;
    EXPECT_NE(hint(link).find("`trusted`"), std::string::npos);
    link.no_place = 1;
    EXPECT_NE(hint(link).find("max_per_address"), std::string::npos);
    link.gateways = 1;
    EXPECT_NE(hint(link).find("a udp: link"), std::string::npos) << "the one that tells most";
}

}  // namespace
}  // namespace anogate
