// The reports and responses of Recordings, and its disk operations for them.
#include <ano_json/answer_json.hpp>
#include <ano_json/fault_json.hpp>
#include <ano_json/nearest.hpp>
#include <http/served_file.hpp>
#include <link/clocks.hpp>
#include <log/log_line.hpp>
#include <recording/recorder_thread.hpp>
#include <recording/running_recording.hpp>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

http::Response refused(const Refusal& refusal) { return http::error(refusal.status, refusal.fault); }

Json json_of(const FoundRecording& file) {
    Json json{{"name", file.name}, {"format", text(file.format)}, {"bytes", file.bytes}};
    json["frames"] = file.frames ? Json(*file.frames) : Json(nullptr);
    json["seconds"] = file.seconds ? Json(*file.seconds) : Json(nullptr);
    json["begun"] = json_seconds(file.begun_ns);
    json["time"] = json_seconds(file.changed_ns);
    json["state"] = text(file.state);
    return json;
}

// The recording of keep_last as a response, encoded in parts while it is sent.
class KeptFramesParts final : public http::Producer {
public:
    /// `place` is held until the last part is encoded.
    KeptFramesParts(KeptFrames frames, RecordingFormat format, RecordingOptions options, std::shared_ptr<void> place)
        : writing_{std::move(frames), format, options}, place_{std::move(place)} {}
    Next next(std::string& into) override {
        if (writing_.next(into)) return Next::part;
        place_.reset();
        return Next::end;
    }

private:
    KeptFramesWriting writing_;
    std::shared_ptr<void> place_;
};

std::string type_of(RecordingFormat format) {
    return format == RecordingFormat::pcapng ? "application/vnd.tcpdump.pcap" : "application/octet-stream";
}

http::Response nothing_kept() { return http::error({"nothing_kept", R"("record": {"keep_last": "60s"})"}); }
http::Response no_folder() { return http::error({"no_recordings_folder", R"("record": {"folder": "/path"})"}); }

}    // namespace

std::string file_name_of(const Recordings::Running& running) {
    if (!running.recorder) return {};
    return std::filesystem::path{running.recorder->report().file}.filename().string();
}

http::Response json_answer(Json json) {
    http::Response response;
    response.body = line_of(std::move(json));
    return response;
}

Json Recordings::json_of(const Running& running) const {
    const RecorderReport report = running.recorder->report();
    const TimePoint now = Clock::now();
    const ano::Duration runs = now - running.began_at;
    Json json{{"name", running.asked.name},
              {"by", running.is_configured ? "configuration" : "request"},
              {"file", file_name_of(running)},
              {"files", report.files},
              {"format", text(running.asked.format)},
              {"frames", report.frames},
              {"bytes", report.bytes},
              {"file_frames", report.file_frames},
              {"file_bytes", report.file_bytes},
              {"file_seconds", in_seconds(now - running.file_began_at)},
              {"not_written", report.not_written},
              {"since", json_seconds(running.began_ns)},
              {"seconds", in_seconds(runs)}};
    json["ends_in_s"] = running.asked.time ? Json(in_seconds(std::max(ano::Duration{}, *running.asked.time - runs)))
                                           : Json(nullptr);
    ano::add_fault(json, report.fault);
    return json;
}

void Recordings::describe(Json& recording) {
    recording["folder"] = folder_;
    recording["free_bytes"] = free_ ? Json(*free_) : Json(nullptr);
    recording["free_needed"] = room_needed(settings_.free);
    recording["keep_last"] = nullptr;
    if (memory_) {
        const FrameMemory::Figures kept = memory_->figures();
        recording["keep_last"] = {{"seconds", in_seconds(kept.span)},
                                  {"held_s", in_seconds(kept.reach)},
                                  {"frames", kept.frames},
                                  {"bytes", kept.bytes},
                                  {"saved", past_.saved},
                                  {"skipped", past_.skipped},
                                  {"last", last_saved_}};
        ano::add_fault(recording["keep_last"], save_fault_);
    }
    Json all = Json::array();
    for (const auto& running : running_) all.push_back(json_of(*running));
    recording["running"] = std::move(all);
}

