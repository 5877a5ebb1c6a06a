// The overdue peers of a listening socket, recomputed from the whole input.
#include <gateway/peers/peer_book.hpp>

#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <tuple>
#include <vector>

namespace peer_book_tests {

using namespace anogate;
using namespace std::chrono_literals;

namespace {

constexpr Duration timeout = 60s;

struct Model {
    struct Peer {
        IpAddress address;
        bool near;
        bool host = false;
        TimePoint heard, first;
        bool once = true;
        bool returned = false;    // it sent in a later exchange too
        bool trusted = false, commands = false;
        std::vector<TimePoint> refused{};    // since it was last heard
    };
    std::map<ChannelId, Peer> peers;

    static bool dead(const Peer& p) {
        if (p.refused.empty()) return false;
        return p.once || (p.refused.size() >= 3 && p.refused.back() - p.refused.front() >= 5s);
    }
    static bool is_brief(const Peer& p) { return p.near && (p.host ? !p.returned : p.once); }
    ChannelSet overdue(TimePoint now) const {
        ChannelSet result;
        std::map<std::string, std::vector<std::tuple<bool, TimePoint, ChannelId>>> listeners;    // silent ones, by address
        std::vector<std::tuple<int, TimePoint, ChannelId>> brief;
        for (const auto& [id, p] : peers) {
            const Duration silent = now - p.heard, patience = is_brief(p) ? Duration{10s} : timeout;
            const bool listens = p.near && p.host;
            if (dead(p) || silent >= (listens ? Duration{1h} : patience)) result.insert(id);
            if (listens && !dead(p) && silent >= patience) listeners[p.address.text()].push_back({false, p.heard, id});
        }
        for (auto& [address, all] : listeners) {
            std::sort(all.rbegin(), all.rend());
            for (std::size_t i = 1; i < all.size(); ++i) std::get<bool>(all[i]) = peers.at(std::get<ChannelId>(all[i])).returned;
            std::sort(all.begin() + 1, all.end(), std::greater<>{});    // behind the latest
            for (std::size_t i = 2; i < all.size(); ++i) result.insert(std::get<ChannelId>(all[i]));
            for (std::size_t i = 0; i < std::min<std::size_t>(2, all.size()); ++i) {
                const auto& [again, heard, id] = all[i];
                const Peer& p = peers.at(id);
                if (!p.returned) brief.push_back({p.trusted ? 0 : p.commands ? 1 : 2, heard, id});
            }
        }
        std::sort(brief.begin(), brief.end());
        for (std::size_t i = 8; i < brief.size(); ++i) result.insert(std::get<ChannelId>(brief[i]));
        return result;
    }
};

TEST(PeerBook, lists_the_overdue_peers_after_any_input) {
    for (std::uint64_t seed = 0; seed < support::trials(60); ++seed) {
        support::Random random{seed};
        PeerBook book{{timeout}};
        Model model;
        TimePoint now = TimePoint{} + 10h;
        for (int step = 0; step < 400; ++step) {
            now += random.of({Duration{0}, Duration{1ms}, Duration{700ms}, Duration{3s}, Duration{40s}, Duration{11min}});
            const auto id = static_cast<ChannelId>(random.below(20u));
            const bool known = model.peers.contains(id);
            if (!known) {
                const Endpoint endpoint{
                    IpAddress::v4(10, 0, 0, static_cast<std::uint8_t>(random.below(random.one_in(2) ? 3u : 12u))), 5000};
                const bool near = !random.one_in(4);
                const bool trusted = random.one_in(5);
                book.add(id, endpoint, near, now, trusted ? PeerBook::Rank::trusted : PeerBook::Rank::ordinary);
                model.peers[id] = {endpoint.address, near, false, now, now};
                model.peers[id].trusted = trusted;
            } else if (random.one_in(3)) {
                const auto source = random.of<std::uint8_t>({0xFE, 0xD2, 0xDC, 0x20});
                if (random.one_in(2)) {
                    book.came(id);
                    model.peers[id].once = false;
                }
                book.heard(id, source, now);
                model.peers[id].heard = now;
                model.peers[id].returned |= now - model.peers[id].first >= 1s;
                model.peers[id].host |= source == 0xFE || source == 0xD2;
                model.peers[id].refused.clear();
                if (source == 0xFE && random.one_in(3)) {
                    book.commanded(id, now);
                    model.peers[id].commands = true;
                }
            } else if (random.one_in(2)) {
                model.peers[id].refused.push_back(now);
                ASSERT_EQ(book.refused(id, now), Model::dead(model.peers[id])) << seed << " " << step;
            } else if (random.one_in(4)) {
                book.remove(id);
                model.peers.erase(id);
            }
            ASSERT_EQ(book.overdue(now), model.overdue(now)) << seed << " " << step;
            // No peer becomes overdue before the next check.
            const TimePoint look = book.next_look(now);
            if (!book.overdue(now).empty()) continue;
            ASSERT_GT(look, now) << seed << " " << step;
            if (look != TimePoint::max()) {
                ASSERT_TRUE(model.overdue(look - 1ns).empty()) << seed << " " << step;
            }
            if (random.one_in(2)) continue;
            for (const ChannelId gone : book.overdue(now)) {
                book.remove(gone);
                model.peers.erase(gone);
            }
        }
    }
}

TEST(PeerBook, removes_no_peer_that_is_entitled_to_its_connection_quota) {
    for (std::uint64_t seed = 0; seed < support::trials(60); ++seed) {
        support::Random random{seed};
        const std::size_t most = 1 + random.below(8u), max_of_address = 1 + random.below(4u);
        PeerBook book{{timeout, most, max_of_address}};
        struct Peer {
            Endpoint endpoint;
            TimePoint began, heard;
            bool again = false;
            bool is_host = false;
        };
        std::map<ChannelId, Peer> peers;
        TimePoint now = TimePoint{} + 10h;
        const auto of_address = [&](const IpAddress& address) {
            return static_cast<std::size_t>(
                std::count_if(peers.begin(), peers.end(), [&](const auto& p) { return p.second.endpoint.address == address; }));
        };
        for (int step = 0; step < 600; ++step) {
            now += random.of({Duration{0}, Duration{1ms}, Duration{400ms}, Duration{2s}, Duration{25s}});
            if (!peers.empty() && random.one_in(2)) {
                auto& [id, p] = *std::next(peers.begin(), static_cast<std::ptrdiff_t>(random.below(peers.size())));
                book.heard(id, 0xFE, now);
                p.heard = now;
                p.again |= now - p.began >= PeerBook::exchange;
                p.is_host = true;
                continue;
            }
            const Endpoint stranger{IpAddress::v4(10, 0, 0, static_cast<std::uint8_t>(random.below(5u))),
                                    static_cast<std::uint16_t>(1 + random.below(6u))};
            if (std::any_of(peers.begin(), peers.end(), [&](const auto& p) { return p.second.endpoint == stranger; })) continue;
            const std::size_t own = of_address(stranger.address);
            const PeerBook::Place place = book.place_for(stranger, now);
            if (own < max_of_address && peers.size() < most) {
                ASSERT_TRUE(place.free && !place.evicted) << seed << " " << step;
            }
            if (place.evicted) {
                const Peer& p = peers.at(*place.evicted);
                const bool same = p.endpoint.address == stranger.address;
                ASSERT_TRUE(own < max_of_address || same) << seed << " " << step;
                if (now - p.heard < timeout) {
                    ASSERT_FALSE(p.again) << seed << " " << step;
                    const bool waits = now - p.heard >= PeerBook::exchange && !p.is_host;
                    ASSERT_TRUE(same || waits || of_address(p.endpoint.address) > own + 1) << seed << " " << step;
                }
                book.remove(*place.evicted);
                peers.erase(*place.evicted);
            }
            if (!place.free) continue;
            ChannelId id{};
            while (peers.contains(id)) id = static_cast<ChannelId>(index(id) + 1);
            book.add(id, stranger, true, now);
            peers[id] = {stranger, now, now};
            ASSERT_LE(peers.size(), most) << seed << " " << step;
            ASSERT_LE(of_address(stranger.address), max_of_address) << seed << " " << step;
        }
    }
}

}    // namespace
}    // namespace peer_book_tests
