// The router against the rules as the README tells them, worked out anew for every frame from all that ever came.
#include <gateway/router.hpp>

#include <support/allocations.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <optional>

using namespace anogate;
using namespace std::chrono_literals;

namespace {

constexpr std::uint8_t addresses[] = {0x00, 3, 7, 21, 30, 0xDC, 0xDE, 0xD2, 0xFE, 0xFF};
constexpr unsigned link_count = 5;
constexpr unsigned channel_count = 9;

struct Model {
    struct Heard {
        std::uint8_t source;
        TimePoint at;
    };
    struct Open {
        LinkId link;
        std::vector<Heard> heard;
    };

    GatewaySettings settings;
    LinkSet unknown_link;
    std::vector<Router::LinkRule> rules;
    std::map<std::uint8_t, LinkSet> pinned;
    std::map<ChannelId, Open> channels;

    std::optional<Duration> age(const Open& channel, std::uint8_t source, TimePoint now) const {
        std::optional<Duration> age;
        for (const Heard& heard : channel.heard)
            if (heard.source == source) age = now - heard.at;
        return age;
    }
    ChannelSet heard_within(Duration limit, std::uint8_t source, TimePoint now) const {
        ChannelSet set;
        for (const auto& [id, channel] : channels)
            if (const auto a = age(channel, source, now); a && *a < limit) set.insert(id);
        return set;
    }
    Route to(LinkSet links, Via via) const {
        Route route{{}, links, via};
        for (const auto& [id, channel] : channels) {
            if (!links.contains(channel.link)) continue;
            route.channels.insert(id);
            route.absent.erase(channel.link);
        }
        return route;
    }
    Route all(bool Router::LinkRule::*which, Via via) const {
        Route route{{}, {}, via};
        for (const auto& [id, channel] : channels)
            if (rules[index(channel.link)].*which) route.channels.insert(id);
        return route;
    }
    Route expected(std::uint8_t destination, TimePoint now) const {
        if (destination == 0xFF) return all(&Router::LinkRule::broadcast, Via::broadcast);
        if (destination == 0) return {};
        if (destination == settings.id) return {{}, {}, Via::own};
        LinkSet bearers;
        for (unsigned n = 0; n < rules.size(); ++n)
            if (rules[n].port_id == destination) bearers.insert(static_cast<LinkId>(n));
        if (!bearers.empty()) return to(bearers, Via::port);
        if (const auto found = pinned.find(destination); found != pinned.end()) return to(found->second, Via::pinned);
        const bool host = destination == 0xFE || destination == 0xD2;
        ChannelSet heard = heard_within(host ? Duration::max() : settings.forget_after, destination, now);
        if (!host) {
            const ChannelSet lately = heard_within(std::min<Duration>(3s, settings.forget_after), destination, now);
            if (!lately.empty()) heard = lately;
        }
        if (!heard.empty()) return {heard, {}, Via::learned};
        if (settings.unknown == Unknown::flood) return all(&Router::LinkRule::flood, Via::unknown);
        if (settings.unknown == Unknown::link) return to(unknown_link, Via::unknown);
        return {};
    }
};

struct Trial {
    explicit Trial(std::uint64_t seed) : random{seed} {
        auto& settings = model.settings;
        settings.unknown = random.of({Unknown::flood, Unknown::drop, Unknown::link});
        settings.id = random.of<std::uint8_t>({0, 21});
        settings.forget_after = random.of<Duration>({1s, 5s, 30s});
        router = std::make_unique<Router>(settings);
        for (unsigned n = 0; n < link_count; ++n) {
            const Router::LinkRule rule{.port_id = static_cast<std::uint8_t>(n == 2 ? 3 : 0),
                                        .flood = !random.one_in(4),
                                        .broadcast = !random.one_in(4)};
            model.rules.push_back(rule);
            EXPECT_EQ(index(router->add_link(rule)), n);
        }
        for (unsigned pins = random.below(3u); pins > 0; --pins) {
            const LinkId to = static_cast<LinkId>(random.below(link_count));
            router->pin(30, 30, to);
            model.pinned[30].insert(to);
        }
        if (settings.unknown == Unknown::link) {
            const LinkId to = static_cast<LinkId>(random.below(link_count));
            router->set_unknown_link(to);
            model.unknown_link = to;
        }
    }

