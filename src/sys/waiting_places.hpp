// Accepted connections before authentication: selects the next one to process, and the one to drop if all places are taken.
#pragma once
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

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

/// The next connection to process, among those in `its_turn`: first those that go first, then those that have answered, then
/// those of the party with fewest connections, then the oldest. If three quarters of `places` are taken, the newest instead: the
/// oldest will be dropped, and work on them would be lost.
std::optional<std::size_t> next_turn(std::span<const WaitingConnection> all, std::size_t places);

}    // namespace anogate
