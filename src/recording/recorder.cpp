#include <recording/disk_pace.hpp>
#include <recording/recorder.hpp>
#include <recording/recorder_thread.hpp>
#include <runtime/gateway.hpp>
#include <sys/alarm.hpp>
#include <sys/asio.hpp>
#include <sys/descriptor.hpp>
#include <watch/frame_watch.hpp>

#include <sys/eventfd.h>

#include <algorithm>
#include <utility>
#include <variant>

namespace anogate {
namespace {

constexpr std::chrono::milliseconds recorder_patience{500};
constexpr ano::Duration reported_lag = std::chrono::seconds{1};    // age of unsynced bytes
constexpr ano::Duration beat_time = std::chrono::milliseconds{150};
constexpr ano::Duration beat_slack = std::chrono::milliseconds{50};

ano::Fault silence_fault(ano::Duration silence) {
    return {"disk_silent", std::max<std::int64_t>(1, std::chrono::duration_cast<std::chrono::seconds>(silence).count())};
}

}    // namespace

class Recorder::Impl final : private Watcher {
public:
    Impl(Gateway& gateway, FrameWatch& watch, RecorderSettings settings, std::function<void()> on_change);
    ~Impl();
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void catch_up();
    void end();
    void refuse();
    RecorderReport report() const;
    const RecorderSettings& settings() const noexcept { return settings_; }

private:
    void more() override { push(); }
    void push();
    bool push_next();
    void look();
    void beat();
    ano::Duration behind(TimePoint now);
    std::uint64_t not_written() const noexcept { return lost_ + queue.lost() + thread_->progress().not_written; }
    bool is_silent() const noexcept { return disk_ == DiskPace::State::silent; }
    void notify();

    Gateway& gateway_;
    FrameWatch& watch_;
    RecorderSettings settings_;
    std::function<void()> on_change_;
    std::shared_ptr<RecorderThread> thread_;
    Descriptor notify_event_;
    Alarm beat_;
    RecorderThread::News news_;
    WatchQueue::Tables tables_;               // as passed on last; nullptr: not yet
    std::uint64_t lost_ = 0;                  // frames, whether recorded in the file or not
    std::uint64_t lost_before_ = 0;           // not_written() when the disk was last well
    std::uint64_t given_ = 0, marked_ = 0;    // bytes passed to the thread; the same at marked_at_
    TimePoint marked_at_{};
    bool watches_ = false;
    bool is_ended_ = false;
    DiskPace pace_;
    DiskPace::State disk_ = DiskPace::State::well;    // as reported last
    TimePoint ends_at_{};                             // the latest time at which it ends, once end() was called
    std::shared_ptr<bool> is_notified_ = std::make_shared<bool>(true);    // false: a call of on_change is pending
};

Recorder::Impl::Impl(Gateway& gateway, FrameWatch& watch, RecorderSettings settings, std::function<void()> on_change)
    : gateway_{gateway},
      watch_{watch},
      settings_{std::move(settings)},
      on_change_{std::move(on_change)},
      thread_{std::make_shared<RecorderThread>(settings_)},
      notify_event_{gateway.io()},
      beat_{gateway.alarms(), [this] { beat(); }, beat_slack} {
    news_.fault = RecorderThread::start(thread_);
    if (!news_.fault.empty()) {
        is_ended_ = true;
        notify();
        return;
    }
    notify_event_.open(thread_->notify_event());
    notify_event_.read_with([this] { look(); });
    watches_ = true;
    watch_.add(*this, settings_.filter);
}

// Does not wait for a disk that is known to hang, or if the time since end() is over.
Recorder::Impl::~Impl() {
    end();
    if (is_ended_) return;
    if (!is_silent()) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(ends_at_ - Clock::now());
        thread_->wait_for_end(std::max(left, std::chrono::milliseconds::zero()));
    }
    thread_->abandon();
}

// Moves items while there is room. The rest waits in the queue of the watcher, which counts its losses.
void Recorder::Impl::push() {
    while (thread_->has_room() && push_next()) {}
    if (!beat_.is_set()) beat_.set(Clock::now() + beat_time);
}

bool Recorder::Impl::push_next() {
    auto next = queue.next(Clock::now());
    if (!next) return false;
    RecorderItem item;
    if (auto* batch = std::get_if<WatchQueue::Batch>(&*next)) {
        item.batch = std::move(*batch);
    } else if (const auto* lost = std::get_if<LostFrames>(&*next)) {
        lost_ += lost->count;
        item.lost = std::make_shared<const LostFrames>(*lost);
    } else {
        tables_ = std::move(std::get<WatchQueue::Tables>(*next));
        item.names = std::make_shared<const RecordedNames>(recorded_names(*tables_, gateway_));
    }
    const std::uint64_t frames = watches_ ? 0 : item.frames();    // counted as lost if the queue of the thread is full
    const std::size_t bytes = item.bytes();
    if (thread_->push(std::move(item))) given_ += bytes;
    else lost_ += frames;
    return true;
}

