// A recording that is being written: a watcher of the frames, and a thread for the disk. The loop never waits for the disk.
#pragma once
#include <ano/fault.hpp>
#include <ano/time.hpp>
#include <record/recording_writer.hpp>
#include <watch/frame_filter.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace anogate {

class FrameWatch;
class Gateway;

struct RecorderSettings {
    std::string folder;    // created if it is missing
    std::string name;      // of the file, without the extension: "flight" becomes flight.pcapng
    RecordingFormat format = RecordingFormat::pcapng;
    RecordingOptions options{};
    FrameFilterSettings filter;        // selects the frames to be recorded
    std::uint64_t rotate_bytes = 0;    // size from which a file is ended and the next one, flight-2.pcapng, begun; 0: never
    ano::Duration rotate_time{};       // the same by the age of the file; 0: never
    std::uint64_t keep_free = 500'000'000;    // bytes: nothing is written while less space is free on the disk
};

/// The number of free bytes that the disk must have for writing, so that `free` bytes stay free. The difference is for the bytes
/// that are written until the next check, and for the end of a file. 0 if `free` is 0.
constexpr std::uint64_t room_needed(std::uint64_t free) noexcept { return free == 0 ? 0 : free + std::uint64_t{5} * 1024 * 1024; }

/// The progress of a recording.
struct RecorderReport {
    bool is_ended = false;
    std::string file;                 // the current file, with its folder
    std::uint64_t files = 0;          // number of files begun; the last one is `file`
    std::uint64_t frames = 0;         // written
    std::uint64_t bytes = 0;          // written, in all files
    std::uint64_t waiting = 0;        // bytes of frames not synced to the disk yet
    std::uint64_t file_frames = 0;    // frames in the current file; 0: no file
    std::uint64_t file_bytes = 0;
    std::uint64_t not_written = 0;    // frames lost because the disk was full, failed or was too slow
    ano::Fault fault;                 // why not everything is written at present
    bool is_slow = false;             // the fault is a slow disk: it is a second or more behind, or frames are lost
    bool loses = false;               // is_slow, and frames are lost
};

/// All calls must be from the loop.
class Recorder {
public:
    /// Begins. `gateway` and `watch` must outlive it. `on_change` is called from the loop when an error appears or disappears,
    /// when a file begins or ends, and when the recording has ended.
    Recorder(Gateway& gateway, FrameWatch& watch, RecorderSettings settings, std::function<void()> on_change);
    /// Ends the recording at once: waits at most 500 ms for the disk, then drops the rest. Does not wait if the disk is known to
    /// hang, or if end() was called at least 500 ms ago.
    ~Recorder();
    Recorder(const Recorder&) = delete;
    Recorder& operator=(const Recorder&) = delete;

    /// Takes in the frames that passed until now, so that a change does not apply to them.
    void catch_up();
    /// Accepts no more frames. After the waiting ones are written, is_ended is set and on_change is called.
    void end();
    /// Ends a recording that could not begin: no file is created even if the disk works again now.
    void refuse();
    RecorderReport report() const;
    const RecorderSettings& settings() const noexcept;

private:
    class Impl;
    std::unique_ptr<Impl> impl_;
};

}    // namespace anogate
