#include <link/clocks.hpp>
#include <log/log_line.hpp>
#include <recording/recordings.hpp>
#include <recording/running_recording.hpp>
#include <sys/asio.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>

namespace anogate {
namespace {

constexpr ano::Duration tick = std::chrono::milliseconds{500};
constexpr ano::Duration patience_at_the_begin = std::chrono::seconds{2};    // of the client, if the disk does not answer
constexpr unsigned ticks_between_looks = 20;

FrameFilterSettings::Bytes bytes_of(const std::vector<ByteRange>& ranges) {
    if (ranges.empty()) return ~FrameFilterSettings::Bytes{};
    FrameFilterSettings::Bytes bytes;
    for (const ByteRange& range : ranges)
        for (unsigned n = range.first; n <= range.last; ++n) bytes.set(n);
    return bytes;
}

}    // namespace

std::chrono::seconds since_1970() { return std::chrono::duration_cast<std::chrono::seconds>(time_by(CLOCK_REALTIME)); }

FrameFilterSettings frames_of(const RecordSettings& settings) {
    FrameFilterSettings filter;
    filter.ids = bytes_of(settings.ids);
    filter.from = bytes_of(settings.from);
    filter.to = bytes_of(settings.to);
    filter.links = settings.links;
    const auto has = [&](const char* word) {
        return std::find(settings.direction.begin(), settings.direction.end(), word) != settings.direction.end();
    };
    filter.directions = {has("in"), has("out"), has("dropped")};
    filter.limit = settings.limit;
    return filter;
}

KeepLimits limits_of(const RecordSettings& settings) {
    return {settings.keep_size, std::chrono::duration_cast<std::chrono::seconds>(settings.keep_age.value_or(ano::Duration{})),
            settings.keep_free == 0 ? 0 : std::max(settings.keep_free, room_needed(settings.free))};
}

std::string name_by_time(std::chrono::seconds since) {
    const auto time = static_cast<std::time_t>(since.count());
    std::tm parts{};
    ::gmtime_r(&time, &parts);
    std::array<char, 40> name{};
    return {name.data(), std::strftime(name.data(), name.size(), "%Y%m%d-%H%M%SZ", &parts)};
}

Recordings::Recordings(Gateway& gateway, FrameWatch& watch, std::string usual_folder)
    : gateway_{gateway}, usual_folder_{std::move(usual_folder)}, watch_{watch}, disk_{gateway.io()}, clock_{gateway.io(), [this] {
                                                                                                                watch_clock();
                                                                                                            }} {
    gateway_.parts().enter(*this);
    gateway_.parts().recording = this;
    settings_ = gateway_.settings().record.value_or(RecordSettings{});
    folder_ = settings_.folder.empty() ? usual_folder_ : settings_.folder;
}

Recordings::~Recordings() {
    gateway_.parts().leave(*this);
    gateway_.parts().recording = nullptr;
    is_alive_.reset();
    fault_trigger_.reset();
    memory_.reset();
    running_.clear();
}

void Recordings::start() {
    is_started_ = true;
    repair();
    configure();
    look_soon();
}

// A running recording is ended only if its settings have changed.
void Recordings::configure() {
    if (!is_started_ || is_stopped_) return;
    if (fault_trigger_) fault_trigger_->catch_up();    // earlier faults are saved with the earlier settings
    const auto& record = gateway_.settings().record;
    const RecordSettings before = std::exchange(settings_, record.value_or(RecordSettings{}));
    const bool was_configured = std::exchange(is_configured_, record.has_value());
    const std::string folder = settings_.folder.empty() ? usual_folder_ : settings_.folder;
    if (std::exchange(folder_, folder) != folder) ages_ = std::make_shared<RecordingAges>();
    RecordSettings same = before;
    same.keep_size = settings_.keep_size;
    same.keep_age = settings_.keep_age;
    same.keep_free = settings_.keep_free;
    same.keep_last = settings_.keep_last;
    const bool is_other = same != settings_ || was_configured != is_configured_;
    if (is_other) {
        begins_late_ = false;
        if (Running* const running = configured_one()) {
            running->is_ending = true;
            running->recorder->end();
        }
        if (is_configured_ && settings_.start) {
            const std::string why = start_recording();
            if (!why.empty()) log_error("recording: {}", why);
            begins_late_ = !why.empty() && !folder_.empty();
        }
    }
    if (before.keep_last != settings_.keep_last || frames_of(before) != frames_of(settings_) || !memory_) remember();
    keep_clock();
    look_soon();
}

void Recordings::remember() {
    if (!settings_.keep_last) {
        fault_trigger_.reset();
        memory_.reset();
        return;
    }
    if (memory_) return memory_->change(frames_of(settings_), *settings_.keep_last);
    memory_ = std::make_unique<FrameMemory>(gateway_, watch_, frames_of(settings_), *settings_.keep_last);
    fault_trigger_ = std::make_unique<FaultTrigger>(gateway_, watch_, [this] { save_for("fault"); });
}

void Recordings::catch_up() {
    for (const auto& running : running_)
        if (running->recorder) running->recorder->catch_up();
    if (memory_) memory_->catch_up();
}

void Recordings::stop(std::function<void()> ended) {
    if (is_stopped_) return;
    if (fault_trigger_) fault_trigger_->catch_up();
    fault_trigger_.reset();
    memory_.reset();
    is_stopped_ = true;
    ended_ = std::move(ended);
    end_by_ = Clock::now() + patience_at_the_end;
    for (const auto& running : running_)
        if (!std::exchange(running->is_ending, true)) running->recorder->end();
    clock_.start(tick / 10);
    check_end();
}

// Limits the wait at the end, so that a disk that hangs does not keep the program running.
void Recordings::check_end() {
    if (!end_by_ || ((!running_.empty() || is_saving_) && Clock::now() < *end_by_)) return;
    end_by_.reset();
    clock_.stop();
    for (const auto& running : running_)
        log_warning("recording {}: the disk does not respond; {} kB of frames may be lost", running->asked.name,
                    (running->recorder->report().waiting + 999) / 1000);
    if (is_saving_) log_warning("recording: the disk does not respond; the last frames may be lost");
    running_.clear();
    disk_.stop();
    std::exchange(ended_, {})();
}

void Recordings::watch_clock() {
    if (is_stopped_) return check_end();
    for (const auto& running : running_)
        if (!running->begun.empty() && Clock::now() - running->began_at >= patience_at_the_begin)
            for (const Respond& respond : std::exchange(running->begun, {})) respond(json_answer(json_of(*running)));
    for (const auto& running : running_)
        if (running->asked.time && !running->is_ending && Clock::now() - running->began_at >= *running->asked.time) {
            running->is_ending = true;
            running->recorder->end();
        }
    if (++ticks_ % ticks_between_looks == 0) look_soon();
}

AskedRecording Recordings::configured() const {
    return {name_by_time(since_1970()), format_for({}), options_for({}), frames_of(settings_), std::nullopt};
}

RecordingFormat Recordings::format_for(const WantedForm& wanted) const {
    if (wanted.format) return *wanted.format;
    return settings_.format == text(RecordingFormat::mcap) ? RecordingFormat::mcap : RecordingFormat::pcapng;
}

RecordingOptions Recordings::options_for(const WantedForm& wanted) const {
    const auto usual = decoded_encoding_called(settings_.message_encoding).value_or(DecodedEncoding::cdr);
    return {.encoding = wanted.encoding.value_or(usual), .packed = true};
}

RecorderSettings Recordings::settings_of(const AskedRecording& asked) const {
    RecorderSettings settings;
    settings.folder = folder_;
    settings.name = asked.name;
    settings.format = asked.format;
    settings.options = asked.options;
    settings.filter = asked.filter;
    settings.rotate_bytes = settings_.rotate_size;
    settings.rotate_time = settings_.rotate_time.value_or(ano::Duration{});
    settings.keep_free = settings_.free;
    return settings;
}

Recordings::Running& Recordings::launch(const AskedRecording& asked, bool is_configured) {
    Running& running = *running_.emplace_back(std::make_unique<Running>());
    running.asked = asked;
    running.is_configured = is_configured;
    running.began_ns = recording_head().time_ns;
    running.began_at = running.file_began_at = Clock::now();
    running.recorder = std::make_unique<Recorder>(gateway_, watch_, settings_of(asked), [this, &running] { changed(running); });
    keep_clock();
    return running;
}

Recordings::Running* Recordings::configured_one() {
    for (const auto& running : running_)
        if (running->is_configured && !running->is_ending) return running.get();
    return nullptr;
}

Recordings::Running* Recordings::find(const std::string& name) {
    for (const auto& running : running_)
        if (running->asked.name == name || name == running->asked.name + "." + std::string{text(running->asked.format)} ||
            (running->recorder && file_name_of(*running) == name))
            return running.get();
    return nullptr;
}

std::size_t Recordings::count_of_asked() const {
    const auto asked = std::count_if(running_.begin(), running_.end(), [](const auto& r) { return !r->is_configured; });
    return static_cast<std::size_t>(asked) + starting_.size();
}

void Recordings::changed(Running& running) {
    if (!running.recorder) return;    // it is being constructed
    const RecorderReport report = running.recorder->report();
    log_changes(running, report);
    const bool has_begun = report.files > 0 && report.fault.empty();
    if (!running.begun.empty() && (has_begun || !report.fault.empty() || report.is_ended)) {
        for (const Respond& respond : std::exchange(running.begun, {}))
            respond(has_begun ? json_answer(json_of(running)) : http::error({"recording_not_started", report.fault}));
        if (!has_begun && !std::exchange(running.is_ending, true)) running.recorder->refuse();
    }
    if (report.is_ended) reap_soon();
}

void Recordings::log_changes(Running& running, const RecorderReport& report) {
    if (report.files != running.logged_files) {
        if (running.logged_files > 0) running.file_began_at = Clock::now();
        running.logged_files = report.files;
        log_info("recording into {}", report.file);
        look_soon();
    }
    if (report.fault.id() == running.logged_fault) return;
    if (report.fault.empty()) log_info("recording {}: resumed; {} frames are missing", running.asked.name, report.not_written);
    else
        log_warning("recording {}: {}; frames are still forwarded, {}", running.asked.name, report.fault.text(),
                    !report.is_slow ? "but are not recorded"
                    : report.loses  ? "but not all are recorded"
                                    : "and none is lost yet");
    running.logged_fault = report.fault.id();
    look_soon();
}

// Posted, because a recorder must not be destroyed during one of its own calls.
void Recordings::reap_soon() {
    asio::post(gateway_.io(), [this, alive = std::weak_ptr<bool>{is_alive_}] {
        if (!alive.expired()) reap();
    });
}

void Recordings::reap() {
    const auto has_ended = [](const auto& running) { return running->recorder->report().is_ended; };
    const std::size_t before = running_.size();
    for (const auto& running : running_) {
        if (!has_ended(running)) continue;
        const RecorderReport report = running->recorder->report();
        past_.frames += report.frames;
        past_.bytes += report.bytes;
        past_.not_written += report.not_written;
        log_info("recording {} ended: {} frames, {} bytes in {}, {} frames not written", running->asked.name, report.frames,
                 report.bytes, report.files == 1 ? "one file" : std::to_string(report.files) + " files", report.not_written);
        for (const Respond& respond : std::exchange(running->ended, {})) respond(json_answer(json_of(*running)));
    }
    std::erase_if(running_, has_ended);
    if (running_.size() == before) return;
    if (is_stopped_) return check_end();
    if (begins_late_) begins_late_ = !start_recording().empty();
    keep_clock();
    look_soon();
}

// The clock runs only while it is needed.
void Recordings::keep_clock() {
    const bool deletes = settings_.keep_size != 0 || settings_.keep_age || settings_.keep_free != 0;
    if (running_.empty() && !deletes) clock_.stop();
    else clock_.start(tick);
}

std::string Recordings::start_recording() {
    if (is_stopped_) return "the gateway is stopping";
    if (configured_one()) return "a recording is already in progress";
    const auto ending = std::count_if(running_.begin(), running_.end(), [](const auto& r) { return r->is_configured; });
    if (static_cast<std::size_t>(ending) >= max_ending)
        return "the last recordings are not completely written yet; try again later";
    if (folder_.empty()) return "there is no folder for recordings: set \"record\": {\"folder\": \"/path\"}";
    changed(launch(configured(), true));
    return {};
}

std::string Recordings::stop_recording() {
    begins_late_ = false;
    Running* const running = configured_one();
    if (!running) return "no recording is in progress";
    running->is_ending = true;
    running->recorder->end();
    return {};
}

}    // namespace anogate
