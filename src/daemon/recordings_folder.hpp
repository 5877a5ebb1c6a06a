// The folder of recordings on the disk: what is in it, what goes, what is made whole. All of it may block, and is called in threads.
#pragma once
#include <daemon/kept_frames.hpp>
#include <link/expected.hpp>
#include <link/unique_fd.hpp>
#include <record/kept_recordings.hpp>
#include <record/recording_writer.hpp>

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate {

/// [A-Za-z0-9._-]{1,100} without a leading dot.
bool is_recording_name(std::string_view name) noexcept;
/// What such a name must be, in a clause.
std::string recording_name_rule(std::string_view given);

struct FoundRecording {
    enum class State : std::uint8_t { recording, ended, unfinished };

    std::string name;
    RecordingFormat format{};
    std::uint64_t bytes = 0;
    std::optional<std::uint64_t> frames;    // nothing: the file does not tell
    std::optional<double> seconds;          // from its first frame to its last; nothing: the file does not tell
    std::uint64_t begun_ns = 0;             // since 1970; 0: not known
    std::uint64_t changed_ns = 0;           // since 1970
    State state{};
};
std::string_view text(FoundRecording::State state) noexcept;

/// What is in the folder. Only what the gateway wrote counts as a recording: a regular file, no link, whose head says so.
struct FolderView {
    std::vector<FoundRecording> files;    // the newest first
    std::size_t others = 0;
    std::optional<std::uint64_t> free;    // bytes of the disk
    std::string error;                    // why it can't be looked at; empty where it is only missing yet
};
FolderView view_of(const std::string& folder);
/// Free bytes of the disk that it is on, or will be when it is made.
std::optional<std::uint64_t> room_for(const std::string& folder);

/// Why something is not done, and the status of HTTP that says so.
struct Refusal {
    unsigned status = 0;
    std::string words;
};
/// A recording to read.
std::variant<UniqueFd, Refusal> open_recording(const std::string& folder, const std::string& name);
/// Nothing: it is gone.
std::optional<Refusal> remove_recording(const std::string& folder, const std::string& name);
/// One of that name can be begun: none is there in any format.
std::optional<Refusal> check_new_name(const std::string& folder, const std::string& name);

struct RepairedFile {
    std::string name;
    std::uint64_t frames = 0;
    std::uint64_t cut = 0;    // bytes that were no whole part
    std::string fault;        // why it stays as it is; empty: it is whole now
};
/// Makes whole what was cut by a loss of power or by force; not what somebody still writes, or is deleted meanwhile.
std::vector<RepairedFile> repair_recordings(const std::string& folder);

/// What the clocks say: the one that is set, since 1970, and the one that nobody sets.
/// The names of those that changed then or later, by the system's clock.
std::set<std::string> changed_since(const std::string& folder, std::chrono::seconds time);

struct BothClocks {
    std::chrono::seconds real{}, steady{};
};
struct DeletedRecordings {
    std::vector<std::string> gone;
    std::string stays;    // the newest that stays though it is beyond what is kept; empty: there is none
};
/// Deletes what the limits do not leave. `ages` has seen the folder when it was called before; `just_saved` are names.
DeletedRecordings delete_old(const std::string& folder, const KeepLimits& limits, RecordingAges& ages, BothClocks now,
                             const std::set<std::string>& just_saved = {});

/// As NAME.FORMAT, where that is not there yet, while `free` bytes of the disk stay free.
struct SavedFrames {
    std::string name;
    std::uint64_t bytes = 0;
};
std::variant<SavedFrames, Refusal> save_frames(const std::string& folder, const std::string& name, RecordingFormat format,
                                               std::uint64_t free, KeptFrames frames, RecordingOptions options = {});

}    // namespace anogate
