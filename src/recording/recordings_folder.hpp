// The folder of recordings on the disk: lists, deletes and repairs its files. All functions may block; call them in threads.
#pragma once
#include <ano/fault.hpp>
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
    std::optional<std::uint64_t> frames;    // std::nullopt: not in the file
    std::optional<double> seconds;          // from its first frame to its last; std::nullopt: not in the file
    std::uint64_t begun_ns = 0;             // ns since 1970; 0: not known
    std::uint64_t changed_ns = 0;           // ns since 1970
    State state{};
};
std::string_view text(FoundRecording::State state) noexcept;

/// The content of the folder. Only files that the gateway wrote count as recordings: regular files, no symbolic links, with its
/// header.
struct FolderView {
    std::vector<FoundRecording> files;    // the newest first
    std::size_t others = 0;
    std::optional<std::uint64_t> free;    // bytes of the disk
    ano::Fault fault;                     // why the folder can't be read; empty also if it does not exist yet
};
FolderView view_of(const std::string& folder);
/// Free bytes of the disk that contains `folder` or would contain it.
std::optional<std::uint64_t> room_for(const std::string& folder);

/// Why an operation is refused, and the HTTP status for it.
struct Refusal {
    unsigned status = 0;
    ano::Fault fault;
};
/// Opens a recording for reading.
std::variant<UniqueFd, Refusal> open_recording(const std::string& folder, const std::string& name);
/// std::nullopt: success.
std::optional<Refusal> remove_recording(const std::string& folder, const std::string& name);
/// std::nullopt: no recording of that name exists in any format, so it can be begun.
std::optional<Refusal> check_new_name(const std::string& folder, const std::string& name);

struct RepairedFile {
    std::string name;
    std::uint64_t frames = 0;
    std::uint64_t cut = 0;    // bytes of an incomplete part that were removed
    std::string fault;        // why it was not repaired; empty: success
};
/// Repairs files that a power failure or a kill left incomplete. Skips files that are being written, or that are deleted
/// meanwhile.
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
    std::string stays;    // the newest file that is kept although it exceeds the limits; empty: none
};
/// Deletes files until the limits are met. `ages`: kept by the caller across all calls for this folder. `stays`: whether a file
/// is kept, by its name; called after the file was found.
DeletedRecordings delete_old(const std::string& folder, const KeepLimits& limits, RecordingAges& ages, BothClocks now,
                             const std::function<bool(const std::string&)>& stays = {});

struct SavedFrames {
    std::string name;
    std::uint64_t bytes = 0;
};
/// Saves as NAME.FORMAT, which must not exist yet, if `free` bytes of the disk stay free. After an error no file is left.
/// `is_saved` is called with the name of the complete file, while it is still locked.
std::variant<SavedFrames, Refusal> save_frames(const std::string& folder, const std::string& name, RecordingFormat format,
                                               std::uint64_t free, KeptFrames frames, RecordingOptions options = {},
                                               const std::function<void(const std::string&)>& is_saved = {});

}    // namespace anogate
