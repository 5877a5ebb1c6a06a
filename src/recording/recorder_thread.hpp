// The thread of a recorder, and the state that it shares with the loop.
#pragma once
#include <recording/disk_writer.hpp>
#include <recording/recorder.hpp>
#include <sys/thread_queue.hpp>
#include <sys/unique_fd.hpp>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace anogate {

/// Lowers the priority of the calling thread below that of the loop.
void stand_behind_the_loop() noexcept;

/// Shared with its thread, which stays behind if the disk hangs; the last owner destroys it. Neither side waits for the other.
class RecorderThread {
public:
    static constexpr std::size_t max_in_flight = 16 * 1024 * 1024;    // bytes

    struct News {
        std::string file;    // as DiskWriter::file() and fault()
        ano::Fault fault;
        std::uint64_t files = 0;    // number of files begun; the last one is `file`
    };

    explicit RecorderThread(const RecorderSettings& settings) : settings_{settings} {}
    RecorderThread(const RecorderThread&) = delete;
    RecorderThread& operator=(const RecorderThread&) = delete;

    /// Returns empty if the thread runs; otherwise a clause with the reason.
    static ano::Fault start(const std::shared_ptr<RecorderThread>& self);

    // To be called by the loop only.

    /// A duplicated eventfd for the loop: readable when there is news, when there is room again after has_room() was false, and
    /// at the
    /// end.
    UniqueFd notify_event() const noexcept;
    /// To be called before give().
    bool has_room() noexcept;
    /// False: the queue has no place for another item, even for a small one.
    bool push(RecorderItem item);
    std::optional<News> next_news() { return news_.pop(); }
    /// No calls of give() follow.
    void end();
    /// Creates no file if there is none yet. To be called before end().
    void begin_nothing() noexcept { begins_nothing_ = true; }
    /// Drops the waiting items; the file is ended as soon as the disk accepts that.
    void abandon();
    /// Waits at most `max_wait` until nothing more will be written. False: something may still be written.
    bool wait_for_end(std::chrono::milliseconds max_wait) const;
    const DiskProgress& progress() const noexcept { return progress_; }
    /// Time since the last answer of the disk while a request is pending.
    ano::Duration silence(ano::TimePoint now) const noexcept;

private:
    void run(DiskWriter& disk);
    void work(DiskWriter& disk);
    void drain(DiskWriter& disk);
    void sleep(const DiskWriter& disk);
    void notify(const DiskWriter& disk);
    void wake() const noexcept;

    const RecorderSettings settings_;
    ThreadQueue<RecorderItem> items_{4096};
    ThreadQueue<News> news_{16};
    DiskProgress progress_;
    std::atomic<std::size_t> queued_{0};    // bytes in items_
    std::atomic<bool> is_ending_{false}, is_abandoned_{false}, begins_nothing_{false};
    bool is_over_ = false;                    // used by the thread only: no more writes follow
    std::atomic<bool> sleeps_deep_{false};    // the thread waits long, and must be woken for the first item
    std::atomic<bool> awaits_room_{false};
    UniqueFd wake_, notify_event_, ended_;    // eventfds
    News reported_;                           // used by the thread only
};

}    // namespace anogate