void Recorder::Impl::catch_up() {
    if (!watches_) return;
    watch_.catch_up(*this);
    push();
}

void Recorder::Impl::end() {
    if (!watches_) return;
    watch_.remove(*this);
    watches_ = false;
    while (push_next()) {}    // 1 MiB at most
    thread_->end();
    ends_at_ = Clock::now() + recorder_patience;
    beat_.set(Clock::now() + beat_time);
}

void Recorder::Impl::refuse() {
    thread_->begin_nothing();
    end();
}

// Reads the news of the thread.
void Recorder::Impl::look() {
    eventfd_t count = 0;
    ::eventfd_read(notify_event_.fd(), &count);
    bool is_new = false;
    const bool has_ended = thread_->wait_for_end(std::chrono::milliseconds::zero());    // no news follows the end
    while (auto news = thread_->next_news()) {
        news_ = std::move(*news);
        is_new = true;
    }
    if (has_ended) {
        is_ended_ = is_new = true;
        disk_ = DiskPace::State::well;
        notify_event_.close();
        beat_.cancel();
    } else if (watches_) {
        push();
    }
    if (is_new) notify();
}

// The result is between half and all of the age of the oldest unsynced byte. Starts from zero after a silence or a fault, because
// the frames that waited during it are still being written.
ano::Duration Recorder::Impl::behind(TimePoint now) {
    if (is_silent() || !news_.fault.empty() || given_ - thread_->progress().in_flight >= marked_) {
        marked_ = given_;
        marked_at_ = now;
    }
    return now - marked_at_;
}

// Called periodically while items are pending.
void Recorder::Impl::beat() {
    const TimePoint now = Clock::now();
    const ano::Duration silence = thread_->silence(now);
    const bool loses = queue.lost() > 0, is_behind = behind(now) >= reported_lag || loses;
    const auto was = std::exchange(disk_, pace_.look(now, {silence, is_behind, loses, !news_.fault.empty()}));
    if (was == DiskPace::State::well && disk_ == DiskPace::State::well) lost_before_ = not_written();
    if (was != disk_ || loses) notify();
    const bool is_slow = disk_ == DiskPace::State::slow;
    if (thread_->progress().in_flight > 0 || silence > ano::Duration::zero() || is_slow || !watches_) beat_.set(now + beat_time);
    else beat_.cancel();
}

// Calls on_change from the loop, since it may destroy this object.
void Recorder::Impl::notify() {
    if (!std::exchange(*is_notified_, false)) return;
    asio::post(gateway_.io(), [this, still_there = std::weak_ptr<bool>{is_notified_}] {
        const auto is_notified = still_there.lock();
        if (!is_notified) return;
        *is_notified = true;
        const auto call = on_change_;
        call();
    });
}

RecorderReport Recorder::Impl::report() const {
    const DiskProgress& progress = thread_->progress();
    RecorderReport report;
    report.is_ended = is_ended_;
    report.file = news_.file;
    report.files = news_.files;
    report.frames = progress.frames;
    report.bytes = progress.bytes;
    report.waiting = progress.in_flight;
    report.file_frames = progress.file_frames;
    report.file_bytes = progress.file_bytes;
    report.not_written = not_written();
    report.fault = is_silent() ? silence_fault(thread_->silence(Clock::now())) : news_.fault;
    report.is_slow = report.fault.empty() && disk_ == DiskPace::State::slow && !is_ended_;
    report.loses = report.is_slow && report.not_written > lost_before_;
    if (report.is_slow) report.fault = report.loses ? ano::Fault{"disk_loses"} : ano::Fault{"disk_waits"};
    return report;
}

Recorder::Recorder(Gateway& gateway, FrameWatch& watch, RecorderSettings settings, std::function<void()> on_change)
    : impl_{std::make_unique<Impl>(gateway, watch, std::move(settings), std::move(on_change))} {}
Recorder::~Recorder() = default;
void Recorder::catch_up() { impl_->catch_up(); }
void Recorder::end() { impl_->end(); }
void Recorder::refuse() { impl_->refuse(); }
RecorderReport Recorder::report() const { return impl_->report(); }
const RecorderSettings& Recorder::settings() const noexcept { return impl_->settings(); }

}    // namespace anogate
