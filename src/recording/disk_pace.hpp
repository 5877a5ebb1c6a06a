// Whether a disk keeps up with a recording: a state that does not change with every write.
#pragma once
#include <ano/time.hpp>

#include <chrono>
#include <cstdint>

namespace anogate {

/// A disk that needs a second for each write is silent again and again, and behind in between. This counts as one trouble and is
/// reported once. look() is called about every 150 ms while a recording runs.
class DiskPace {
public:
    static constexpr ano::Duration min_silence = std::chrono::milliseconds{750};
    static constexpr ano::Duration min_further_silence = std::chrono::seconds{
        30};                                                            // minimum silence of a disk already reported as slow
    static constexpr ano::Duration holds = std::chrono::seconds{10};    // how long a state lasts after its last sign

    enum class State : std::uint8_t {
        well,
        slow,    // it writes less than is recorded, or is silent again
        silent    // it writes nothing for min_silence; after an earlier silence or a loss: for min_further_silence and twice the longest silence
    };
    struct Signs {
        ano::Duration silence{};    // since the last answer of the disk, while a request is pending; 0: no request is pending
        bool is_behind = false;     // by a second or more, or frames were lost
        bool loses = false;
        bool fails = false;    // an error is already reported, which explains the other signs
    };

    State look(ano::TimePoint now, const Signs& signs) noexcept;

private:
    ano::Duration reported_silence() const noexcept;

    State state_ = State::well;
    State before_ = State::well;             // the state before `silent`
    bool is_troubled_ = false;               // slow or silent, or was within `holds`
    bool has_lost_ = false;                  // frames, during this trouble
    ano::TimePoint troubled_until_{};        // valid while is_troubled_
    ano::Duration silence_{}, longest_{};    // of this trouble: the present silence, the longest earlier one
};

}    // namespace anogate
