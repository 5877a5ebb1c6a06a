#include <config/config_error.hpp>
#include <gateway/backoff.hpp>
#include <link/replay_file.hpp>
#include <record/recording_reader.hpp>
#include <sys/errors.hpp>
#include <sys/thread_signals.hpp>

#include <fcntl.h>
#include <sys/eventfd.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <new>
#include <system_error>
#include <utility>
#include <variant>

namespace anogate {
namespace {

constexpr std::size_t piece_of_file = 64 * 1024;
constexpr std::size_t max_batch_bytes = 64 * 1024;    // bytes of frames per batch
constexpr std::size_t max_link_name = 64;             // bytes; the same as in a configuration
constexpr auto between_empty_rounds = std::chrono::seconds{1};
constexpr ano::Duration min_round = std::chrono::milliseconds{100};    // not at rate 0; a single frame has no duration

ReplayPlan::Options options_of(const ReplaySettings& settings) {
    return {settings.rate / 1000.0, settings.from.value_or(ano::Duration{}), settings.to.value_or(ano::Duration{}),
            settings.links, settings.commands};
}

LinkError why_absent(const std::string& file, const std::string& what) {
    return {"no_recording", file + ": " + what, {{"file", file}, {"what", what}}};
}

const char* why_strange(RecordingFormat format) {
    return format == RecordingFormat::pcapng
               ? "it is a network capture, not a recording of a gateway; use anoctl record to make one"
               : "it has no ANO V8 frames; another program wrote it";
}

/// Only regular files: a pipe without a writer would block the thread for ever.
std::variant<UniqueFd, std::string> open_file(const std::string& path) {
    UniqueFd file{::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)};
    struct stat is {};
    if (!file || ::fstat(file.get(), &is) != 0) return error_text(errno);
    if (S_ISREG(is.st_mode)) return file;
    return std::string{S_ISDIR(is.st_mode)    ? "it is a folder"
                       : S_ISFIFO(is.st_mode) ? "it is a named pipe"
                                              : "it is a device"} +
           ": use a regular file (anoctl replay can also read standard input)";
}

void add_kept_back(ReplayPlan::KeptBack& a, const ReplayPlan::KeptBack& b) {
    a.of_hosts += b.of_hosts;
    a.commands += b.commands;
    a.tunnels += b.tunnels;
}

}    // namespace

/// A bounded part of the frames of one read: an MCAP chunk may be a thousand times larger when uncompressed.
struct ReplayFile::Batch {
    struct Entry {
        ano::Duration due;
        std::uint32_t link, size;
    };
    std::vector<std::uint8_t> bytes;    // the frames, one after the other
    std::vector<Entry> entries;
    std::vector<std::string> new_links;
    DecodingPtr decoding;    // of all of them

    std::size_t weight() const { return bytes.size() + entries.size() * sizeof(Entry); }
};

struct ReplayFile::Shared {
    std::mutex mutex;
    std::condition_variable changed;
    UniqueFd news;    // an eventfd
    bool is_stopping = false;
    std::deque<std::shared_ptr<Batch>> batches;
    std::size_t waiting = 0;    // weight of `batches` and of the batch from which frames are taken
    State state = State::opening;
    LinkError error;
    ReplayPlan::KeptBack kept_back;

    void notify() const { ::eventfd_write(news.get(), 1); }
};

/// Runs in the thread.
class ReplayFile::Reader {
public:
    Reader(std::shared_ptr<Shared> shared, ReplaySettings settings)
        : shared_{std::move(shared)}, settings_{std::move(settings)} {}

    void run() {
        Backoff backoff;
        while (!is_stopping()) {
            const std::uint64_t frames_before = frames_;
            if (LinkError fault = try_to_play(); !fault.text.empty()) {
                set(State::absent, std::move(fault));
                wait_until(backoff.retry_at(ano::Clock::now()));
                continue;
            }
            if (!settings_.loop) return set(State::ended, note_);
            round_begin_ = settings_.rate == 0 ? latest_ : std::max(latest_, round_begin_ + min_round);
            if (frames_ > frames_before) continue;
            set(State::ended, note_);
            wait_until(ano::Clock::now() + between_empty_rounds);
        }
    }

private:
    // A damaged file may contain sizes beyond the memory.
    LinkError try_to_play() {
        try {
            return play();
        } catch (const std::bad_alloc&) {
            return why_absent(settings_.file, "not enough memory to read it");
        }
    }

