// Which recordings go, so that the others have room. No I/O.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace anogate {

/// A file that the gateway wrote.
struct KeptRecording {
    std::string name;
    std::uint64_t bytes = 0;
    std::chrono::seconds changed{};    // the last time, since 1970, by the clock as it was then
    bool is_written = false;           // now: it never goes
    std::chrono::seconds age{};        // since its last change; RecordingAges knows it
    bool is_just_saved = false;        // it does not go for want of room
    bool is_far_ahead = false;         // its time can't be true: it is older than others of its age; RecordingAges knows it
};

/// How old recordings are, whatever happens to the clock: a computer without a battery for it begins with 1970 and learns the time in
/// the middle of a flight, and a receiver may take it into another century. A recording ages with the clock that nobody sets from the
/// time when it was first seen as it is; what it was by then is at most the time since the look before. At the first look nothing but
/// the clock tells how old one is, and it may not be set yet, as it may not have been set when others were written: the newest has no
/// age then, the others are as much older as their times say, and the longest pause among them does not count.
///
/// Flow, one look after the other:    ages.look(recordings, since_1970, by_the_other_clock)
class RecordingAges {
public:
    using seconds = std::chrono::seconds;

    /// Sets `age` and `is_far_ahead` of each. They are all that there are now: what is not among them is forgotten. At the first look one
    /// from before 2020 has no age: the clock was not set then. Nor has one whose time is more than 15 years ahead of the clock, and of
    /// 2020: a clock may be behind by the years since its system was built, but no further.
    void look(std::span<KeptRecording> recordings, seconds since_1970, seconds steady);

private:
    struct Seen {
        seconds changed, age, at;
        bool is_far_ahead;
    };
    std::map<std::string, Seen> seen_;
    std::optional<seconds> looked_at_;
};

/// 0: no limit.
struct KeepLimits {
    std::uint64_t bytes = 0;       // all recordings together have at most so many
    std::chrono::seconds age{};    // none is older
    std::uint64_t free = 0;        // bytes of the disk that stay free
};

/// Places in a list of recordings.
struct RecordingsToDelete {
    std::vector<std::size_t> going;    // the oldest first
    /// The newest that stays though it is beyond `bytes`, and not only while another is written.
    std::optional<std::size_t> stays{};
};
/// Only its age has one go that was just saved, or that is the newest of those that are not written: "it is saved" would be said of
/// what is gone a moment later. That newest one goes for the sake of free bytes too, while another is written. For the sake of free
/// bytes none goes when all of them were not enough: they would be lost for nothing.
RecordingsToDelete recordings_to_delete(std::span<const KeptRecording> recordings, const KeepLimits& limits,
                                        std::uint64_t free_bytes);

}    // namespace anogate
