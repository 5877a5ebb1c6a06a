#include <log/log_writer.hpp>
#include <sys/thread_signals.hpp>

#include <spdlog/logger.h>

#include <iostream>
#include <new>

namespace anogate {
namespace {

void write(spdlog::logger& log, const LogQueue::Batch& batch) {
    for (const LogMessage& message : batch.messages) {
        if (message.plain) std::cerr << message.text;
        else log.log(message.at, spdlog::source_loc{}, message.level, message.text);
    }
    if (batch.lost == 1) log.warn("1 log line was dropped: the log destination did not accept it");
    else if (batch.lost > 1) log.warn("{} log lines were dropped: the log destination did not accept them", batch.lost);
    log.flush();
}

}    // namespace

LogWriter::LogWriter(Open open, std::chrono::milliseconds finish_patience)
    : finish_patience_{finish_patience}, thread_{begin_thread([shared = shared_, open = std::move(open)] {
          run(*shared, open);
      })} {}

// Retries for lack of memory until the program ends; then returns nullptr.
std::shared_ptr<spdlog::logger> LogWriter::opened(Shared& shared, const Open& open) {
    for (;;) {
        try {
            return open();
        } catch (const std::bad_alloc&) {}
        std::unique_lock lock{shared.mutex};
        if (shared.changed.wait_for(lock, patience, [&] { return shared.ending; })) return nullptr;
    }
}

void LogWriter::run(Shared& shared, const Open& open) {
    auto log = opened(shared, open);
    std::unique_lock lock{shared.mutex};
    while (log) {
        shared.changed.wait(lock, [&] { return shared.ending || !shared.queue.empty(); });
        if (shared.queue.empty()) break;
        const LogQueue::Batch batch = shared.queue.pop_all();
        lock.unlock();
        write(*log, batch);
        lock.lock();
    }
    lock.unlock();
    log.reset();    // closes the file, which may block too
    lock.lock();
    shared.ended = true;
    shared.changed.notify_all();
}

// The thread holds the lock while it takes messages from the queue, never while it writes.
template <class Change>
void LogWriter::change(Change change) noexcept {
    {
        const std::lock_guard lock{shared_->mutex};
        change(*shared_);
    }
    shared_->changed.notify_all();
}

void LogWriter::log(const spdlog::details::log_msg& message) {
    change([&](Shared& s) { s.queue.push(message.level, message.time, {message.payload.data(), message.payload.size()}); });
}

void LogWriter::print_lines(std::string_view text) noexcept {
    change([&](Shared& s) { s.queue.push(spdlog::level::err, {}, text, true); });
}

void LogWriter::lose() noexcept {
    change([](Shared& s) { s.queue.lose(); });
}

bool LogWriter::finish() {
    if (!thread_.joinable()) return finished_;
    change([](Shared& s) { s.ending = true; });
    {
        std::unique_lock lock{shared_->mutex};
        finished_ = shared_->changed.wait_for(lock, finish_patience_, [&] { return shared_->ended; });
    }
    if (finished_) thread_.join();
    else thread_.detach();
    return finished_;
}

}    // namespace anogate
