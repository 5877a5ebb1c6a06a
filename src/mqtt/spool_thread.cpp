#include <mqtt/spool_thread.hpp>
#include <sys/thread_signals.hpp>

#include <chrono>
#include <ctime>
#include <optional>
#include <utility>

namespace anogate {
namespace {

constexpr std::size_t max_queued = 16 * 1024 * 1024;    // bytes of records, while the disk hangs; further ones are dropped

std::size_t bytes_of(const std::vector<Record>& records) {
    std::size_t bytes = 0;
    for (const Record& record : records) bytes += sizeof(record) + record.topic.size() + record.json.size();
    return bytes;
}

std::uint64_t now_s() { return static_cast<std::uint64_t>(std::time(nullptr)); }

}    // namespace

struct SpoolThread::Shared {
    asio::io_context& io;
    const std::string folder;
    const SpoolLimits limits;
    const Events events;

    std::mutex mutex{};
    std::condition_variable changed{};
    std::deque<std::function<void(Shared&)>> jobs{};
    bool is_stopping = false, has_stopped = false;
    std::size_t queued = 0;            // bytes of records in jobs
    std::uint64_t dropped_jobs = 0;    // records

    // Of the thread:
    std::optional<Spool> spool{};
    BatchPacker packer{};
    std::vector<Batch> unwritten{};
    std::size_t unwritten_bytes = 0;
    SpoolState state{};
    std::uint64_t dropped = 0;    // records, before they reached the spool
    std::string fault{};

    void run(const std::shared_ptr<Shared>& self);
    void open();
    void store(const std::vector<Record>& records);
    void drop_unwritten();
    void report(const std::string& text) {
        asio::post(io, [self = this, text] { self->events.report(text); });
    }
};

void SpoolThread::Shared::run(const std::shared_ptr<Shared>&) {
    open();
    std::unique_lock lock{mutex};
    while (true) {
        changed.wait(lock, [this] { return is_stopping || !jobs.empty(); });
        if (jobs.empty()) break;
        const auto job = std::move(jobs.front());
        jobs.pop_front();
        dropped += std::exchange(dropped_jobs, 0);
        lock.unlock();
        job(*this);
        lock.lock();
    }
    spool.reset();
    has_stopped = true;
    changed.notify_all();
}

void SpoolThread::Shared::open() {
    std::vector<KnownRequest> known;
    if (!folder.empty()) {
        auto opened = Spool::open(folder, limits, [this](const std::string& text) { report(text); });
        if (opened) known = spool.emplace(*std::move(opened)).requests();
        else report(fault = opened.error() + "; records that the broker does not acknowledge are dropped");
    }
    asio::post(io, [this, known = std::move(known)] { events.requests(known); });
}

void SpoolThread::Shared::store(const std::vector<Record>& records) {
    if (!spool) {
        dropped += records.size();
    } else {
        for (Batch& batch : packer.pack(records)) {
            unwritten_bytes += batch.body.size();
            unwritten.push_back(std::move(batch));
        }
        const auto written = spool->write(unwritten, {}, now_s());
        if (written) {
            for (const Batch& batch : unwritten) state.stored += batch.records;
            unwritten.clear();
            unwritten_bytes = 0;
            if (!std::exchange(fault, {}).empty()) report("the spool can be written again");
        } else if (fault != written.error()) {
            report(fault = written.error());
        }
        drop_unwritten();
    }
    state.waiting = spool ? spool->records() : 0;
    state.dropped = dropped + (spool ? spool->dropped() : 0);
    asio::post(io, [this, now = state] { events.state(now); });
}

// The oldest of the lowest class first, as the spool itself.
void SpoolThread::Shared::drop_unwritten() {
    while (unwritten_bytes > max_unwritten) {
        std::size_t worst = 0;
        for (std::size_t i = 1; i < unwritten.size(); ++i)
            if (unwritten[i].keep < unwritten[worst].keep) worst = i;
        unwritten_bytes -= unwritten[worst].body.size();
        dropped += unwritten[worst].records;
        unwritten.erase(unwritten.begin() + static_cast<std::ptrdiff_t>(worst));
    }
}

SpoolThread::SpoolThread(asio::io_context& io, std::string folder, const SpoolLimits& limits, Events events)
    : io_{io}, shared_{new Shared{io, std::move(folder), limits, std::move(events)}} {}

SpoolThread::~SpoolThread() { stop({}); }

void SpoolThread::start() {
    thread_ = begin_thread([shared = shared_] { shared->run(shared); });
}

void SpoolThread::give(std::function<void(Shared&)> job) {
    const std::lock_guard lock{shared_->mutex};
    shared_->jobs.push_back(std::move(job));
    shared_->changed.notify_all();
}

void SpoolThread::store(std::vector<Record> records) {
    const std::size_t size = bytes_of(records);
    {
        const std::lock_guard lock{shared_->mutex};
        if (shared_->queued + size > max_queued) {
            shared_->dropped_jobs += records.size();
            return;
        }
        shared_->queued += size;
    }
    give([records = std::move(records), size](Shared& shared) {
        shared.store(records);
        const std::lock_guard lock{shared.mutex};
        shared.queued -= size;
    });
}

void SpoolThread::ask_next(std::int64_t done) {
    give([done](Shared& shared) {
        if (shared.spool && done != 0) shared.spool->remove_later(done);
        auto next = shared.spool ? shared.spool->next() : std::nullopt;
        asio::post(shared.io, [&shared, next = next ? *std::move(next) : SpooledBatch{}] { shared.events.next(next); });
    });
}

void SpoolThread::begin_request(const std::string& key, std::function<void(bool)> begin) {
    give([key, begin = std::move(begin)](Shared& shared) {
        const auto is_new = shared.spool ? shared.spool->begin_request(key, now_s()) : Expected<bool>{true};
        asio::post(shared.io, [begin, may_begin = is_new.value_or(true)] { begin(may_begin); });
    });
}

void SpoolThread::end_request(const std::string& key, const std::string& response) {
    give([key, response](Shared& shared) {
        if (shared.spool) shared.spool->end_request(key, response);
    });
}

bool SpoolThread::stop(ano::Duration patience) {
    if (!thread_.joinable()) return true;
    std::unique_lock lock{shared_->mutex};
    shared_->is_stopping = true;
    shared_->changed.notify_all();
    const bool has_stopped = shared_->changed.wait_for(lock, patience, [this] { return shared_->has_stopped; });
    lock.unlock();
    if (has_stopped) thread_.join();
    else thread_.detach();
    return has_stopped;
}

}    // namespace anogate