    /// Plays the file once. Returns why that is not possible; empty: it was played.
    LinkError play() {
        const auto opened = open_file(settings_.file);
        if (const auto* const fault = std::get_if<std::string>(&opened)) return why_absent(settings_.file, *fault);
        const int file = std::get<UniqueFd>(opened).get();
        std::unique_ptr<RecordingReader> reader;
        ReplayPlan plan{options_of(settings_)};
        std::vector<char> room(piece_of_file);
        while (!is_stopping() && !plan.is_over() && !(reader && reader->is_damaged())) {
            const ssize_t n = ::read(file, room.data(), room.size());
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) return why_absent(settings_.file, error_text(errno));
            if (n == 0) break;
            const std::string_view bytes{room.data(), static_cast<std::size_t>(n)};
            if (!reader) reader = make_recording_reader(bytes);
            reader->feed(bytes);
            while (read_batch(*reader, plan)) {}
        }
        add_kept_back(kept_back_before_, plan.kept_back());
        if (!reader) return why_absent(settings_.file, "it is empty");
        if (reader->position() == 0)
            return why_absent(settings_.file, reader->is_damaged() ? reader->fault() : "it ends within the header");
        if (reader->is_strange()) return why_absent(settings_.file, why_strange(reader->format()));
        note_ = note_on(*reader, plan.is_over());
        if (note_.text.empty()) note_ = note_on_silence(plan);
        return {};
    }

    // False: the reader needs more data, or we are stopping.
    bool read_batch(RecordingReader& reader, ReplayPlan& plan) {
        auto batch = std::make_shared<Batch>();
        std::size_t looked_at = 0;
        std::optional<Recorded> item;
        while (looked_at < max_batch_bytes && !plan.is_over() && (item = reader.next())) {
            looked_at += sizeof(Batch::Entry);
            const auto* const frame = std::get_if<RecordedFrame>(&*item);
            if (frame == nullptr) continue;
            looked_at += frame->frame.bytes().size();
            const auto due = plan.due(*frame);
            if (!due) continue;
            if (!batch->entries.empty() && batch->decoding != reader.head().decoding)
                deliver(std::exchange(batch, std::make_shared<Batch>()), plan);
            batch->decoding = reader.head().decoding;
            add(*frame, *due, *batch);
        }
        const bool has_more = looked_at >= max_batch_bytes && !plan.is_over();
        if (reader.position() > 0) deliver(std::move(batch), plan);
        return has_more && !is_stopping();
    }

    void add(const RecordedFrame& frame, ano::Duration due, Batch& batch) {
        const auto bytes = frame.frame.bytes();
        latest_ = round_begin_ + due;
        batch.bytes.insert(batch.bytes.end(), bytes.begin(), bytes.end());
        batch.entries.push_back({latest_, link_number(frame.link, batch), static_cast<std::uint32_t>(bytes.size())});
        ++frames_;
    }

    std::uint32_t link_number(std::string_view name, Batch& batch) {
        auto place = std::find(links_.begin(), links_.end(), name);
        if (place == links_.end() && links_.size() == max_links) place = links_.end() - 1;
        if (place == links_.end()) {
            place = links_.emplace(place, name);
            batch.new_links.push_back(printable(std::string{name}, max_link_name));
        }
        return static_cast<std::uint32_t>(place - links_.begin());
    }

    void deliver(std::shared_ptr<Batch> batch, const ReplayPlan& plan) {
        std::unique_lock lock{shared_->mutex};
        shared_->state = State::playing;
        shared_->error = note_;
        shared_->kept_back = kept_back_before_;
        add_kept_back(shared_->kept_back, plan.kept_back());
        if (!batch->entries.empty()) {
            shared_->changed.wait(lock, [&] { return shared_->is_stopping || shared_->waiting < read_ahead; });
            shared_->waiting += batch->weight();
            shared_->batches.push_back(std::move(batch));
        }
        shared_->notify();
    }

    // The note about the file: the faults found in the part that was read.
    LinkError note_on(const RecordingReader& reader, bool is_over) const {
        if (is_over) return {};
        const std::string where = std::to_string(reader.position());
        std::string what;
        const SkippedParts skipped = reader.skipped();
        if (skipped.count > 0)
            what = std::to_string(skipped.count) +
                   (skipped.count == 1 ? " damaged part is skipped, at byte "
                                       : " damaged parts are skipped, the first at byte ") +
                   std::to_string(skipped.first.front().at) + ": " + std::string{skipped.first.front().why};
        if (reader.is_damaged()) what = "it is damaged after byte " + where + ", and the rest is not read: " + reader.fault();
        else if (reader.unfinished() > 0) what = "it is truncated: the data after byte " + where + " is incomplete";
        if (what.empty()) return {};
        return {"recording_damaged", settings_.file + ": " + what, {{"file", settings_.file}, {"what", what}}};
    }

    LinkError note_on_silence(const ReplayPlan& plan) const {
        const std::string what = plan.why_nothing();
        if (what.empty()) return {};
        return {"nothing_to_replay", settings_.file + ": " + what, {{"file", settings_.file}, {"what", what}}};
    }

    void set(State state, LinkError error) {
        const std::lock_guard lock{shared_->mutex};
        shared_->state = state;
        shared_->error = std::move(error);
        shared_->kept_back = kept_back_before_;
        shared_->notify();
    }

    bool is_stopping() {
        const std::lock_guard lock{shared_->mutex};
        return shared_->is_stopping;
    }

    void wait_until(ano::TimePoint time) {
        std::unique_lock lock{shared_->mutex};
        shared_->changed.wait_until(lock, time, [&] { return shared_->is_stopping; });
    }

    std::shared_ptr<Shared> shared_;
    const ReplaySettings settings_;
    std::vector<std::string> links_;
    ReplayPlan::KeptBack kept_back_before_;
    ano::Duration round_begin_{}, latest_{};
    std::uint64_t frames_ = 0;
    LinkError note_;
};

