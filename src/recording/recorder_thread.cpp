#include <recording/recorder_thread.hpp>
#include <sys/error_fault.hpp>
#include <sys/thread_signals.hpp>

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/resource.h>

#include <algorithm>
#include <cerrno>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

namespace anogate {
namespace {

constexpr int collecting = 200;                    // ms: items that are queued in this time are written together
constexpr int deep_sleep = 1000;                   // ms: interval of the checks of the disk while no items are queued
constexpr std::size_t much_queued = 512 * 1024;    // bytes; from this size on they are written without waiting
constexpr int nice_of_thread = 5;

UniqueFd recorder_event() { return UniqueFd{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)}; }

bool wait_for_event(int event, int max_ms) {
    pollfd one{event, POLLIN, 0};
    return ::poll(&one, 1, max_ms) > 0;
}

}    // namespace

void stand_behind_the_loop() noexcept {
    ::pthread_setname_np(::pthread_self(), "recorder");
    const sched_param none{};
    ::sched_setscheduler(0, SCHED_OTHER, &none);    // this thread only, like setpriority()
    ::setpriority(PRIO_PROCESS, 0, std::max(::getpriority(PRIO_PROCESS, 0), nice_of_thread));
}

ano::Fault RecorderThread::start(const std::shared_ptr<RecorderThread>& self) {
    self->wake_ = recorder_event();
    self->notify_event_ = recorder_event();
    self->ended_ = recorder_event();
    if (!self->wake_ || !self->notify_event_ || !self->ended_) return error_fault("no file descriptor for the recorder", errno);
    try {
        begin_thread([self, disk = std::make_unique<DiskWriter>(self->settings_, self->progress_)] {
            stand_behind_the_loop();
            self->run(*disk);
        }).detach();
    } catch (const std::system_error& error) {
        return error_fault("no thread for the recorder", error.code().value());
    } catch (const std::bad_alloc&) {
        return {"other", "not enough memory for the recorder"};
    }
    return {};
}

bool RecorderThread::has_room() noexcept {
    if (progress_.in_flight < max_in_flight && items_.has_room()) return true;
    awaits_room_ = true;
    return progress_.in_flight < max_in_flight && items_.has_room();    // room may have appeared before awaits_room_ was set
}

bool RecorderThread::push(RecorderItem item) {
    const std::size_t bytes = item.bytes();
    if (!items_.has_room()) return false;
    progress_.in_flight += bytes;
    const std::size_t before = queued_.fetch_add(bytes);
    items_.push(std::move(item));
    const bool is_first = sleeps_deep_.exchange(false);
    if (is_first || (before < much_queued && before + bytes >= much_queued)) wake();
    return true;
}

void RecorderThread::end() {
    is_ending_ = true;
    wake();
}

void RecorderThread::abandon() {
    is_abandoned_ = true;
    end();
}

bool RecorderThread::wait_for_end(std::chrono::milliseconds max_wait) const {
    return wait_for_event(ended_.get(), static_cast<int>(max_wait.count()));
}

ano::Duration RecorderThread::silence(ano::TimePoint now) const noexcept {
    const std::int64_t since = progress_.busy_since;
    return since == 0 ? ano::Duration::zero() : now - ano::TimePoint{ano::Duration{since}};
}

UniqueFd RecorderThread::notify_event() const noexcept { return UniqueFd{::fcntl(notify_event_.get(), F_DUPFD_CLOEXEC, 0)}; }

void RecorderThread::wake() const noexcept { ::eventfd_write(wake_.get(), 1); }

void RecorderThread::run(DiskWriter& disk) {
    while (!is_over_) {
        progress_.is_busy();
        is_over_ = is_ending_;    // everything passed to give() before is in the queue now
        try {
            work(disk);
        } catch (const std::bad_alloc&) {
            disk.lacks_memory(ano::Clock::now());
        }
        if (is_over_)
            while (const auto item = items_.pop()) progress_.not_written += item->frames();
        progress_.is_idle();
        notify(disk);
        if (!is_over_) sleep(disk);
    }
    ::eventfd_write(ended_.get(), 1);
    ::eventfd_write(notify_event_.get(), 1);
}

void RecorderThread::work(DiskWriter& disk) {
    if (is_over_ && begins_nothing_ && disk.file().empty()) return;
    if (is_over_) disk.hurry();
    drain(disk);
    if (is_over_) disk.finish(ano::Clock::now());
    else disk.turn(ano::Clock::now());
}

// Calls turn() once at first, and then whenever DiskWriter::has_much().
void RecorderThread::drain(DiskWriter& disk) {
    disk.turn(ano::Clock::now());
    while (disk.accepts_more() && !is_abandoned_) {
        auto item = items_.pop();
        if (!item) return;
        queued_ -= item->bytes();
        disk.add(std::move(*item));
        if (disk.has_much()) disk.turn(ano::Clock::now());
    }
}

void RecorderThread::sleep(const DiskWriter& disk) {
    if (!disk.has_work()) {
        sleeps_deep_ = true;
        if (!items_.empty()) sleeps_deep_ = false;    // an item was queued meanwhile, perhaps without waking this thread
        else wait_for_event(wake_.get(), deep_sleep);
        sleeps_deep_ = false;
    } else {
        wait_for_event(wake_.get(), collecting);
    }
    eventfd_t count = 0;
    ::eventfd_read(wake_.get(), &count);
}

void RecorderThread::notify(const DiskWriter& disk) {
    bool must_notify = awaits_room_ && progress_.in_flight < max_in_flight / 2 && items_.has_room();
    if (must_notify) awaits_room_ = false;
    if (reported_.file != disk.file() || reported_.fault.text() != disk.fault().text() || reported_.files != progress_.files) {
        try {
            News news{disk.file(), disk.fault(), progress_.files};
            if (news_.push(news)) {
                reported_ = std::move(news);
                must_notify = true;
            }
        } catch (const std::bad_alloc&) {    // retried at the next call
        }
    }
    if (must_notify) ::eventfd_write(notify_event_.get(), 1);
}

}    // namespace anogate
