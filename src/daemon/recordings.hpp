// What a gateway records: what its configuration says, what is asked for, and the frames of the last while (keep_last).
#pragma once
#include <daemon/disk_works.hpp>
#include <daemon/frame_watch.hpp>
#include <daemon/gateway.hpp>
#include <daemon/kept_frames.hpp>
#include <daemon/recorder.hpp>
#include <daemon/recordings_folder.hpp>
#include <daemon/ticker.hpp>
#include <link/alarm.hpp>

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// What a client wants a file to be; nothing: as the configuration says.
struct WantedForm {
    std::optional<RecordingFormat> format{};
    std::optional<DecodedEncoding> encoding{};
};

/// One that a client asks for.
struct AskedRecording {
    std::string name;    // without the format's end
    RecordingFormat format = RecordingFormat::pcapng;
    RecordingOptions options{};
    FrameFilterSettings filter;
    std::optional<ano::Duration> time{};    // it ends after that
};

/// Everything is called from the loop; what may wait for the disk is done beside it.
class Recordings final : public RecordingService {
public:
    static constexpr std::size_t max_asked = 4;      // that run at once
    static constexpr std::size_t max_reading = 2;    // the last frames at once: each holds those of its time until it has them
    static constexpr std::size_t max_ending = 2;     // of the configuration, that the disk keeps from their end
    static constexpr ano::Duration between_saves = std::chrono::minutes{1};    // of keep_last by itself
    static constexpr ano::Duration saved_stays = std::chrono::minutes{1};      // to be fetched, though keep has no room for it
    static constexpr ano::Duration patience_at_the_end = std::chrono::seconds{1};

    /// `usual_folder`: where the configuration names none; empty: there is no such place. The gateway outlives it.
    Recordings(Gateway& gateway, std::string usual_folder);
    ~Recordings();
    Recordings(const Recordings&) = delete;
    Recordings& operator=(const Recordings&) = delete;

    /// Makes whole what an earlier run left, and records what the configuration says.
    void start();
    /// The gateway may have other settings now. What stays as it was goes on without a gap.
    void configure();
    /// Ends all of them. They keep the loop alive until all is written, or patience_at_the_end.
    void stop();

    // What is answered to clients.
    http::Response list();
    http::Response begin(AskedRecording asked);
    http::Response end(const std::string& name);
    http::Response remove(std::string name);
    http::Response file(const http::Request& request, std::string name);
    /// An empty name: one is made up.
    http::Response save_last(std::string name, const WantedForm& wanted);
    http::Response last(const WantedForm& wanted);

    const Gateway& gateway() const noexcept { return gateway_; }
    /// What the configuration says, where that is left open.
    RecordingFormat format_for(const WantedForm& wanted) const;
    RecordingOptions options_for(const WantedForm& wanted) const;
    struct Running;

    void link_lost(const LinkState& link) override;
    std::string start_recording() override;
    std::string stop_recording() override;
    void describe(nlohmann::ordered_json& recording) override;
    RecordingFigures figures() override;

private:
    using Say = std::function<void(http::Response)>;
    Running& launch(const AskedRecording& asked, bool is_configured);
    RecorderSettings settings_of(const AskedRecording& asked) const;
    AskedRecording configured() const;
    Running* configured_one();
    Running* find(const std::string& name);
    std::size_t count_of_asked() const;
    void named(const AskedRecording& asked, const std::string& fault, const std::optional<Refusal>& refusal, const Say& say);
    void changed(Running& running);
    void tell_news(Running& running, const RecorderReport& report);
    void reap_soon();
    void reap();
    void check_end();
    void watch_clock();
    void keep_clock();
    void look_soon();
    void look();
    std::set<std::string> just_saved();
    void looked(std::optional<std::uint64_t> free, const DeletedRecordings& old, const std::string& fault);
    void repair();
    void remember();
    void save_for(std::string_view why);
    void save(const std::string& name, const WantedForm& wanted, Say say);
    void saved(const std::variant<SavedFrames, Refusal>& result, std::uint64_t frames, const Say& say);
    nlohmann::ordered_json json_of(const Running& running) const;

    Gateway& gateway_;
    std::string usual_folder_, folder_;
    RecordSettings settings_;       // that hold; their defaults without the section
    bool is_configured_ = false;    // there is the section
    FrameWatch watch_;
    DiskWorks disk_;
    std::list<std::unique_ptr<Running>> running_;
    std::set<std::string> starting_;         // names whose place on the disk is looked at
    RecordingFigures past_;                  // of recordings that have ended
    std::unique_ptr<FrameMemory> memory_;    // nullptr: nothing is kept
    std::unique_ptr<FaultEar> ear_;
    std::optional<TimePoint> saved_at_;    // by itself, the last time
    std::string last_saved_, save_fault_;
    std::map<std::string, TimePoint> just_saved_;    // and until when they stay
    bool has_looked_ = false;
    std::string told_to_stay_;    // beyond what is kept
    std::string save_as_;         // when it is due:
    Alarm save_due_;
    std::shared_ptr<bool> reading_ = std::make_shared<bool>(true);    // and every answer of last() has it
    std::optional<std::uint64_t> free_;
    std::shared_ptr<RecordingAges> ages_ = std::make_shared<RecordingAges>();    // of folder_; one look at a time has it
    Ticker clock_;
    unsigned ticks_ = 0;
    bool is_looking_ = false, look_again_ = false;
    bool is_saving_ = false;      // frames of keep_last wait for the disk
    bool begins_late_ = false;    // the one of the configuration: when one that hangs has ended
    bool is_started_ = false, is_stopped_ = false;
    std::optional<TimePoint> end_by_;
    std::shared_ptr<bool> is_alive_ = std::make_shared<bool>(true);
};

/// What the section `record` says, for the parts that carry it out.
FrameFilterSettings frames_of(const RecordSettings& settings);
/// With room to write in any case: of a disk on which keep.free is free, nothing would be deleted while nothing can be written.
KeepLimits limits_of(const RecordSettings& settings);
/// "20261123-154735Z"
std::string name_by_time(std::chrono::seconds since_1970);

}    // namespace anogate
