// Selects the recordings to delete when disk limits are reached. No I/O.
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

/// A file written by the gateway.
struct KeptRecording {
    std::string name;
    std::uint64_t bytes = 0;
    std::chrono::seconds changed{};    // its last change, since 1970, by the system clock at that time
    bool is_written = false;           // being written now: never deleted
    std::chrono::seconds age{};        // since its last change; set by RecordingAges
    bool is_just_saved = false;        // deleted only for its age
    bool is_far_ahead = false;         // its time is implausible: counts as older than others of its age; set by RecordingAges
};

/// The ages of recordings, even if the system clock is set: a computer without a clock battery starts in 1970 and its clock is
/// set during a flight, and a faulty GPS receiver may set any date. A recording ages by the steady clock from the look() that
/// first found it in its present state; its age at that moment is at most the time since the look() before. At the first look()
/// only the file times are available, and the clock may not be set yet, or was not set when some files were written: so the
/// newest file gets age 0, and each other file is older by the difference of their times, without the longest pause among them.
///
/// Flow, repeated:    ages.look(recordings, since_1970, steady)
class RecordingAges {
public:
    using seconds = std::chrono::seconds;

    /// Sets `age` and `is_far_ahead` of each. `recordings` must be all that exist; others are forgotten. At the first look() a
    /// file from before 2020 gets age 0, since the clock was not set then. So does a file more than 15 years ahead of the clock
    /// and of 2020: a clock may be slow by the age of the installed system, but not by more.
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
    std::uint64_t bytes = 0;       // maximum of all recordings together
    std::chrono::seconds age{};    // maximum age
    std::uint64_t free = 0;        // bytes of the disk to be kept free
};

/// Indexes in a list of recordings.
struct RecordingsToDelete {
    std::vector<std::size_t> going;    // the oldest first
    /// The newest recording, if it is kept although KeepLimits::bytes is exceeded, and not only while another one is being
    /// written.
    std::optional<std::size_t> stays{};
};
/// A recording that was just saved, and the newest of those not being written, are deleted only for their age, so that a
/// recording reported as saved is not deleted at once. While another one is being written, that newest one may be deleted for
/// free bytes too. Nothing is deleted for free bytes if all deletable recordings together are not enough.
RecordingsToDelete recordings_to_delete(std::span<const KeptRecording> recordings, const KeepLimits& limits,
                                        std::uint64_t free_bytes);

}    // namespace anogate
