// Prevents two listening sockets from becoming peers of each other: one datagram with a forged source would be enough for that,
// and the commands for one vehicle would reach the other. Gateways are joined by `udp` links, which do not answer this check.
//
// A socket sends a suspect a question with a random number. A peer that repeats the number is a listening gateway. The socket
// asks before it sends a peer the first frame of a host, and when a peer sends a frame that is not from a host, so a single
// ground station with a vehicle is never asked. A gateway that is asked asks back. It accepts no frames of that peer until it has
// the answer or one second has passed, so that a command right after the question is not forwarded.
#pragma once
#include <ano/time.hpp>
#include <gateway/ip.hpp>
#include <gateway/peers/listening_notice.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

namespace anogate {

using ano::Duration;
using ano::TimePoint;

/// The state of each endpoint, of peers and unknown senders. No allocation; the table has a fixed size, which an attacker can't
/// exceed.
class ListenerCheck {
public:
    static constexpr Duration suspended_for = std::chrono::seconds{1};
    /// A question suspends an endpoint at most once in this time: otherwise questions with a forged source could silence it. If
    /// the table of suspensions is full of endpoints suspended within this time, no other endpoint is suspended.
    static constexpr Duration between_suspensions = std::chrono::minutes{1};
    /// A refused endpoint that does not answer this number of questions in a row, one per second, is no longer a listening
    /// gateway.
    static constexpr int unanswered_enough = 5;
    /// An answer is as long as its question and needs no row, so each question is answered. Questions back to endpoints without a row
    /// are limited, so that strangers neither get more than they send nor replace the rows of suspects.
    static constexpr std::uint32_t max_strangers_a_second = 20;

    /// `random` returns unpredictable numbers.
    explicit ListenerCheck(std::function<std::uint64_t()> random) : random_{std::move(random)} {}

    /// The question for a suspect, if it is due: immediately, 1 s and 4 s later, and then once per minute.
    std::optional<ListeningNotice> question(const Endpoint& suspect, TimePoint now);
    /// The question for an endpoint that asked us, or that is refused and still sends: one per second, and not to more than
    /// max_strangers_a_second new endpoints.
    std::optional<ListeningNotice> question_back(const Endpoint& there, TimePoint now);

    /// A question of `from` was received. Returns the answer, unless the question is our own. Its frames are not accepted until the
    /// check is over.
    std::optional<ListeningNotice> asked(const Endpoint& from, std::uint64_t number, TimePoint now);
    /// An answer of `from` was received. True: it is a listening gateway, and refused from now on.
    bool answered(const Endpoint& from, std::uint64_t number, TimePoint now);

    bool is_suspended(const Endpoint& endpoint, TimePoint now) const noexcept { return suspended_until(endpoint, now) > now; }
    /// The end of its suspension; `now`: it is not suspended.
    TimePoint suspended_until(const Endpoint& endpoint, TimePoint now) const noexcept;
    bool is_refused(const Endpoint& endpoint) const noexcept;
    /// Call when it is no longer a peer or a suspect. Its last suspension stays stored.
    void forget(const Endpoint& endpoint) noexcept;

private:
    struct Suspect {
        Endpoint endpoint;           // port 0: a free row
        std::uint64_t number = 0;    // in the question to it; 0: not asked yet
        std::uint32_t asks = 0;
        TimePoint asked_at{};
        TimePoint seen_at{};
        bool refused = false;
        int unanswered = 0;    // while refused
    };
    static constexpr std::size_t max_suspects = 128;    // twice the peers of a link

    // A separate table: questions of unknown senders must not replace stored suspensions.
    struct Suspension {
        Endpoint endpoint;    // port 0: a free row
        TimePoint at{};
    };

    const Suspect* find(const Endpoint& endpoint) const noexcept;
    Suspect* find(const Endpoint& endpoint) noexcept;
    Suspect& row(const Endpoint& endpoint, TimePoint now) noexcept;
    bool may_ask_stranger(TimePoint now) noexcept;
    ListeningNotice ask(Suspect& suspect, TimePoint now);
    void suspend(const Endpoint& endpoint, TimePoint now) noexcept;

    std::function<std::uint64_t()> random_;
    std::array<Suspect, max_suspects> suspects_;
    std::array<Suspension, max_suspects> suspensions_;
    TimePoint asked_since_{};
    std::uint32_t asked_strangers_ = 0;
};

}    // namespace anogate