RecordingFigures Recordings::figures() {
    RecordingFigures figures = past_;
    figures.free = free_;
    for (const auto& running : running_) {
        const RecorderReport report = running->recorder->report();
        ++figures.running;
        if (!report.fault.empty()) ++figures.failing;
        figures.frames += report.frames;
        figures.bytes += report.bytes;
        figures.not_written += report.not_written;
    }
    if (memory_) {
        const FrameMemory::Figures kept = memory_->figures();
        figures.memory_frames = kept.frames;
        figures.memory_bytes = kept.bytes;
    }
    return figures;
}

http::Response Recordings::list() {
    Json json;
    describe(json);
    return answer_from(disk_, [folder = folder_, json = std::move(json)] {
        const FolderView view = view_of(folder);
        Json all{{"folder", folder}};
        all["free_bytes"] = view.free ? Json(*view.free) : Json(nullptr);
        all["free_needed"] = json["free_needed"];
        ano::add_fault(all, view.fault);
        all["others"] = view.others;
        all["keep_last"] = json["keep_last"];
        all["running"] = json["running"];
        all["recordings"] = Json::array();
        for (const FoundRecording& file : view.files) all["recordings"].push_back(anogate::json_of(file));
        return json_answer(std::move(all));
    });
}

http::Response Recordings::begin(AskedRecording asked) {
    if (asked.name.empty()) asked.name = name_by_time(since_1970());
    if (!is_recording_name(asked.name)) return http::error(422, recording_name_rule(asked.name));
    if (folder_.empty()) return no_folder();
    if (starting_.contains(asked.name) || find(asked.name)) return http::error({"recording_exists", asked.name});
    if (count_of_asked() >= max_asked) return http::error({"recordings_running", max_asked});
    const auto held = std::make_shared<TaskPool::Ticket>();
    http::Response response = http::later([this, asked, weak = std::weak_ptr{held}](const Respond& respond) {
        const auto refusal = std::make_shared<std::optional<Refusal>>();
        starting_.insert(asked.name);
        TaskPool::Ticket ticket = disk_.run(
            [refusal, folder = folder_, name = asked.name] { *refusal = check_new_name(folder, name); },
            [this, refusal, asked, respond](const std::string& fault) { named(asked, fault, *refusal, respond); });
        // If the client has disconnected before the name is checked, no recording is begun.
        if (const auto still = weak.lock())
            *still = std::shared_ptr<void>(ticket.get(),
                                           [this, ticket, name = asked.name, alive = std::weak_ptr<bool>{is_alive_}](void*) {
                                               if (!alive.expired()) starting_.erase(name);
                                           });
    });
    response.patient = true;
    response.needed = held;
    return response;
}

void Recordings::named(const AskedRecording& asked, const std::string& fault, const std::optional<Refusal>& refusal,
                       const Respond& respond) {
    starting_.erase(asked.name);
    if (!fault.empty()) return respond(http::error(503, fault));
    if (refusal) return respond(refused(*refusal));
    if (is_stopped_) return respond(http::error({"stopping"}));
    Running& running = launch(asked, false);
    running.begun.push_back(respond);
    changed(running);
}

http::Response Recordings::end(const std::string& name) {
    Running* const found = find(name);
    if (!found) {
        std::vector<std::string_view> names;
        for (const auto& running : running_) names.emplace_back(running->asked.name);
        return http::error(
            404, "no recording with that name is in progress" + ano::did_you_mean(name, names) + "; see anoctl recordings");
    }
    http::Response response = http::later([this, found](const Respond& respond) {
        found->ended.push_back(respond);
        if (!std::exchange(found->is_ending, true)) found->recorder->end();
        changed(*found);
    });
    response.patient = true;
    return response;
}

http::Response Recordings::remove(std::string name) {
    return answer_from(disk_, [folder = folder_, name = std::move(name)] {
        if (const auto refusal = remove_recording(folder, name)) return refused(*refusal);
        return json_answer({{"name", name}, {"deleted", true}});
    });
}

