// The spool in a thread of its own: a slow disk delays neither the gateway's frames nor the broker.
#pragma once
#include <mqtt/spool.hpp>
#include <sys/asio.hpp>

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace anogate {

struct SpoolState {
    std::uint64_t waiting = 0;    // records
    std::uint64_t stored = 0, dropped = 0;
};

class SpoolThread {
public:
    static constexpr std::size_t max_unwritten = 4 * 1024 * 1024;    // bytes of batches, while the disk accepts nothing

    /// Called in the loop.
    struct Events {
        std::function<void(SpooledBatch)> next = [](auto) {};    // the answer to ask_next(); id 0: the spool is empty
        std::function<void(const SpoolState&)> state = [](auto&) {};
        std::function<void(const std::string&)> report = [](auto&) {};            // one sentence, once until it changes
        std::function<void(std::vector<KnownRequest>)> requests = [](auto) {};    // once, before anything else
    };
    /// `folder` empty: there is no spool; everything that is stored is dropped.
    SpoolThread(asio::io_context& io, std::string folder, const SpoolLimits& limits, Events events);
    ~SpoolThread();
    SpoolThread(const SpoolThread&) = delete;
    SpoolThread& operator=(const SpoolThread&) = delete;

    void start();
    /// Stores `records`, which may be empty, and removes batches that are done, in one transaction.
    void store(std::vector<Record> records);
    /// The batch `done` is not needed any more; 0: none.
    void ask_next(std::int64_t done);
    /// Calls `begin` in the loop with true once the key is on the disk; with false if it was there before. Without a spool or with
    /// one that fails: with true.
    void begin_request(const std::string& key, std::function<void(bool)> begin);
    void end_request(const std::string& key, const std::string& response);
    /// Waits until everything is stored, but at most `patience`. False: the disk hangs; only _exit() ends the program.
    bool stop(ano::Duration patience);

private:
    struct Shared;
    void give(std::function<void(Shared&)> job);

    asio::io_context& io_;
    std::shared_ptr<Shared> shared_;
    std::thread thread_;
};

}    // namespace anogate
