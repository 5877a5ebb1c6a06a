// Two listening sockets must never become peers of each other: one datagram with a forged source would be enough for that, and the
// commands for one vehicle would reach the other. To join gateways on purpose there are `udp` links, which do not answer here.
//
// A socket sends a suspect a question with a random number; a peer that repeats the number is a listening gateway. It asks before it
// sends a peer the first frame of a host, and when a peer sends a frame that is not a host's: a single ground station with a vehicle
// is never asked. A gateway that is asked asks back, and takes no frames from there until it has the answer or a second has passed,
// so that a command right after the question is not forwarded.
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

/// The state of each endpoint, of peers and strangers. No allocation; the table has a fixed size, which an attacker can't exceed.
class ListenerCheck {
public:
    static constexpr Duration suspended_for = std::chrono::seconds{1};
    /// A question suspends an endpoint at most once in this time: otherwise questions with a forged source could silence it. While as
    /// many endpoints as can be remembered were suspended within that time, no other is.
    static constexpr Duration between_suspensions = std::chrono::minutes{1};
    /// A refused endpoint that does not answer this many questions in a row, one a second, is no longer a listening gateway.
    static constexpr int unanswered_enough = 5;
    static constexpr std::uint32_t max_answers_a_second = 20;

    /// `random` gives unpredictable numbers.
    explicit ListenerCheck(std::function<std::uint64_t()> random) : random_{std::move(random)} {}

    /// The question for a suspect, if it is due: at once, 1 s and 4 s later, and then once a minute.
    std::optional<ListeningNotice> question(const Endpoint& suspect, TimePoint now);
    /// The question for an endpoint that asked us, or that is refused and goes on sending: one a second.
    std::optional<ListeningNotice> question_back(const Endpoint& there, TimePoint now);

    /// A question of `from` came: returns the answer, unless there were too many. Its frames are not taken until the check is over.
    std::optional<ListeningNotice> asked(const Endpoint& from, std::uint64_t number, TimePoint now);
    /// An answer of `from` came. True: it is a listening gateway, and refused from now on.
    bool answered(const Endpoint& from, std::uint64_t number, TimePoint now);

    bool is_suspended(const Endpoint& endpoint, TimePoint now) const noexcept { return suspended_until(endpoint, now) > now; }
    /// The end of its suspension; `now`: it is not suspended.
    TimePoint suspended_until(const Endpoint& endpoint, TimePoint now) const noexcept;
    bool is_refused(const Endpoint& endpoint) const noexcept;
    /// To be called when it is no longer a peer or a suspect. Its last suspension is remembered.
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

    // A table of its own: questions of strangers must not push out what is remembered of a suspension.
    struct Suspension {
        Endpoint endpoint;    // port 0: a free row
        TimePoint at{};
    };

    const Suspect* find(const Endpoint& endpoint) const noexcept;
    Suspect* find(const Endpoint& endpoint) noexcept;
    Suspect& row(const Endpoint& endpoint, TimePoint now) noexcept;
    ListeningNotice ask(Suspect& suspect, TimePoint now);
    void suspend(const Endpoint& endpoint, TimePoint now) noexcept;

    std::function<std::uint64_t()> random_;
    std::array<Suspect, max_suspects> suspects_;
    std::array<Suspension, max_suspects> suspensions_;
    TimePoint answers_since_{};
    std::uint32_t answers_ = 0;
};

}    // namespace anogate
