// Accepted connections before authentication: selects the next one to process, and the one to drop if all places are taken.
#pragma once
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace anogate {

/// One waiting connection.
struct WaitingConnection {
    enum class Stage : std::uint8_t {
        silent,      // has sent nothing yet
        begun,       // its next message is incomplete
        its_turn,    // has sent a message that needs processing
        at_work,     // is being processed: never dropped
    };

    std::uint64_t client_id = 0;    // one IPv4 address, or one /64 of IPv6
    ano::TimePoint since{};
    Stage stage = Stage::silent;
    bool has_priority = false;    // has a trusted address
    bool has_answered = false;    // a message of it was processed, and the peer has our answer or will soon have it
};

/// The longest silence while others connect.
inline constexpr ano::Duration silent_while_others_come = std::chrono::seconds{3};

/// The connection to drop if all places are taken and one more connects. Never one that goes first, unless `for_priority` is set and
/// all go first. It belongs to the party with most connections; among the stages of that party (silent, begun, its_turn, each with and
/// without has_answered) to the one with most connections, and is the oldest of these. Up to four connections of a party count as four, so that many addresses
/// with one connection each do not displace two connections of one household. std::nullopt: none.
std::optional<std::size_t> next_evicted(std::span<const WaitingConnection> all, bool for_priority);

/// Copies of the facts of connections: pointers to objects with a WaitingConnection `facts`.
template <class One>
std::vector<WaitingConnection> facts_of(const std::vector<One>& all) {
    std::vector<WaitingConnection> facts;
    facts.reserve(all.size());
    for (const auto& one : all) facts.push_back(one->facts);
    return facts;
}

/// As next_evicted(). `has_unread(one)`: the loop has not read yet what one has sent. It is not silent then: its stage becomes
/// `heard`.
template <class One, class HasUnread>
std::optional<std::size_t> connection_to_close(const std::vector<One>& all, bool for_priority, WaitingConnection::Stage heard,
                                               HasUnread has_unread) {
    for (;;) {
        const auto leaves = next_evicted(facts_of(all), for_priority);
        if (!leaves || all[*leaves]->facts.stage != WaitingConnection::Stage::silent || !has_unread(*all[*leaves])) return leaves;
        all[*leaves]->facts.stage = heard;
    }
}

/// The next connection to process, among those in `its_turn`: first those that go first, then those that have answered, then
/// those of the party with fewest connections, then the oldest. If three quarters of `places` are taken, the newest instead: the
/// oldest will be dropped, and work on them would be lost.
std::optional<std::size_t> next_turn(std::span<const WaitingConnection> all, std::size_t places);

}    // namespace anogate
