// What the thread of a recorder does: frames become bytes, and bytes become files. Every call may block on the disk.
//
// Flow:    while (disk.takes_more()) disk.take(item);    // in their order
//          disk.turn(now);                               // often: at least every 250 ms while there are frames
//          disk.finish(now);                             // nothing is taken behind it
#pragma once
#include <daemon/recorder.hpp>
#include <daemon/recording_file.hpp>
#include <daemon/watch_queue.hpp>
#include <daemon/watched_record.hpp>
#include <record/rotation.hpp>

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

/// One of these is there.
struct RecorderItem {
    WatchQueue::Batch batch{};
    std::shared_ptr<const RecordedNames> names{};    // of the batches behind it
    std::shared_ptr<const LostFrames> lost{};        // before the batches behind it

    std::size_t bytes() const noexcept { return batch ? batch->size() : 0; }
    std::uint64_t frames() const noexcept;
};

/// How far it is, for another thread.
struct DiskProgress {
    std::atomic<std::uint64_t> frames{0}, bytes{0}, files{0};    // written
    std::atomic<std::uint64_t> file_frames{0}, file_bytes{0};    // of them, in the file that is written
    std::atomic<std::uint64_t> not_written{0};                   // frames that were taken, and given up at the end
    std::atomic<std::size_t> in_flight{0};    // bytes of the items that are not on the disk for sure; the other thread adds to it
    std::atomic<std::int64_t> busy_since{0};    // when the disk did something last (Clock, ns); 0: nothing is asked of it

    void is_busy() noexcept { busy_since = ano::Clock::now().time_since_epoch().count(); }
    void is_idle() noexcept { busy_since = 0; }
};

/// What was taken is kept until it is on the disk for sure (fdatasync). A disk that takes nothing is asked again every second, and
/// meanwhile nothing is taken: who gives the items has the losses. A file that is removed, or does not get onto its disk, is left: cut
/// to what is there for sure, and all behind that is in the next file.
class DiskWriter {
public:
    static constexpr ano::Duration try_again_after = std::chrono::seconds{1};
    static constexpr ano::Duration sync_time = std::chrono::milliseconds{600};
    static constexpr ano::Duration look_time = std::chrono::seconds{1};     // for room, and whether the file is there
    static constexpr std::size_t much = 256 * 1024;                         // bytes that are written at once
    static constexpr std::uint64_t room_between_looks = 4 * 1024 * 1024;    // bytes

    /// Both outlive it.
    DiskWriter(const RecorderSettings& settings, DiskProgress& progress) : settings_{settings}, progress_{progress} {}

    bool takes_more() const noexcept { return writer_ && error_.empty(); }
    void take(RecorderItem item);
    /// So much was taken that it is time for a turn.
    bool has_much() const noexcept { return waiting_.size() >= much; }
    void turn(ano::TimePoint now);
    /// A disk that took nothing is asked again in the next turn.
    void hurry() noexcept { try_again_at_ = {}; }
    /// Writes what was taken and ends the file. It is tried once: what is not written then is given up.
    void finish(ano::TimePoint now);
    /// One of the calls above threw std::bad_alloc: what it was about is tried again a second later, or given up where it was finish().
    void lacks_memory(ano::TimePoint now) noexcept;
    /// Something is to be done within a moment, even if nothing is taken.
    bool has_work() const noexcept { return !error_.empty() || (file_ && file_->size() != safe_size_); }

    const std::string& file() const noexcept { return path_; }      // empty: there was none yet
    const std::string& error() const noexcept { return error_; }    // empty: it writes

private:
    std::string work(ano::TimePoint now);
    std::string begin(ano::TimePoint now);
    std::string look_for_room(ano::TimePoint now);
    std::string write(ano::TimePoint now);
    std::string failed(int error);
    void encode(const RecorderItem& item);
    void is_safe(ano::TimePoint now);
    void leave_file() noexcept;
    void give_up() noexcept;
    void report();

    const RecorderSettings& settings_;
    DiskProgress& progress_;
    std::optional<RecordingFile> file_;
    std::unique_ptr<RecordingWriter> writer_;    // of file_
    std::string path_;
    unsigned number_ = 1;        // of the next file
    unsigned its_number_ = 1;    // of file_
    std::uint64_t files_ = 0;
    std::uint64_t bytes_before_ = 0;    // in files that were ended
    ano::TimePoint began_{}, safe_at_{}, try_again_at_{}, look_for_file_at_{}, look_for_room_at_{};
    std::uint64_t look_for_room_behind_ = 0;    // so many bytes of file_
    std::string error_;
    bool is_ending_ = false;    // what ends file_ is among what waits
    bool is_finishing_ = false;

    std::string waiting_;                // bytes of file_ that it does not have yet
    std::deque<RecorderItem> unsafe_;    // what is in file_ behind safe_size_, and what waits
    std::shared_ptr<const RecordedNames> names_ = std::make_shared<const RecordedNames>();    // of the next record
    std::shared_ptr<const RecordedNames> safe_names_ = names_;                                // before unsafe_
    std::uint64_t safe_size_ = 0;                                                // bytes of file_ that are on the disk for sure
    std::uint64_t safe_frames_ = 0, written_frames_ = 0, waiting_frames_ = 0;    // one behind the other; of all files
    std::uint64_t frames_before_ = 0;                                            // of them, in files before file_
};

}    // namespace anogate
