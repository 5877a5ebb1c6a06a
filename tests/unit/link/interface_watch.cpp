#include <link/interface_watch.hpp>

#include <support/link_host.hpp>
#include <support/settings.hpp>

#include <gtest/gtest.h>

#include <net/if.h>

#include <string>

namespace {

unsigned interface_now = 0;    // the number of any interface; 0: it does not exist

}    // namespace

// Replaces libc's function: no test here has interfaces that appear and disappear.
extern "C" unsigned if_nametoindex(const char*) noexcept { return interface_now; }

namespace interface_watch_tests {
namespace {

using namespace anogate;
using support::endpoint;

struct WatchedInterface : testing::Test {
    WatchedInterface() { interface_now = 7; }

    /// Counts its events, and stores the last one.
    struct Watch {
        explicit Watch(const LinkContext& context)
            : looks{context, [this](const LinkError& why) {
                        ++told;
                        words = why.text;
                    }} {}
        int told = 0;
        std::string words;
        InterfaceWatch looks;
    };
    /// A watch that was started before `watch` has checked as well by then.
    void until_told(const Watch& watch) {
        EXPECT_TRUE(host.until([&] { return watch.told > 0; }));
        host.io.poll();
    }

    support::BareLinkHost host;
    const EndpointSpec here = endpoint("[fe80::1%eth0]:12333"), nowhere = endpoint("[::1]:12333");
};

TEST_F(WatchedInterface, is_reported_once_when_another_interface_has_its_name) {
    Watch stopped{host.context()}, unnamed{host.context()}, watch{host.context()};
    stopped.looks.start(here);
    stopped.looks.stop();
    unnamed.looks.start(nowhere);
    watch.looks.start(here);
    interface_now = 8;
    until_told(watch);
    EXPECT_EQ(watch.told, 1);
    EXPECT_EQ(watch.words, "network interface eth0 was replaced by another one");
    EXPECT_EQ(stopped.told, 0);
    EXPECT_EQ(unnamed.told, 0);
}

TEST_F(WatchedInterface, is_reported_when_it_is_lost_but_not_while_it_exists) {
    Watch before{host.context()}, watch{host.context()};
    before.looks.start(here);
    interface_now = 9;
    watch.looks.start(here);
    until_told(before);    // so the other one has checked as well
    EXPECT_EQ(watch.told, 0);
    interface_now = 0;
    until_told(watch);
    EXPECT_EQ(watch.words, "network interface eth0 not found");
}

}    // namespace
}    // namespace interface_watch_tests