http::Response Recordings::file(const http::Request& request, std::string name) {
    ServedFile file;
    file.type = type_of(recording_format_of(name).value_or(RecordingFormat::mcap));
    if (is_recording_name(name)) file.save_as = name;
    file.open = [folder = folder_, name = std::move(name)]() -> std::variant<UniqueFd, http::Response> {
        auto opened = open_recording(folder, name);
        if (auto* refusal = std::get_if<Refusal>(&opened)) return refused(*refusal);
        return std::move(std::get<UniqueFd>(opened));
    };
    return served(disk_, request, std::move(file));
}

http::Response Recordings::save_last(std::string name, const WantedForm& wanted) {
    if (is_stopped_) return http::error({"stopping"});
    if (!memory_) return nothing_kept();
    if (folder_.empty()) return no_folder();
    const bool is_made_up = name.empty();
    if (is_made_up) name = name_by_time(since_1970()) + "-last";
    if (!is_recording_name(name)) return http::error(422, recording_name_rule(name));
    http::Response response = http::later([this, name, is_made_up, wanted](const Respond& respond) {
        if (is_saving_) return respond(http::try_again("the previous save is not completely written yet"));
        if (!memory_) return respond(nothing_kept());
        is_saving_ = true;
        if (is_made_up) return save(save_of(name, wanted, respond));
        const auto asked = std::make_shared<Save>(save_of(name, wanted, respond));
        const auto refusal = std::make_shared<std::optional<Refusal>>();
        disk_.run_detached([refusal, asked] { *refusal = check_new_name(asked->folder, asked->name); },
                           [this, refusal, asked](const std::string& fault) {
                               if (fault.empty() && !*refusal) return save(std::move(*asked));
                               asked->respond(fault.empty() ? refused(**refusal) : http::error(503, fault));
                               saving_ended();
                           });
    });
    response.patient = true;
    return response;
}

http::Response Recordings::last(const WantedForm& wanted) {
    if (!memory_) return nothing_kept();
    if (static_cast<std::size_t>(reading_.use_count()) > max_reading)
        return http::try_again("the last frames are already being read by " + std::to_string(max_reading) +
                               " clients; try again later");
    const RecordingFormat made = format_for(wanted);
    http::Response response;
    response.type = type_of(made);
    response.headers.push_back({"Content-Disposition", "attachment; filename=\"" + name_by_time(since_1970()) + "-last." +
                                                           std::string{text(made)} + "\""});
    response.producer = std::make_unique<KeptFramesParts>(memory_->frames(), made, options_for(wanted), reading_);
    return response;
}

void Recordings::link_lost(const LinkState&) { save_for("link-lost"); }

Recordings::Save Recordings::save_of(std::string name, const WantedForm& wanted, Respond respond) {
    return {std::move(name),     folder_,        memory_->frames(), format_for(wanted),
            options_for(wanted), settings_.free, std::move(respond)};
}

// If the event repeats, only the first one is saved.
void Recordings::save_for(std::string_view why) {
    if (!memory_ || is_stopped_ || folder_.empty()) return;
    const TimePoint now = Clock::now();
    if (due_ || (next_save_ && now < *next_save_)) {
        ++past_.skipped;
        return;
    }
    next_save_ = now + between_saves;
    due_ = save_of(name_by_time(since_1970()) + "-" + std::string{why}, {}, {});
    save_due();
}

void Recordings::save_due() {
    if (!due_ || is_saving_) return;
    is_saving_ = true;
    save(*std::exchange(due_, std::nullopt));
}

// One save at a time (is_saving_): on a disk that hangs each save keeps its frames in memory.
void Recordings::save(Save what) {
    const std::uint64_t count = what.frames.frames();
    const Respond respond = std::move(what.respond);
    const auto work = std::make_shared<Save>(std::move(what));
    const auto result = std::make_shared<std::variant<SavedFrames, Refusal>>();
    disk_.run_detached(
        [result, work, just_saved = just_saved_] {
            *result = save_frames(work->folder, work->name, work->format, work->free, std::move(work->frames), work->options,
                                  [&](const std::string& file) { just_saved->add(file, Clock::now() + saved_stays); });
        },
        [this, result, count, respond](const std::string& fault) {
            if (!fault.empty()) *result = Refusal{503, {"other", fault}};
            saved(*result, count, respond);
        });
}