ReplayFile::ReplayFile(asio::io_context& io, std::function<void()> on_news) : event_{io}, on_news_{std::move(on_news)} {}

ReplayFile::~ReplayFile() { stop(); }

void ReplayFile::start(const ReplaySettings& settings) {
    shared_ = std::make_shared<Shared>();
    shared_->news = UniqueFd{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};
    UniqueFd news{shared_->news ? ::fcntl(shared_->news.get(), F_DUPFD_CLOEXEC, 0) : -1};
    const auto fail = [&](const std::string& why) {
        shared_->state = State::absent;
        shared_->error = why_absent(settings.file, why);
        on_news_();
    };
    if (!news) return fail(error_text(errno));
    event_.open(std::move(news));
    event_.read_with([this] {
        eventfd_t count = 0;
        ::eventfd_read(event_.fd(), &count);
        on_news_();
    });
    try {
        begin_thread([reader = std::make_shared<Reader>(shared_, settings)] { reader->run(); }).detach();
    } catch (const std::system_error& e) {
        fail(e.what());
    }
}

void ReplayFile::stop() noexcept {
    event_.close();
    const auto shared = std::exchange(shared_, nullptr);
    if (!shared) return;
    {
        const std::lock_guard lock{shared->mutex};
        shared->is_stopping = true;
    }
    shared->changed.notify_all();
}

std::optional<ReplayFile::Frame> ReplayFile::next() {
    if (!shared_) return std::nullopt;
    if (batch_ && taken_ == batch_->entries.size()) {
        {
            const std::lock_guard lock{shared_->mutex};
            shared_->waiting -= batch_->weight();
        }
        shared_->changed.notify_all();
        batch_.reset();
    }
    if (!batch_) {
        const std::lock_guard lock{shared_->mutex};
        if (shared_->batches.empty()) return std::nullopt;
        batch_ = std::move(shared_->batches.front());
        shared_->batches.pop_front();
        taken_ = at_ = 0;
        decoding_ = batch_->decoding;
        for (std::string& link : batch_->new_links) links_.push_back(std::move(link));
    }
    const Batch::Entry& entry = batch_->entries[taken_];
    return Frame{entry.due, entry.link, ano::FrameView{std::span{batch_->bytes}.subspan(at_, entry.size)}};
}

void ReplayFile::pop() { at_ += batch_->entries[taken_++].size; }

ReplayFile::State ReplayFile::state() const {
    if (!shared_) return State::ended;
    const std::lock_guard lock{shared_->mutex};
    return shared_->state;
}

LinkError ReplayFile::error() const {
    if (!shared_) return {};
    const std::lock_guard lock{shared_->mutex};
    return shared_->error;
}

ReplayPlan::KeptBack ReplayFile::kept_back() const {
    if (!shared_) return {};
    const std::lock_guard lock{shared_->mutex};
    return shared_->kept_back;
}

}    // namespace anogate