    void toggle_channel() {
        const auto id = static_cast<ChannelId>(random.below(channel_count));
        if (model.channels.erase(id) > 0) {
            router->close(id);
        } else {
            const auto link = static_cast<LinkId>(random.below(link_count));
            router->open(id, link);
            model.channels[id] = {link, {}};
        }
    }
    void frame() {
        if (model.channels.empty()) return;
        auto it = model.channels.begin();
        std::advance(it, static_cast<long>(random.below(model.channels.size())));
        auto& [from, channel] = *it;
        const std::uint8_t source = addresses[random.below(std::size(addresses))];
        const std::uint8_t destination = addresses[random.below(std::size(addresses))];
        if (source != 0x00 && source != 0xFF) channel.heard.push_back({source, now});

        const auto before = support::allocations;
        const Route got = router->route(from, source, destination, now);
        EXPECT_EQ(support::allocations, before);

        Route expected = model.expected(destination, now);
        expected.channels.erase(from);
        EXPECT_FALSE(got.channels.contains(from));
        EXPECT_EQ(got.channels, expected.channels) << "destination " << int{destination} << " via " << text(got.via);
        EXPECT_EQ(got.absent, expected.absent);
        EXPECT_EQ(text(got.via), text(expected.via));
        for (const std::uint8_t a : addresses) {
            const bool known =
                !model.heard_within(ano::address::is_host(a) ? Duration::max() : model.settings.forget_after, a, now)
                     .empty();
            EXPECT_EQ(router->learned(a, now).links.empty(), !known);
        }
    }

    support::Random random;
    Model model;
    std::unique_ptr<Router> router;
    TimePoint now{};
};

}    // namespace

TEST(Router, decides_as_the_rules_say) {
    for (std::uint64_t seed = 1; seed <= 150 && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        Trial trial{seed};
        for (int step = 0; step < 400 && !testing::Test::HasFailure(); ++step) {
            if (trial.random.one_in(12) || trial.model.channels.size() < 2) trial.toggle_channel();
            if (trial.random.one_in(2)) trial.now += trial.random.of<Duration>({1ms, 400ms, 1s, 1s, 3s, 7s, 31s});
            trial.frame();
        }
    }
}

// A conflict exactly when another link heard the source within the last three seconds and has not been down since.
TEST(Router, tells_two_devices_from_one_that_moved) {
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        support::Random random{seed};
        auto router = std::make_unique<Router>(GatewaySettings{});
        struct Line {
            TimePoint heard = TimePoint::min();
        };
        std::array<Line, 4> lines;
        for (unsigned n = 0; n < lines.size(); ++n) router->open(static_cast<ChannelId>(n), router->add_link({}));
        TimePoint now{};
        std::uint64_t conflicts = 0;
        for (int step = 0; step < 200; ++step) {
            now += random.of<Duration>({1ms, 500ms, 2s, 4s});
            const unsigned n = random.below(4u);
            if (random.one_in(3)) {
                router->went_down(static_cast<ChannelId>(n), now);
                lines[n].heard = TimePoint::min();
                continue;
            }
            lines[n].heard = now;
            int others = 0;
            for (const Line& line : lines) others += line.heard != TimePoint::min() && now - line.heard < 3s;
            conflicts += others > 1;
            router->route(static_cast<ChannelId>(n), 0xDE, 0xFF, now);
            const auto found = router->conflicts(now);
            if (others > 1) {
                ASSERT_EQ(found.size(), 1u);
            }
            if (!found.empty()) {
                ASSERT_EQ(found[0].count, conflicts);
            }
        }
    }
}
