// Encodes frames and writes them to files, in the thread of a recorder. Every call may block on the disk.
//
// Flow:    while (disk.accepts_more()) disk.take(item);    // in their order
//          disk.turn(now);                               // often: at least every 250 ms while there are frames
//          disk.finish(now);                             // no take() after it
#pragma once
#include <record/rotation.hpp>
#include <recording/recorder.hpp>
#include <recording/recording_file.hpp>
#include <watch/watch_queue.hpp>
#include <watch/watched_record.hpp>

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

/// Exactly one of the three is set.
struct RecorderItem {
    WatchQueue::Batch batch{};
    std::shared_ptr<const RecordedNames> names{};    // valid for the batches that follow
    std::shared_ptr<const LostFrames> lost{};        // frames lost before the batches that follow

    std::size_t bytes() const noexcept { return batch ? batch->size() : 0; }
    std::uint64_t frames() const noexcept;
};

/// The progress of the writer, read by another thread.
struct DiskProgress {
    std::atomic<std::uint64_t> frames{0}, bytes{0}, files{0};    // written
    std::atomic<std::uint64_t> file_frames{0}, file_bytes{0};    // of these, in the present file
    std::atomic<std::uint64_t> not_written{0};                   // frames that were accepted, but given up at the end
    std::atomic<std::size_t> in_flight{0};      // bytes of the items not yet synced to the disk; the other thread adds to it
    std::atomic<std::int64_t> busy_since{0};    // time of the last answer of the disk (Clock, ns); 0: no request is pending

    void is_busy() noexcept { busy_since = ano::Clock::now().time_since_epoch().count(); }
    void is_idle() noexcept { busy_since = 0; }
};

/// Keeps every item until it is synced to the disk (fdatasync). A failed write is repeated every second; meanwhile accepts_more()
/// is false, and the caller counts the losses. A file that was removed or can't be synced is given up: it is cut to the part that
/// was synced, and everything after that is written to the next file.
class DiskWriter {
public:
    static constexpr ano::Duration try_again_after = std::chrono::seconds{1};
    static constexpr ano::Duration sync_time = std::chrono::milliseconds{600};
    static constexpr ano::Duration look_time = std::chrono::seconds{1};     // between checks of free space and file
    static constexpr std::size_t much = 256 * 1024;                         // bytes of a write
    static constexpr std::uint64_t room_between_looks = 4 * 1024 * 1024;    // bytes

    /// `settings` and `progress` must outlive it.
    DiskWriter(const RecorderSettings& settings, DiskProgress& progress) : settings_{settings}, progress_{progress} {}

    bool accepts_more() const noexcept { return writer_ && fault_.empty(); }
    void add(RecorderItem item);
    /// Enough bytes are waiting to call turn() now.
    bool has_much() const noexcept { return waiting_.size() >= much; }
    void turn(ano::TimePoint now);
    /// Makes the next turn() repeat a failed write at once.
    void hurry() noexcept { try_again_at_ = {}; }
    /// Writes the waiting items and ends the file. It tries once: items that can't be written are given up.
    void finish(ano::TimePoint now);
    /// To be called when one of the calls above threw std::bad_alloc: its work is repeated a second later, or given up if it was finish().
    void lacks_memory(ano::TimePoint now) noexcept;
    /// turn() must be called soon, even if there are no more items.
    bool has_work() const noexcept { return !fault_.empty() || (file_ && file_->size() != safe_size_); }

    const std::string& file() const noexcept { return path_; }    // empty: no file yet
    const ano::Fault& fault() const noexcept { return fault_; }

private:
    ano::Fault work(ano::TimePoint now);
    ano::Fault begin(ano::TimePoint now);
    ano::Fault look_for_room(ano::TimePoint now);
    ano::Fault write(ano::TimePoint now);
    ano::Fault failed(int error);
    void encode(const RecorderItem& item);
    void is_safe(ano::TimePoint now);
    void leave_file() noexcept;
    void abandon() noexcept;
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
    std::uint64_t look_for_room_behind_ = 0;    // free space is checked at this size of file_
    ano::Fault fault_;
    bool is_ending_ = false;    // waiting_ contains the end of file_
    bool is_finishing_ = false;

    std::string waiting_;                // bytes for file_ that are not written yet
    std::deque<RecorderItem> unsafe_;    // the items in file_ after safe_size_, and those in waiting_
    std::shared_ptr<const RecordedNames> names_ = std::make_shared<const RecordedNames>();    // valid for the next record
    std::shared_ptr<const RecordedNames> safe_names_ = names_;                                // valid before the items of unsafe_
    std::uint64_t safe_size_ = 0;                                                // bytes of file_ that are synced to the disk
    std::uint64_t safe_frames_ = 0, written_frames_ = 0, waiting_frames_ = 0;    // synced, only written, waiting; of all files
    std::uint64_t frames_before_ = 0;                                            // of these, in the files before file_
};

}    // namespace anogate
