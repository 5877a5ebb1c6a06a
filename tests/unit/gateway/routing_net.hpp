// A Router with links and channels, and the time.
#pragma once
#include <gateway/router.hpp>

#include <gtest/gtest.h>

#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

namespace routing {

using namespace anogate;
using namespace std::chrono_literals;

template <class Change>
GatewaySettings settings(Change change) {
    GatewaySettings result;
    change(result);
    return result;
}

// One channel per link and the requested number of links; a test may add more.
struct Net {
    explicit Net(const GatewaySettings& gateway = {}, std::vector<Router::LinkRule> rules = {{}, {}, {}, {}})
        : router{std::make_unique<Router>(gateway)} {
        for (const auto& rule : rules) {
            const LinkId link = router->add_link(rule);
            router->open(static_cast<ChannelId>(index(link)), link);
        }
    }
    Route route(unsigned from, std::uint8_t source, std::uint8_t destination) {
        return router->route(static_cast<ChannelId>(from), source, destination, now);
    }
    /// The addresses that are asked now, and on which channels.
    std::vector<std::pair<int, ChannelSet>> asked() {
        std::vector<std::pair<int, ChannelSet>> all;
        while (const auto question = router->pop_question(now)) all.emplace_back(question->address, question->channels);
        return all;
    }
    /// All pending claims end without an answer.
    void silence() {
        for (asked(); router->next_question(); asked()) now = *router->next_question();
    }
    Router* operator->() const { return router.get(); }

    std::unique_ptr<Router> router;
    TimePoint now{};
};

inline ChannelSet channels(std::initializer_list<unsigned> numbers) {
    ChannelSet set;
    for (const unsigned n : numbers) set.insert(static_cast<ChannelId>(n));
    return set;
}
inline LinkSet links(std::initializer_list<unsigned> numbers) {
    LinkSet set;
    for (const unsigned n : numbers) set.insert(static_cast<LinkId>(n));
    return set;
}
constexpr LinkId link(unsigned n) { return static_cast<LinkId>(n); }
constexpr ChannelId channel(unsigned n) { return static_cast<ChannelId>(n); }

inline void expect(const Route& route, ChannelSet to, Via via, LinkSet absent = {}) {
    EXPECT_EQ(route.channels, to);
    EXPECT_EQ(text(route.via), text(via));
    EXPECT_EQ(route.absent, absent);
}

}    // namespace routing
