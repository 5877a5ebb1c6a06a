#include <ano_json/nearest.hpp>
#include <http/served_file.hpp>
#include <record/mcap/mcap_index.hpp>
#include <record/recording_glance.hpp>
#include <record/recording_repair.hpp>
#include <recording/recording_file.hpp>
#include <recording/recordings_folder.hpp>
#include <sys/error_fault.hpp>
#include <sys/errors.hpp>

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <utility>

namespace anogate {
namespace {

constexpr std::size_t max_recording_name = 100;
constexpr std::size_t max_file_name = max_recording_name + 20;    // with its number and extension
constexpr std::size_t bytes_at_a_time = 1024 * 1024;
constexpr std::size_t max_index = 4 * 1024 * 1024;       // bytes read of one file for a list
constexpr std::uint64_t max_cut = 2 * 1024 * 1024;       // bytes that a repair may remove
constexpr std::string_view our_program = "anogated ";    // followed by the version
constexpr std::string_view left_alone = " was not written by the gateway and is left alone";

bool may_be_in_name(char c) noexcept {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
}

bool is_name(std::string_view name, std::size_t max_length) noexcept {
    return !name.empty() && name.size() <= max_length && name.front() != '.' &&
           std::all_of(name.begin(), name.end(), may_be_in_name);
}

UniqueFd opened_folder(const std::string& folder) { return UniqueFd{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)}; }

std::string read_at(int fd, std::uint64_t at, std::size_t size) {
    std::string bytes(size, '\0');
    std::size_t have = 0;
    while (have < size) {
        const ssize_t n = ::pread(fd, bytes.data() + have, size - have, static_cast<off_t>(at + have));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        have += static_cast<std::size_t>(n);
    }
    bytes.resize(have);
    return bytes;
}

RecordingGlance glance_at_file(int fd, RecordingFormat format, std::uint64_t size) {
    const std::uint64_t last = size > glance_size ? size - glance_size : 0;
    return glance_at(format, read_at(fd, 0, glance_size), read_at(fd, last, glance_size));
}

bool is_ours(const RecordingGlance& glance) { return glance.head.program.starts_with(our_program); }

/// The writer of a recording keeps it locked (flock). The check holds a shared lock for a moment, so that several can check at
/// once.
bool is_locked(int fd) {
    if (::flock(fd, LOCK_SH | LOCK_NB) != 0) return errno == EWOULDBLOCK;
    ::flock(fd, LOCK_UN);
    return false;
}

/// Locks a recording against other repairs as long as `fd` is open. The lock is of another kind than that of is_locked() and does
/// not affect it: the file counts as not being written, and may be deleted meanwhile.
bool lock_to_repair(int fd) {
    struct flock all {};
    all.l_type = F_WRLCK;
    all.l_whence = SEEK_SET;
    return ::fcntl(fd, F_OFD_SETLK, &all) == 0;
}

bool is_deleted(int fd) {
    struct stat is {};
    return ::fstat(fd, &is) == 0 && is.st_nlink == 0;
}

struct OpenRecording {
    UniqueFd fd;
    struct stat is {};
    RecordingFormat format{};
    RecordingGlance glance;
};

/// Opens a recording that the gateway wrote; std::nullopt: another program wrote it (errno 0), or it can't be opened (errno is
/// set).
std::optional<OpenRecording> open_ours(int folder, const std::string& name, bool writable = false) {
    errno = 0;
    const auto format = recording_format_of(name);
    if (!format || !is_name(name, max_file_name)) return std::nullopt;
    OpenRecording file;
    file.fd = open_regular(folder, name, writable);
    if (!file.fd || ::fstat(file.fd.get(), &file.is) != 0) return std::nullopt;
    file.format = *format;
    file.glance = glance_at_file(file.fd.get(), *format, static_cast<std::uint64_t>(file.is.st_size));
    errno = 0;
    return is_ours(file.glance) ? std::optional{std::move(file)} : std::nullopt;
}

struct CloseFolder {
    void operator()(DIR* folder) const noexcept { ::closedir(folder); }
};

/// The names of everything except folders and hidden files: names of recordings never begin with a dot.
std::vector<std::string> names_in(int folder) {
    std::vector<std::string> names;
    UniqueFd again{::openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
    const std::unique_ptr<DIR, CloseFolder> list{again ? ::fdopendir(again.get()) : nullptr};
    if (list) again.release();
    while (list) {
        const dirent* const entry = ::readdir(list.get());
        if (!entry) break;
        if (entry->d_name[0] != '.' && entry->d_type != DT_DIR) names.emplace_back(entry->d_name);
    }
    return names;
}

// 0: the clock was set before 1970.
std::uint64_t nanoseconds_of(const timespec& time) noexcept {
    if (time.tv_sec < 0) return 0;
    return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000 + static_cast<std::uint64_t>(time.tv_nsec);
}

FoundRecording found(const std::string& name, const OpenRecording& file) {
    FoundRecording recording;
    recording.name = name;
    recording.format = file.format;
    recording.bytes = static_cast<std::uint64_t>(file.is.st_size);
    recording.frames = file.glance.frames;
    recording.seconds = file.glance.seconds;
    recording.begun_ns = file.glance.head.time_ns;
    recording.changed_ns = nanoseconds_of(file.is.st_mtim);
    using State = FoundRecording::State;
    recording.state = is_locked(file.fd.get()) ? State::recording : file.glance.is_ended ? State::ended : State::unfinished;
    return recording;
}

// Skipped if the index is large: reading it would take too long for a list.
void add_counts_of_mcap(int folder, FoundRecording& recording) {
    const UniqueFd fd = open_regular(folder, recording.name, false);
    if (!fd) return;
    std::size_t left = max_index;
    const auto index = read_mcap_index(recording.bytes, [&](std::uint64_t at, std::size_t size) {
        if (size > left) return std::string{};
        left -= size;
        return read_at(fd.get(), at, size);
    });
    if (!index) return;
    recording.frames = index->counts.frames;
    if (index->counts.frames > 0) recording.seconds = index->counts.seconds();
}

/// Without the number of frames and the length of MCAP files, because these need more reading.
FolderView quick_view_of(const std::string& folder) {
    FolderView view;
    const UniqueFd at = opened_folder(folder);
    if (!at && errno != ENOENT) view.fault = error_fault(folder, errno);
    view.free = room_for(folder);
    if (!at) return view;
    for (const std::string& name : names_in(at.get())) {
        if (const auto file = open_ours(at.get(), name)) view.files.push_back(found(name, *file));
        else ++view.others;
    }
    std::sort(view.files.begin(), view.files.end(), [](const FoundRecording& a, const FoundRecording& b) {
        return std::tie(b.changed_ns, b.begun_ns, b.name) < std::tie(a.changed_ns, a.begun_ns, a.name);
    });
    return view;
}

/// " (did you mean 'flight.mcap'?)", or empty. A name without an extension is compared with names without extensions.
std::string file_meant_by(const std::string& name, std::vector<std::string> files) {
    std::sort(files.begin(), files.end());
    const bool has_end = recording_format_of(name).has_value();
    std::vector<std::string_view> words;
    words.reserve(files.size());
    for (const std::string_view file : files) words.push_back(has_end ? file : file.substr(0, file.rfind('.')));
    const std::string_view meant = ano::nearest(name, words);
    const auto at = std::find(words.begin(), words.end(), meant) - words.begin();
    return meant.empty() ? std::string{} : " (did you mean '" + files[static_cast<std::size_t>(at)] + "'?)";
}

/// "; there is flight.mcap", or file_meant_by().
std::string there_is(int folder, const std::string& name) {
    std::vector<std::string> files = names_in(folder);
    std::erase_if(files, [](const std::string& file) { return !recording_format_of(file); });
    std::string same;
    for (const std::string& file : files)
        if (file.substr(0, file.rfind('.')) == name.substr(0, recording_format_of(name) ? name.rfind('.') : name.npos))
            same += (same.empty() ? "; there is " : " and ") + file;
    if (!same.empty()) return same;
    return file_meant_by(name, std::move(files));
}

Refusal refusal_of_open(int folder, const std::string& name, int error) {
    struct stat is {};
    if (error == 0 && is_name(name, max_file_name) && ::fstatat(folder, name.c_str(), &is, AT_SYMLINK_NOFOLLOW) != 0)
        error = errno;
    if (error == ENOENT) return {404, {"other", "there is no recording " + name + there_is(folder, name)}};
    if (error == 0 || error == EINVAL || error == ELOOP) return {403, {"other", name + std::string{left_alone}}};
    return {error == EACCES || error == EPERM ? 403u : 503u, error_fault(name, error)};
}

Refusal refusal_of_folder(const std::string& folder, int error) {
    if (error == ENOENT) return {404, {"other", "there is no recording yet"}};
    return {503, error_fault(folder, error)};
}

/// Removes the file that was checked, but not another one that was given its name meanwhile.
std::optional<Refusal> unlink_same(int folder, const std::string& name, const struct stat& was) {
    struct stat is {};
    if (::fstatat(folder, name.c_str(), &is, AT_SYMLINK_NOFOLLOW) != 0)
        return Refusal{404, {"other", "there is no recording " + name}};
    if (is.st_dev != was.st_dev || is.st_ino != was.st_ino)
        return Refusal{409, {"other", name + " was replaced by another file"}};
    if (::unlinkat(folder, name.c_str(), 0) == 0) return std::nullopt;
    return Refusal{errno == EACCES || errno == EPERM || errno == EROFS ? 403u : 503u, error_fault(name, errno)};
}

bool append_all(int fd, std::uint64_t at, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::pwrite(fd, bytes.data(), bytes.size(), static_cast<off_t>(at));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        at += static_cast<std::uint64_t>(n);
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
}

/// Keeps the modification time, which is that of the last frame. Writes the new end before it removes the rest, so that a failure
/// loses no data.
std::string make_whole(const OpenRecording& file, const RecordingRepair::Result& result) {
    const int fd = file.fd.get();
    const std::uint64_t end = result.keep + result.append.size();
    const bool done = append_all(fd, result.keep, result.append) && ::ftruncate(fd, static_cast<off_t>(end)) == 0;
    const int error = errno;
    const std::array<timespec, 2> times{file.is.st_atim, file.is.st_mtim};
    ::futimens(fd, times.data());
    ::fsync(fd);
    return done ? std::string{} : error_text(error);
}

// A repair discards an incomplete part at the end. This many bytes are more than one part and may still be readable.
std::string damage_text(std::uint64_t behind, std::uint64_t bytes) {
    return "it is damaged after byte " + std::to_string(behind) + ", and the " + std::to_string(bytes) +
           " bytes after it are not discarded";
}

std::optional<RepairedFile> repair(int folder, const std::string& name) {
    const auto file = open_ours(folder, name, true);
    if (!file || file->glance.is_ended || is_locked(file->fd.get()) || !lock_to_repair(file->fd.get())) return std::nullopt;
    RecordingRepair repair{file->format};
    std::uint64_t at = 0, written = 0;    // after a power failure, zeros may follow the written bytes
    for (std::string piece = read_at(file->fd.get(), 0, bytes_at_a_time); !piece.empty();
         piece = read_at(file->fd.get(), at, bytes_at_a_time)) {
        if (is_deleted(file->fd.get())) return std::nullopt;    // it was deleted: closing it frees its space
        repair.feed(piece);
        if (const auto last = piece.find_last_not_of('\0'); last != piece.npos) written = at + last + 1;
        at += piece.size();
    }
    const RecordingRepair::Result result = repair.finish();
    if (result.is_whole) return std::nullopt;
    RepairedFile repaired{name, result.frames, at > result.keep ? at - result.keep : 0, {}};
    if (!result.is_recording) repaired.fault = "it is damaged before its first frame";
    else if (written > result.keep + max_cut) repaired.fault = damage_text(result.keep, written - result.keep);
    else repaired.fault = make_whole(*file, result);
    return repaired;
}

}    // namespace

bool is_recording_name(std::string_view name) noexcept { return is_name(name, max_recording_name); }

std::string recording_name_rule(std::string_view given) {
    return "a name must have 1 to 100 of A-Z, a-z, 0-9, '.', '_' and '-', and no leading dot" +
           std::string{given.size() > max_recording_name ? ": this one has " + std::to_string(given.size()) : ""};
}

std::string_view text(FoundRecording::State state) noexcept {
    switch (state) {
    case FoundRecording::State::recording: return "recording";
    case FoundRecording::State::ended: return "ended";
    case FoundRecording::State::unfinished: break;
    }
    return "unfinished";
}

std::optional<std::uint64_t> room_for(const std::string& folder) {
    std::filesystem::path there = folder;
    std::optional<std::uint64_t> room = free_bytes(folder);
    while (!room && there.has_relative_path()) {
        there = there.parent_path();
        room = free_bytes(there.empty() ? "." : there.string());
    }
    return room;
}

FolderView view_of(const std::string& folder) {
    FolderView view = quick_view_of(folder);
    const UniqueFd at = opened_folder(folder);
    for (FoundRecording& file : view.files)
        if (at && file.format == RecordingFormat::mcap && file.state == FoundRecording::State::ended)
            add_counts_of_mcap(at.get(), file);
    return view;
}

std::variant<UniqueFd, Refusal> open_recording(const std::string& folder, const std::string& name) {
    if (!is_name(name, max_file_name)) return Refusal{422, {"other", recording_name_rule(name)}};
    const UniqueFd at = opened_folder(folder);
    if (!at) return refusal_of_folder(folder, errno);
    auto file = open_ours(at.get(), name);
    if (!file) return refusal_of_open(at.get(), name, errno);
    return std::move(file->fd);
}

std::optional<Refusal> remove_recording(const std::string& folder, const std::string& name) {
    if (!is_name(name, max_file_name)) return Refusal{422, {"other", recording_name_rule(name)}};
    const UniqueFd at = opened_folder(folder);
    if (!at) return refusal_of_folder(folder, errno);
    const auto file = open_ours(at.get(), name);
    if (!file) return refusal_of_open(at.get(), name, errno);
    if (is_locked(file->fd.get())) return Refusal{409, {"still_recorded", name}};
    return unlink_same(at.get(), name, file->is);
}

std::optional<Refusal> check_new_name(const std::string& folder, const std::string& name) {
    const UniqueFd at = opened_folder(folder);
    if (!at && errno != ENOENT) return Refusal{507, error_fault(folder, errno)};
    for (const RecordingFormat format : {RecordingFormat::pcapng, RecordingFormat::mcap}) {
        const std::string file = name + "." + std::string{text(format)};
        struct stat is {};
        if (at && ::fstatat(at.get(), file.c_str(), &is, AT_SYMLINK_NOFOLLOW) == 0)
            return Refusal{409, {"other", file + " already exists: choose another name"}};
    }
    return std::nullopt;
}

std::vector<RepairedFile> repair_recordings(const std::string& folder) {
    std::vector<RepairedFile> all;
    const UniqueFd at = opened_folder(folder);
    if (!at) return all;
    for (const std::string& name : names_in(at.get()))
        if (auto repaired = repair(at.get(), name)) all.push_back(std::move(*repaired));
    return all;
}

std::set<std::string> changed_since(const std::string& folder, std::chrono::seconds time, std::chrono::seconds end) {
    std::set<std::string> names;
    for (const FoundRecording& file : quick_view_of(folder).files) {
        const std::chrono::seconds changed{file.changed_ns / 1'000'000'000};
        if (changed >= time && changed < end) names.insert(file.name);
    }
    return names;
}

DeletedRecordings delete_old(const std::string& folder, const KeepLimits& limits, RecordingAges& ages, BothClocks now,
                             const std::function<bool(const std::string&)>& stays) {
    DeletedRecordings deleted;
    const FolderView view = quick_view_of(folder);
    std::vector<KeptRecording> kept;
    for (const FoundRecording& file : view.files)
        kept.push_back({file.name,
                        file.bytes,
                        std::chrono::seconds{file.changed_ns / 1'000'000'000},
                        file.state == FoundRecording::State::recording,
                        {},
                        stays && stays(file.name)});
    ages.look(kept, now.real, now.steady);
    const RecordingsToDelete old = recordings_to_delete(kept, limits, view.free.value_or(UINT64_MAX));
    for (const std::size_t i : old.going)
        if (!remove_recording(folder, kept[i].name)) deleted.gone.push_back(kept[i].name);
    if (old.stays) deleted.stays = kept[*old.stays].name;
    return deleted;
}

namespace {

// Returns empty, or the reason why not all is on the disk.
std::string write_frames(KeptFramesWriting writing, const std::string& folder, std::uint64_t free, RecordingFile& file) {
    for (bool more = true; more;) {
        std::string bytes;
        while (more && bytes.size() < bytes_at_a_time) more = writing.next(bytes);
        const auto is_free = free_bytes(folder);
        const std::uint64_t needed = free + bytes.size();
        if (is_free && *is_free < needed)
            return "only " + std::to_string(*is_free) + " bytes of disk space are free, and " + std::to_string(needed) +
                   " are needed";
        if (const int error = file.append(bytes); error != 0) return error_text(error);
    }
    if (const int error = file.sync(); error != 0) return error_text(error);
    return file.is_there() ? "" : "it was removed in the meantime";
}

}    // namespace

std::variant<SavedFrames, Refusal> save_frames(const std::string& folder, const std::string& name, RecordingFormat format,
                                               std::uint64_t free, KeptFrames frames, RecordingOptions options,
                                               const std::function<void(const std::string&)>& is_saved) {
    unsigned number = 1;
    auto made = RecordingFile::create(folder, name, format, number);
    if (const auto* fault = std::get_if<DiskFault>(&made)) return Refusal{507, fault->fault};
    RecordingFile& file = std::get<RecordingFile>(made);
    std::string fault;
    try {
        fault = write_frames({std::move(frames), format, options}, folder, free, file);
    } catch (const std::bad_alloc&) {
        fault = "no memory";
    }
    const std::string saved = std::filesystem::path{file.path()}.filename().string();
    if (fault.empty()) {
        if (is_saved) is_saved(saved);
        return SavedFrames{saved, file.size()};
    }
    file.remove();
    return Refusal{507, {"system_error", saved + " is not saved", fault}};
}

}    // namespace anogate
