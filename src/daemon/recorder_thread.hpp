// The thread of a recorder, and what it shares with the loop.
#pragma once
#include <daemon/disk_writer.hpp>
#include <daemon/recorder.hpp>
#include <daemon/thread_queue.hpp>
#include <link/unique_fd.hpp>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace anogate {

/// Of this thread: the loop comes first, and has the signals.
void stand_behind_the_loop() noexcept;

/// With a thread that may be left behind on a disk that hangs: whoever is last ends it. Nobody waits for the other.
class RecorderThread {
public:
    static constexpr std::size_t max_in_flight = 16 * 1024 * 1024;    // bytes

    struct News {
        std::string file, error;    // as of DiskWriter
        std::uint64_t files = 0;    // that were begun; the last of them is `file`
    };

    explicit RecorderThread(const RecorderSettings& settings) : settings_{settings} {}
    RecorderThread(const RecorderThread&) = delete;
    RecorderThread& operator=(const RecorderThread&) = delete;

    /// Why there is no thread, in a clause; empty: it runs.
    static std::string start(const std::shared_ptr<RecorderThread>& self);

    // For the loop alone.

    /// An eventfd of its own for the loop: readable when there are news, when there is room again after has_room() was false, and at
    /// the end.
    UniqueFd said() const noexcept;
    /// Asked before give().
    bool has_room() noexcept;
    /// False: there is no place for one more item, whatever its size.
    bool give(RecorderItem item);
    std::optional<News> next_news() { return news_.pop(); }
    /// Nothing more will be given.
    void end();
    /// What is not written yet stays so: the file is ended when the disk takes that.
    void abandon();
    /// Waits until nothing more will be written, at most so long.
    bool wait_for_end(std::chrono::milliseconds max_wait) const;
    const DiskProgress& progress() const noexcept { return progress_; }
    /// How long the disk has not answered.
    ano::Duration silence(ano::TimePoint now) const noexcept;

private:
    void run(DiskWriter& disk);
    void work(DiskWriter& disk);
    void take_all(DiskWriter& disk);
    void sleep(const DiskWriter& disk);
    void tell(const DiskWriter& disk);
    void wake() const noexcept;

    const RecorderSettings settings_;
    ThreadQueue<RecorderItem> items_{4096};
    ThreadQueue<News> news_{16};
    DiskProgress progress_;
    std::atomic<std::size_t> queued_{0};    // bytes in items_
    std::atomic<bool> is_ending_{false}, is_abandoned_{false};
    bool is_over_ = false;                    // for the thread alone: nothing is written any more
    std::atomic<bool> sleeps_deep_{false};    // and is to be woken for the first item
    std::atomic<bool> wants_room_{false};
    UniqueFd wake_, said_, ended_;    // eventfds
    News told_;                       // for the thread alone
};

}    // namespace anogate
