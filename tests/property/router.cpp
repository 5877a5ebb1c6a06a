// The router compared with the rules of config/README.md, recomputed for every frame from the whole input.
#include <gateway/router.hpp>

#include <support/allocations.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

namespace router_tests {

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

    struct Claim {
        ChannelId by;
        TimePoint heard;
    };
    std::map<std::uint8_t, Claim> claims;    // of addresses that were not heard at home since
    std::map<std::uint8_t, TimePoint> next_claim;
    std::map<std::uint8_t, LinkId> left;    // the link of an address whose only channel was closed

    void receive(ChannelId from, std::uint8_t source, TimePoint now) {
        if (source == 0x00 || source == 0xFF) return;
        Open& channel = channels[from];
        if (const auto found = pinned.find(source); found != pinned.end() && !found->second.contains(channel.link)) return;
        const bool at_home = age(channel, source, now).has_value() || homes(source, channel.link, now).empty();
        if (at_home || ano::address::is_host(source)) {
            channel.heard.push_back({source, now});
            const auto claim = claims.find(source);
            if (claim != claims.end() && homes(source, channels[claim->second.by].link, now).contains(from)) claims.erase(claim);
        } else if (const auto claim = claims.find(source); claim != claims.end()) {
            if (claim->second.by == from) claim->second.heard = now;
        } else if (!next_claim.contains(source) || now >= next_claim[source]) {
            claims[source] = {from, now};
            next_claim[source] = now + 10s;
        }
    }
    void close(ChannelId id, TimePoint now) {
        for (const std::uint8_t a : addresses)
            if (heard_within(Duration::max(), a, now) == ChannelSet{id}) left[a] = channels[id].link;
        channels.erase(id);
        std::erase_if(claims, [&](const auto& claim) { return claim.second.by == id; });
        std::erase_if(claims, [&](const auto& claim) {
            const auto& [source, its] = claim;
            if (!homes(source, channels[its.by].link, now).empty()) return false;
            channels[its.by].heard.push_back({source, its.heard});
            return true;
        });
    }
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
    /// The channels of the source's home; of a pinned address, those on this link.
    ChannelSet homes(std::uint8_t source, LinkId link, TimePoint now) const {
        ChannelSet all = heard_within(Duration::max(), source, now);
        for (const auto& [id, channel] : channels)
            if (pinned.contains(source) && channel.link != link) all.erase(id);
        return all;
    }
    Route to_pinned(std::uint8_t destination, LinkSet links, TimePoint now) const {
        Route route = to(links, Via::pinned);
        for (const auto& [id, channel] : channels)
            if (const ChannelSet at_home = homes(destination, channel.link, now); !at_home.empty() && !at_home.contains(id))
                route.channels.erase(id);
        return route;
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
    bool brings(const Open& channel, bool hosts) const {
        return std::ranges::any_of(channel.heard,
                                   [&](const Heard& heard) { return ano::address::is_host(heard.source) == hosts; });
    }
    /// The channels with devices; `alone`: only those without a host.
    ChannelSet with_devices(bool alone) const {
        ChannelSet set;
        for (const auto& [id, channel] : channels)
            if (brings(channel, false) && !(alone && brings(channel, true))) set.insert(id);
        return set;
    }
    Route last_home(std::uint8_t destination, TimePoint now) const {
        if (const ChannelSet known = heard_within(Duration::max(), destination, now); !known.empty())
            return {known, {}, Via::learned};
        Route route;
        if (const auto found = left.find(destination); found != left.end()) {
            route = to(LinkSet{found->second}, Via::learned);
            route.channels -= with_devices(true);
        }
        return route;
    }
    Route flooded(std::uint8_t destination, bool acts) const {
        Route route = all(&Router::LinkRule::flood, Via::unknown);
        const bool host = destination == 0xFE || destination == 0xD2;
        if (host || (acts && with_devices(false).has_several())) route.channels -= with_devices(true);
        return route;
    }
    Route expected(std::uint8_t destination, bool acts, TimePoint now) const {
        if (destination == 0xFF) return all(&Router::LinkRule::broadcast, Via::broadcast);
        if (destination == 0) return {};
        if (destination == settings.id) return {{}, {}, Via::own};
        LinkSet bearers;
        for (unsigned n = 0; n < rules.size(); ++n)
            if (rules[n].port_id == destination) bearers.insert(static_cast<LinkId>(n));
        if (!bearers.empty()) return to(bearers, Via::port);
        if (const auto found = pinned.find(destination); found != pinned.end()) return to_pinned(destination, found->second, now);
        const bool host = destination == 0xFE || destination == 0xD2;
        ChannelSet heard = heard_within(host ? Duration::max() : settings.forget_after, destination, now);
        if (!host) {
            const ChannelSet lately = heard_within(std::min<Duration>(3s, settings.forget_after), destination, now);
            if (!lately.empty()) heard = lately;
        }
        if (!heard.empty()) return {heard, {}, Via::learned};
        if (acts && !host)
            if (Route last = last_home(destination, now); last.via == Via::learned) return last;
        if (settings.unknown == Unknown::flood) return flooded(destination, acts);
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
            const Router::LinkRule rule{
                .port_id = static_cast<std::uint8_t>(n == 2 ? 3 : 0), .flood = !random.one_in(4), .broadcast = !random.one_in(4)};
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
        if (model.channels.contains(id)) {
            model.close(id, now);
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
        const ChannelId from = it->first;
        const std::uint8_t source = addresses[random.below(std::size(addresses))];
        const std::uint8_t destination = addresses[random.below(std::size(addresses))];
        if (source == destination) return;    // a host and a device with one address: see unit/gateway/router_acts.cpp
        model.receive(from, source, now);

        const auto before = support::allocations;
        const bool acts = random.one_in(2) && !ano::address::is_host(destination);
        const Route got = router->route(from, source, destination, now, acts ? ano::Intent::acts : ano::Intent::informs);
        EXPECT_EQ(support::allocations, before);

        Route expected = model.expected(destination, acts, now);
        expected.channels.erase(from);
        EXPECT_FALSE(got.channels.contains(from));
        EXPECT_EQ(got.channels, expected.channels) << "destination " << int{destination} << " via " << text(got.via);
        EXPECT_EQ(got.absent, expected.absent);
        EXPECT_EQ(text(got.via), text(expected.via));
        for (const std::uint8_t a : addresses) {
            const bool known =
                !model.heard_within(ano::address::is_host(a) ? Duration::max() : model.settings.forget_after, a, now).empty();
            EXPECT_EQ(router->learned(a, now).links.empty(), !known);
        }
    }

    support::Random random;
    Model model;
    std::unique_ptr<Router> router;
    TimePoint now{};
};

TEST(Router, routes_every_frame_as_the_rules_require) {
    for (std::uint64_t seed = 1; seed <= support::trials(150) && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        Trial trial{seed};
        for (int step = 0; step < 400 && !testing::Test::HasFailure(); ++step) {
            if (trial.random.one_in(12) || trial.model.channels.size() < 2) trial.toggle_channel();
            if (trial.random.one_in(2)) trial.now += trial.random.of<Duration>({1ms, 400ms, 1s, 1s, 3s, 7s, 31s});
            trial.frame();
        }
    }
}

// An address has one home: its first channel, unless that was silent for three questions, or lost its link and was not heard
// since.
TEST(Router, moves_an_address_only_after_silence) {
    for (std::uint64_t seed = 1; seed <= support::trials(60) && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        support::Random random{seed};
        auto router = std::make_unique<Router>(GatewaySettings{});
        for (unsigned n = 0; n < 4; ++n) router->open(static_cast<ChannelId>(n), router->add_link({}));
        std::array<bool, 4> down{};
        constexpr unsigned nobody = 4;
        std::optional<unsigned> home, claimant;
        unsigned first = nobody;
        std::array<TimePoint, 4> heard{};
        TimePoint now{}, began = TimePoint::min(), refused_at{};
        std::uint64_t refused = 0;
        const auto move = [&](unsigned to) {
            if (first == to) first = nobody;
            else if (first == nobody) first = home.value_or(nobody);
            home = to;
        };
        const auto refuse = [&] {
            ++refused;
            refused_at = now;
        };
        for (int step = 0; step < 300; ++step) {
            const TimePoint next = now + random.of<Duration>({1ms, 500ms, 500ms, 2s, 4s});
            while (router->next_question().value_or(TimePoint::max()) <= next) {    // the gateway checks in time
                now = *router->next_question();
                while (const auto question = router->pop_question(now))
                    EXPECT_EQ(question->channels, ChannelSet{static_cast<ChannelId>(*home)});
                if (claimant && now == began + 3s) move(*std::exchange(claimant, std::nullopt));
            }
            now = next;
            const unsigned n = random.below(4u);
            if (random.one_in(6)) {
                down[n] = !down[n];
                down[n] ? router->went_down(static_cast<ChannelId>(n)) : router->came_up(static_cast<ChannelId>(n));
                if (claimant && down[*home]) move(*std::exchange(claimant, std::nullopt));
                continue;
            }
            if (down[n]) continue;
            if (!home) {
                home = n;
            } else if (n != home && (down[*home] || first == n)) {
                if (!down[*home] && now - heard[*home] < 3s) refuse();
                move(n);
            }
            if (n == home || !claimant || claimant == n) heard[n] = now;
            if (n == home) {
                if (std::exchange(claimant, std::nullopt)) refuse();
            } else if (!claimant && (began == TimePoint::min() || now - began >= 10s)) {
                claimant = n;
                began = now;
            }
            const auto before = support::allocations;
            router->route(static_cast<ChannelId>(n), 0xDE, 0xFF, now);
            EXPECT_EQ(support::allocations, before);
            ASSERT_TRUE(router->holds(0xDE, static_cast<ChannelId>(*home)));
            for (unsigned other = 0; other < 4; ++other)
                EXPECT_EQ(router->holds(0xDE, static_cast<ChannelId>(other)), other == home);
            EXPECT_EQ(router->next_question().has_value(), claimant.has_value());
            const auto found = router->conflicts(now);
            if (!found.empty()) EXPECT_EQ(found[0].count, refused);
            else EXPECT_TRUE(refused == 0 || now - refused_at >= 30s);
        }
    }
}

}    // namespace
}    // namespace router_tests
