// Which peers of a listening socket are overdue, worked out anew from all that ever came.
#include <gateway/peer_book.hpp>

#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

using namespace anogate;
using namespace std::chrono_literals;

namespace {

constexpr Duration timeout = 60s;

struct Model {
    struct Peer {
        IpAddress address;
        bool near;
        bool host = false;
        TimePoint heard;
        std::vector<TimePoint> refused{};    // since it was heard
    };
    std::map<ChannelId, Peer> peers;

    static bool dead(const Peer& p) {
        return p.refused.size() >= 3 && p.refused.back() - p.refused.front() >= 5s;
    }
    ChannelSet overdue(TimePoint now) const {
        ChannelSet result;
        std::map<std::string, std::vector<std::pair<TimePoint, ChannelId>>> listeners;    // silent ones, by address
        for (const auto& [id, p] : peers) {
            const Duration silent = now - p.heard;
            const bool listens = p.near && p.host;
            if (dead(p) || silent >= (listens ? Duration{1h} : timeout)) result.insert(id);
            if (listens && !dead(p) && silent >= timeout) listeners[p.address.text()].push_back({p.heard, id});
        }
        for (auto& [address, all] : listeners) {
            std::sort(all.rbegin(), all.rend());
            for (std::size_t i = 2; i < all.size(); ++i) result.insert(all[i].second);
        }
        return result;
    }
};

TEST(PeerBook, knows_who_is_overdue_whatever_came_before) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        support::Random random{seed};
        PeerBook book{{timeout}};
        Model model;
        TimePoint now = TimePoint{} + 10h;
        for (int step = 0; step < 400; ++step) {
            now += random.of({Duration{0}, Duration{1ms}, Duration{700ms}, Duration{3s}, Duration{40s}, Duration{11min}});
            const auto id = static_cast<ChannelId>(random.below(10u));
            const bool known = model.peers.contains(id);
            if (!known) {
                const Endpoint endpoint{IpAddress::v4(10, 0, 0, static_cast<std::uint8_t>(random.below(3u))), 5000};
                const bool near = !random.one_in(4);
                book.add(id, endpoint, near, now);
                model.peers[id] = {endpoint.address, near, false, now};
            } else if (random.one_in(3)) {
                const auto source = random.of<std::uint8_t>({0xFE, 0xD2, 0xDC, 0x20});
                book.heard(id, source, now);
                model.peers[id].heard = now;
                model.peers[id].host |= source == 0xFE || source == 0xD2;
                model.peers[id].refused.clear();
            } else if (random.one_in(2)) {
                model.peers[id].refused.push_back(now);
                ASSERT_EQ(book.refused(id, now), Model::dead(model.peers[id])) << seed << " " << step;
            } else if (random.one_in(4)) {
                book.remove(id);
                model.peers.erase(id);
            }
            ASSERT_EQ(book.overdue(now), model.overdue(now)) << seed << " " << step;
            // Nobody is overdue before the next look, who is not now.
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

}  // namespace