void Recordings::saved(const std::variant<SavedFrames, Refusal>& result, std::uint64_t frames, const Respond& respond) {
    if (const auto* refusal = std::get_if<Refusal>(&result)) {
        save_fault_ = refusal->fault;
        log_warning("recording: the last frames are not saved: {}", refusal->fault.text());
        if (respond) respond(refused(*refusal));
        else next_save_ = Clock::now() + after_a_failed_save;
        return saving_ended();
    }
    const SavedFrames& file = std::get<SavedFrames>(result);
    ++past_.saved;
    save_fault_ = {};
    last_saved_ = file.name;
    log_info("recording: the last {} frames are saved as {}", frames, file.name);
    look_soon();
    if (respond) respond(json_answer({{"name", file.name}, {"bytes", file.bytes}, {"frames", frames}}));
    saving_ended();
}

void Recordings::saving_ended() {
    is_saving_ = false;
    save_due();
    if (is_stopped_) check_end();
}

// One look at a time; all requests meanwhile cause one more.
void Recordings::look_soon() {
    if (is_stopped_ || folder_.empty()) return;
    if (std::exchange(is_looking_, true)) look_again_ = true;
    else look();
}

void Recordings::look() {
    struct Seen {
        std::optional<std::uint64_t> free;
        DeletedRecordings old;
    };
    const auto seen = std::make_shared<Seen>();
    static constexpr auto stays = std::chrono::duration_cast<std::chrono::seconds>(saved_stays);
    disk_.run_detached(
        [seen, limits = limits_of(settings_), folder = folder_, ages = ages_, just_saved = just_saved_, is_first = !has_looked_,
         began = began_, began_at = began_at_] {
            const bool has_limits = limits.bytes != 0 || limits.free != 0 || limits.age > std::chrono::seconds::zero();
            const auto steady = std::chrono::duration_cast<std::chrono::seconds>(Clock::now().time_since_epoch());
            // Files that were saved within saved_stays before this start, perhaps because of its cause, are also kept for
            // saved_stays after it, even if a folder or limits are configured later in that time. At the first look, all existing
            // files are from before the start.
            if (has_limits && (is_first || Clock::now() - began_at < saved_stays))
                for (const std::string& name :
                     changed_since(folder, began - stays, is_first ? std::chrono::seconds::max() : began))
                    just_saved->add(name, began_at + saved_stays);
            const auto stays_yet = [&](const std::string& name) { return just_saved->contains(name, Clock::now()); };
            if (has_limits) seen->old = delete_old(folder, limits, *ages, {since_1970(), steady}, stays_yet);
            seen->free = room_for(folder);
        },
        [this, seen](const std::string& fault) {
            has_looked_ = true;
            looked(seen->free, seen->old, fault);
        });
}

void Recordings::looked(std::optional<std::uint64_t> free, const DeletedRecordings& old, const std::string& fault) {
    is_looking_ = false;
    if (fault.empty()) free_ = free;
    for (const std::string& name : old.gone) log_info("recording: deleted {} as configured by \"keep\"", name);
    if (!old.stays.empty() && old.stays != logged_exception_)
        log_warning("recording: {} is kept although it exceeds \"keep\": keep.size is too small", old.stays);
    logged_exception_ = old.stays;
    if (std::exchange(look_again_, false)) look_soon();
}

void Recordings::repair() {
    if (folder_.empty()) return;
    const auto repaired = std::make_shared<std::vector<RepairedFile>>();
    disk_.run_detached(
        [repaired, folder = folder_] {
            stand_behind_the_loop();
            *repaired = repair_recordings(folder);
        },
        [repaired](const std::string& fault) {
            if (!fault.empty()) log_warning("recording: files of an earlier run could not be repaired: {}", fault);
            for (const RepairedFile& file : *repaired) {
                if (!file.fault.empty())
                    log_warning("recording: {} is truncated and could not be repaired: {}", file.name, file.fault);
                else
                    log_info("recording: repaired the truncated {}: {} frames, {} incomplete bytes removed", file.name,
                             file.frames, file.cut);
            }
        });
}

}    // namespace anogate
