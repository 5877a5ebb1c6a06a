// Whether a disk keeps up with what is recorded, in a word that holds for a while.
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <cstdint>

namespace anogate {

/// A disk that takes a second for each write is silent again and again, and behind in between: that is one trouble, and is told as
/// one. Asked every 150 ms or so while something is under way.
class DiskPace {
public:
    static constexpr ano::Duration silence_told = std::chrono::milliseconds{750};
    static constexpr ano::Duration hang_told = std::chrono::seconds{30};    // a silence of one that is told of as slow
    static constexpr ano::Duration holds = std::chrono::seconds{10};        // what is told, behind the last sign of it

    enum class State : std::uint8_t {
        well,
        slow,    // it takes less than comes, or is silent once more
        silent    // it takes nothing: for silence_told, or behind another silence or a loss for hang_told and twice as long as before
    };
    struct Signs {
        ano::Duration silence{};    // since the disk answered last, while something is asked of it; 0: nothing is
        bool is_behind = false;     // by a second, or it lost frames:
        bool loses = false;
        bool fails = false;    // there is an error that says it all
    };

    State look(ano::TimePoint now, const Signs& signs) noexcept;

private:
    ano::Duration silence_that_is_told() const noexcept;

    State state_ = State::well;
    State before_ = State::well;             // it was silent
    bool is_troubled_ = false;               // or was, just before
    bool has_lost_ = false;                  // in this trouble
    ano::TimePoint troubled_until_{};        // where it is
    ano::Duration silence_{}, longest_{};    // of this trouble, that is under way; of those before it
};

}    // namespace anogate
