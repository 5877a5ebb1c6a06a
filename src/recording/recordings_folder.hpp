// The folder of recordings on the disk: lists, deletes and repairs its files. All functions may block, and are called in threads.
#pragma once
#include <record/kept_recordings.hpp>
#include <record/recording_writer.hpp>
#include <recording/kept_frames.hpp>
#include <sys/expected.hpp>
#include <sys/unique_fd.hpp>

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate {

/// [A-Za-z0-9._-]{1,100} without a leading dot.
bool is_recording_name(std::string_view name) noexcept;
/// The rule for such names, as a clause.
std::string recording_name_rule(std::string_view given);

struct FoundRecording {
    enum class State : std::uint8_t { recording, ended, unfinished };

    std::string name;
    RecordingFormat format{};
    std::uint64_t bytes = 0;
    std::optional<std::uint64_t> frames;    // std::nullopt: the file does not say
    std::optional<double> seconds;          // from its first frame to its last; std::nullopt: the file does not say
    std::uint64_t begun_ns = 0;             // ns since 1970; 0: not known
    std::uint64_t changed_ns = 0;           // ns since 1970
    State state{};
};
std::string_view text(FoundRecording::State state) noexcept;

/// The content of the folder. Only files that the gateway wrote count as recordings: regular files, no symbolic links, with its header.
struct FolderView {
    std::vector<FoundRecording> files;    // the newest first
    std::size_t others = 0;
    std::optional<std::uint64_t> free;    // bytes of the disk
    std::string error;                    // why it can't be read; empty also when the folder does not exist yet
};
FolderView view_of(const std::string& folder);
/// Free bytes of the disk with `folder`, or on which it would be made.
std::optional<std::uint64_t> room_for(const std::string& folder);

/// Why something is not done, and the HTTP status for it.
struct Refusal {
    unsigned status = 0;
    std::string words;
};
/// Opens a recording for reading.
std::variant<UniqueFd, Refusal> open_recording(const std::string& folder, const std::string& name);
/// std::nullopt: it was removed.
std::optional<Refusal> remove_recording(const std::string& folder, const std::string& name);
/// std::nullopt: a recording of that name can be begun, since none exists in any format.
std::optional<Refusal> check_new_name(const std::string& folder, const std::string& name);

struct RepairedFile {
    std::string name;
    std::uint64_t frames = 0;
    std::uint64_t cut = 0;    // bytes of an incomplete part that were removed
    std::string fault;        // why it was not repaired; empty: it is complete now
};
/// Repairs files that were left unfinished by a loss of power or a kill; not those that are still written or deleted meanwhile.
std::vector<RepairedFile> repair_recordings(const std::string& folder);

/// The names of the recordings that were changed at `time` or later, and before `end`, by the system clock.
std::set<std::string> changed_since(const std::string& folder, std::chrono::seconds time,
                                    std::chrono::seconds end = std::chrono::seconds::max());

/// The system clock, since 1970, and the steady clock, which is never set.
struct BothClocks {
    std::chrono::seconds real{}, steady{};
};
struct DeletedRecordings {
    std::vector<std::string> gone;
    std::string stays;    // the newest file that stays although it exceeds the limits; empty: none
};
/// Deletes files until the limits are met. `ages`: from the earlier calls for this folder. `stays`: whether a file stays, by its name; it is
/// asked after the file was found.
DeletedRecordings delete_old(const std::string& folder, const KeepLimits& limits, RecordingAges& ages, BothClocks now,
                             const std::function<bool(const std::string&)>& stays = {});

struct SavedFrames {
    std::string name;
    std::uint64_t bytes = 0;
};
/// Saves as NAME.FORMAT, which must not exist yet, if `free` bytes of the disk stay free; without success there is no file. `is_saved` is called with the name of the file when
/// it is whole, while it is still locked.
std::variant<SavedFrames, Refusal> save_frames(const std::string& folder, const std::string& name, RecordingFormat format,
                                               std::uint64_t free, KeptFrames frames, RecordingOptions options = {},
                                               const std::function<void(const std::string&)>& is_saved = {});

}    // namespace anogate
