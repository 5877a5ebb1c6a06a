// One recording while it is written: a watcher of the frames, and a thread for the disk. The loop never waits for it.
#pragma once
#include <ano/time.hpp>
#include <daemon/frame_filter.hpp>
#include <record/recording_writer.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace anogate {

class FrameWatch;
class Gateway;

struct RecorderSettings {
    std::string folder;    // is made when it is missing
    std::string name;      // of the file, without the format's end: "flight" becomes flight.pcapng
    RecordingFormat format = RecordingFormat::pcapng;
    RecordingOptions options{};
    FrameFilterSettings filter;               // whose frames; directions as well
    std::uint64_t rotate_bytes = 0;           // a file of at least so many is ended and the next begun, flight-2.pcapng; 0: never
    ano::Duration rotate_time{};              // and one that is so old; 0: never
    std::uint64_t keep_free = 500'000'000;    // bytes of the disk that stay free: nothing is written while there are fewer
};

/// So many bytes of the disk must be free for more to be written, where `free` stay so: what is written until that is looked at again,
/// and what ends a file, fit in between. 0 where none is to stay free.
constexpr std::uint64_t room_needed(std::uint64_t free) noexcept { return free == 0 ? 0 : free + std::uint64_t{5} * 1024 * 1024; }

/// What became of it until now.
struct RecorderReport {
    bool is_ended = false;
    std::string file;                 // that is written; with its folder
    std::uint64_t files = 0;          // that were begun; the last of them is `file`
    std::uint64_t frames = 0;         // written
    std::uint64_t bytes = 0;          // written, in all files
    std::uint64_t waiting = 0;        // bytes of frames that are not on the disk for sure
    std::uint64_t file_frames = 0;    // of them, in the file that is written; 0: there is none now
    std::uint64_t file_bytes = 0;
    std::uint64_t not_written = 0;    // frames: for want of room, or of a disk that takes them
    std::string error;                // why not all is written now, in a clause; empty: it is
    bool is_slow = false;             // that is the error: what is written is less than comes, or a second behind it;
    bool loses = false;               // and frames are lost by that
};

/// All calls are from the loop.
class Recorder {
public:
    /// Begins. `gateway` and `watch` outlive it. `on_change` is called from the loop when an error comes or goes, a file begins or
    /// ends, and when all is ended.
    Recorder(Gateway& gateway, FrameWatch& watch, RecorderSettings settings, std::function<void()> on_change);
    /// Ends it at once: what waits is lost after 500 ms. It does not wait where the disk is known to hang, or 500 ms after end().
    ~Recorder();
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    /// Takes no more frames; what waits is written, then on_change is called and is_ended is set.
    void end();
    RecorderReport report() const;
    const RecorderSettings& settings() const noexcept;

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}    // namespace anogate
