// Connections that were accepted and have not shown yet who they are: whose turn is next, and which one gives way.
#pragma once
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace anogate {

/// One connection that waits.
struct WaitingConnection {
    enum class Stage : std::uint8_t {
        silent,      // has sent nothing yet
        begun,       // its next message is on the way
        its_turn,    // has sent a message that costs work
        at_work,     // that work is being done: it stays
    };

    std::uint64_t party = 0;    // of one IPv4 address, or one /64 of IPv6
    ano::TimePoint since{};
    Stage stage = Stage::silent;
    bool goes_first = false;      // of a trusted address
    bool has_answered = false;    // a message of ours, so its address is its own
};

/// So long one may be silent while others come.
inline constexpr ano::Duration silent_while_others_come = std::chrono::seconds{3};

/// All places are taken, and one more connects. It is never one that goes first, unless `for_first` and all do. The party with most
/// connections has to give one: of its stages (silent, begun, its_turn) the one with most connections, of those the oldest. Up to four
/// connections of a party count as four, so that a crowd of addresses with one each does not displace two of a household. std::nullopt: none.
std::optional<std::size_t> gives_way(std::span<const WaitingConnection> all, bool for_first);

/// Among those of `its_turn`: whoever goes first, then whoever has answered, then one of the party that has fewest connections, then the
/// newest: when more come than can be worked at, the oldest give way, and work at them would be lost.
std::optional<std::size_t> next_turn(std::span<const WaitingConnection> all);

}    // namespace anogate
