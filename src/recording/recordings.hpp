// The recordings of a gateway: that of its configuration, those that clients start, and the latest frames (keep_last).
#pragma once
#include <http/task_pool.hpp>
#include <recording/just_saved.hpp>
#include <recording/kept_frames.hpp>
#include <recording/recorder.hpp>
#include <recording/recordings_folder.hpp>
#include <runtime/gateway.hpp>
#include <sys/ticker.hpp>
#include <watch/frame_watch.hpp>

#include <chrono>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// The format that a client requests; std::nullopt: as configured.
struct WantedForm {
    std::optional<RecordingFormat> format{};
    std::optional<DecodedEncoding> encoding{};
};

/// A recording that a client requests.
struct AskedRecording {
    std::string name;    // without the file extension
    RecordingFormat format = RecordingFormat::pcapng;
    RecordingOptions options{};
    FrameFilterSettings filter;
    std::optional<ano::Duration> time{};    // its duration; std::nullopt: until it is ended
};

/// All calls must be from the loop; operations that may block on the disk are done in threads.
class Recordings final : public RecordingService, private GatewayEvents {
public:
    static constexpr std::size_t max_asked = 4;      // recorded at once
    static constexpr std::size_t max_reading = 2;    // downloads of the latest frames at once: each keeps its frames in memory
    static constexpr std::size_t max_ending = 2;     // recordings of the configuration that can't end because the disk hangs
    static constexpr ano::Duration between_saves = std::chrono::minutes{1};    // between automatic saves of keep_last
    static constexpr ano::Duration after_a_failed_save = std::chrono::seconds{5};
    static constexpr ano::Duration saved_stays = std::chrono::minutes{1};    // how long a saved file is not deleted for `keep`
    static constexpr ano::Duration patience_at_the_end = std::chrono::seconds{1};

    /// `usual_folder`: used if the configuration names no folder; empty: there is none. `gateway` and `watch` must outlive this object.
    Recordings(Gateway& gateway, FrameWatch& watch, std::string usual_folder);
    ~Recordings();
    Recordings(const Recordings&) = delete;
    Recordings& operator=(const Recordings&) = delete;

    /// Repairs the incomplete files of an earlier run, and begins the recording of the configuration.
    void start();
    /// Applies the present settings of the gateway. Recordings with unchanged settings continue without a gap.
    void configure();
    /// Takes in the frames that passed until now, so that a change does not apply to them.
    void catch_up();
    /// Ends all recordings. They keep the loop alive until everything is written, at most patience_at_the_end; then `ended` is
    /// called. After that, clients get no responses.
    void stop(std::function<void()> ended = [] {});

    // The responses to clients.
    http::Response list();
    http::Response begin(AskedRecording asked);
    http::Response end(const std::string& name);
    http::Response remove(std::string name);
    http::Response file(const http::Request& request, std::string name);
    /// An empty `name` is replaced by one made from the time.
    http::Response save_last(std::string name, const WantedForm& wanted);
    http::Response last(const WantedForm& wanted);

    const Gateway& gateway() const noexcept { return gateway_; }
    /// Options that `wanted` leaves open are as configured.
    RecordingFormat format_for(const WantedForm& wanted) const;
    RecordingOptions options_for(const WantedForm& wanted) const;
    struct Running;

    std::string start_recording() override;
    std::string stop_recording() override;
    void describe(nlohmann::ordered_json& recording) override;
    RecordingFigures figures() override;

private:
    void link_lost(const LinkState& link) override;
    using Respond = std::function<void(http::Response)>;
    Running& launch(const AskedRecording& asked, bool is_configured);
    RecorderSettings settings_of(const AskedRecording& asked) const;
    AskedRecording configured() const;
    Running* configured_one();
    Running* find(const std::string& name);
    std::size_t count_of_asked() const;
    void named(const AskedRecording& asked, const std::string& fault, const std::optional<Refusal>& refusal,
               const Respond& respond);
    void changed(Running& running);
    void log_changes(Running& running, const RecorderReport& report);
    void reap_soon();
    void reap();
    void check_end();
    void watch_clock();
    void keep_clock();
    void look_soon();
    void look();
    void looked(std::optional<std::uint64_t> free, const DeletedRecordings& old, const std::string& fault);
    void repair();
    void remember();
    /// A save of the latest frames, with the frames and the settings of the moment of the request.
    struct Save {
        std::string name, folder;
        KeptFrames frames;
        RecordingFormat format;
        RecordingOptions options;
        std::uint64_t free = 0;
        Respond respond{};    // empty: automatic, no client waits
    };
    Save save_of(std::string name, const WantedForm& wanted, Respond respond);
    void save_for(std::string_view why);
    void save_due();
    void save(Save what);
    void saved(const std::variant<SavedFrames, Refusal>& result, std::uint64_t frames, const Respond& respond);
    void saving_ended();
    nlohmann::ordered_json json_of(const Running& running) const;

    Gateway& gateway_;
    std::string usual_folder_, folder_;
    RecordSettings settings_;       // the present settings; the defaults when the section `record` is missing
    bool is_configured_ = false;    // the section `record` exists
    FrameWatch& watch_;
    TaskPool disk_;
    std::list<std::unique_ptr<Running>> running_;
    std::set<std::string> starting_;         // names that are being checked on the disk
    RecordingFigures past_;                  // sums over the ended recordings
    std::unique_ptr<FrameMemory> memory_;    // nullptr: keep_last is off
    std::unique_ptr<FaultTrigger> fault_trigger_;
    std::optional<TimePoint> next_save_;    // before that, nothing is saved automatically
    std::string last_saved_;
    ano::Fault save_fault_;
    std::shared_ptr<JustSaved> just_saved_ = std::make_shared<JustSaved>();
    const std::chrono::seconds began_ = std::chrono::duration_cast<std::chrono::seconds>(
        std::chrono::system_clock::now().time_since_epoch());    // the start of this program, by both clocks
    const TimePoint began_at_ = Clock::now();
    bool has_looked_ = false;
    std::string logged_exception_;    // file that is kept although it exceeds `keep`, as logged last
    std::optional<Save> due_;         // an automatic save that waits until another is done
    std::shared_ptr<bool> reading_ = std::make_shared<bool>(true);    // also held by every response of last()
    std::optional<std::uint64_t> free_;
    std::shared_ptr<RecordingAges> ages_ = std::make_shared<RecordingAges>();    // of folder_; used by one look at a time
    Ticker clock_;
    unsigned ticks_ = 0;
    bool is_looking_ = false, look_again_ = false;
    bool is_saving_ = false;      // frames of keep_last are being saved, for a client or automatically
    bool begins_late_ = false;    // the recording of the configuration begins when a hanging one has ended
    bool is_started_ = false, is_stopped_ = false;
    std::optional<TimePoint> end_by_;
    std::function<void()> ended_;
    std::shared_ptr<bool> is_alive_ = std::make_shared<bool>(true);
};

/// Selects the frames to record by the section `record`.
FrameFilterSettings frames_of(const RecordSettings& settings);
/// The limits for delete_old(). The free space includes the room that writing needs: otherwise, with exactly keep.free bytes
/// free, no file would be deleted and none could be written.
KeepLimits limits_of(const RecordSettings& settings);
/// "20261123-154735Z"
std::string name_by_time(std::chrono::seconds since_1970);

}    // namespace anogate
