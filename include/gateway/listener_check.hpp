// Two listening sockets never join: one datagram with a forged source would make each a peer of the other, and the commands for
// one vehicle reach the other. A join that is meant is a `udp` link, which does not answer.
//
// A socket asks whom it suspects, by a number that only the other can repeat, and who repeats it is a listening gateway. It asks
// before it gives a peer the first frame of a host, and when a peer brings a frame that is none of a host: to a ground station
// alone with a vehicle it says nothing. Who is asked asks back, and takes nothing from there until it knows or a second has
// passed: a command that follows the question is not carried out.
#pragma once
#include <ano/time.hpp>
#include <gateway/ip.hpp>
#include <gateway/listening_notice.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

namespace anogate {

using ano::Duration;
using ano::TimePoint;

/// By endpoint, peers and strangers alike. No allocation; nothing that comes from outside makes it grow.
class ListenerCheck {
public:
    static constexpr Duration suspended_for = std::chrono::seconds{1};
    /// A question makes somebody wait once in so long, or questions with a forged source would silence it.
    static constexpr Duration between_suspensions = std::chrono::minutes{1};
    /// A refused endpoint that does not answer so many questions in a row, one a second, is no listening gateway any more.
    static constexpr int unanswered_enough = 5;
    static constexpr std::uint32_t max_answers_a_second = 20;

    /// `random` gives numbers that nobody can foretell.
    explicit ListenerCheck(std::function<std::uint64_t()> random) : random_{std::move(random)} {}

    /// The question for a suspect, when it is time for one: at once, 1 s and 4 s later, and then once a minute.
    std::optional<ListeningNotice> question(const Endpoint& suspect, TimePoint now);
    /// The question for an endpoint that asked us, or that is refused and goes on sending: one a second.
    std::optional<ListeningNotice> question_back(const Endpoint& there, TimePoint now);

    /// A question of `from` came: the answer, unless there were too many. What it says until the check is over is not taken.
    std::optional<ListeningNotice> asked(const Endpoint& from, std::uint64_t number, TimePoint now);
    /// An answer of `from` came. True: it is a listening gateway, and refused from now on.
    bool answered(const Endpoint& from, std::uint64_t number, TimePoint now);

    bool is_suspended(const Endpoint& endpoint, TimePoint now) const noexcept;
    bool is_refused(const Endpoint& endpoint) const noexcept;
    /// It is no peer any more, and no suspect.
    void forget(const Endpoint& endpoint) noexcept;

private:
    struct Suspect {
        Endpoint endpoint;           // port 0: a free row
        std::uint64_t number = 0;    // that it was asked by; 0: not yet
        std::uint32_t asks = 0;
        TimePoint asked_at{};
        TimePoint seen_at{};
        std::optional<TimePoint> suspended_at;
        bool refused = false;
        int unanswered = 0;    // while refused
    };
    static constexpr std::size_t max_suspects = 128;    // the peers of a link, and as many again

    const Suspect* find(const Endpoint& endpoint) const noexcept;
    Suspect* find(const Endpoint& endpoint) noexcept;
    Suspect& row(const Endpoint& endpoint, TimePoint now) noexcept;
    ListeningNotice ask(Suspect& suspect, TimePoint now);

    std::function<std::uint64_t()> random_;
    std::array<Suspect, max_suspects> suspects_;
    TimePoint answers_since_{};
    std::uint32_t answers_ = 0;
};

}    // namespace anogate
