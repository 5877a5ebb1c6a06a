#include <http/listeners/token_file.hpp>
#include <sys/errors.hpp>
#include <sys/files/write_all.hpp>
#include <sys/random.hpp>
#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>

namespace anogate::http {
namespace {

constexpr std::size_t token_bytes = 32, min_token = 16, max_token = 256, max_file = 64 * 1024;

bool is_token(std::string_view text) {
    constexpr std::string_view allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~+/=";
    return text.size() >= min_token && text.size() <= max_token && text.find_first_not_of(allowed) == text.npos;
}

std::string draft_of(const std::string& path, pid_t process) { return path + "." + std::to_string(process); }

// Removes drafts of processes that ended while they made the file.
void remove_old_drafts(const std::string& path) {
    namespace fs = std::filesystem;
    std::error_code ec;
    const std::string begin = fs::path{path}.filename().string() + ".";
    const fs::path folder = fs::absolute(path, ec).parent_path();
    for (fs::directory_iterator entry{folder, ec}; !ec && entry != fs::directory_iterator{}; entry.increment(ec)) {
        const std::string name = entry->path().filename().string();
        if (!name.starts_with(begin)) continue;
        pid_t process = 0;
        const auto [end, fault] = std::from_chars(name.data() + begin.size(), name.data() + name.size(), process);
        if (fault != std::errc{} || end != name.data() + name.size() || process <= 0) continue;
        const bool may_be_written = process != ::getpid() && (::kill(process, 0) == 0 || errno != ESRCH);
        if (!may_be_written) ::unlink(entry->path().c_str());
    }
}

// Written under another name first, so that the file always has both tokens.
Expected<void> make(const std::string& path) {
    namespace fs = std::filesystem;
    const auto failed = [&] { return Unexpected{error_text(path, errno)}; };
    std::error_code ec;
    if (const fs::path folder = fs::path{path}.parent_path(); !folder.empty()) fs::create_directories(folder, ec);
    const auto view = random_hex(token_bytes), control = random_hex(token_bytes);
    if (!view || !control) return failed();
    const std::string text = "# view: read-only; control: full access. Send as: Authorization: Bearer TOKEN\nview " + *view +
                             "\ncontrol " + *control + "\n";
    const std::string draft = draft_of(path, ::getpid());
    const UniqueFd fd{::open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR)};
    if (!fd) return failed();
    const bool written = write_all(fd.get(), text) && ::link(draft.c_str(), path.c_str()) == 0;
    const int error = errno;
    ::unlink(draft.c_str());
    if (!written && error != EEXIST) return Unexpected{error_text(path, error)};    // EEXIST: made by another process
    return {};
}

UniqueFd open_to_read(const std::string& path) {
    return UniqueFd{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)};    // O_NONBLOCK: not to block on a pipe
}

Expected<std::vector<Token>> read_tokens(const UniqueFd& fd, const std::string& path) {
    struct stat facts {};
    if (!fd || ::fstat(fd.get(), &facts) != 0) return Unexpected{error_text(path, errno)};
    if (!S_ISREG(facts.st_mode)) return Unexpected{path + ": is not a file"};
    if ((facts.st_mode & S_IRWXO) != 0)
        return Unexpected{path + ": every user of this computer can read it; run chmod o= " + path};
    std::string text(max_file, '\0');
    const ssize_t size = ::read(fd.get(), text.data(), text.size());
    if (size < 0) return Unexpected{error_text(path, errno)};
    text.resize(static_cast<std::size_t>(size));
    auto tokens = parse_tokens(text);
    if (!tokens) return Unexpected{path + ": " + tokens.error()};
    return tokens;
}

// Checks the last folder of the path that exists: missing ones are made in it.
Expected<void> check_place(const std::string& path) {
    namespace fs = std::filesystem;
    std::error_code ec;
    fs::path folder = fs::absolute(path, ec).parent_path();
    while (!fs::exists(folder, ec) && folder.has_relative_path()) folder = folder.parent_path();
    if (!fs::is_directory(folder, ec)) return Unexpected{error_text(path, ENOTDIR)};
    if (::access(folder.c_str(), W_OK | X_OK) != 0) return Unexpected{error_text(path, errno)};
    return {};
}

}    // namespace

Expected<std::vector<Token>> parse_tokens(std::string_view text) {
    std::vector<Token> tokens;
    for (std::size_t number = 1; !text.empty(); ++number) {
        std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(text.size(), line.size() + 1));
        line = line.substr(0, line.find_last_not_of(" \t\r") + 1);
        line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
        if (line.empty() || line.front() == '#') continue;
        const std::string_view allows = line.substr(0, line.find_first_of(" \t"));
        std::string_view token = line.substr(allows.size());
        token.remove_prefix(std::min(token.find_first_not_of(" \t"), token.size()));
        const std::string where = "line " + std::to_string(number) + ": ";    // without the line itself: it may hold a token
        if (allows != "view" && allows != "control") return Unexpected{where + "a line must be 'view TOKEN' or 'control TOKEN'"};
        if (!is_token(token)) return Unexpected{where + "a token has 16 to 256 letters, digits or characters of -._~+/="};
        tokens.push_back({allows == "view" ? Access::view : Access::control, std::string{token}});
    }
    if (tokens.empty()) return Unexpected{"it contains no token; delete the file to create one of each"};
    return tokens;
}

Expected<std::vector<Token>> read_or_make_tokens(const std::string& path) {
    remove_old_drafts(path);
    UniqueFd fd = open_to_read(path);
    if (!fd && errno == ENOENT) {
        if (auto made = make(path); !made) return Unexpected{std::move(made.error())};
        fd = open_to_read(path);
    }
    return read_tokens(fd, path);
}

// A digest of the file's location, not of its content: a weak token could be guessed from a digest.
std::string id_of_token_file(const std::string& path) {
    struct stat facts {};
    ::stat(path.c_str(), &facts);
    std::error_code ec;
    const std::string text = std::filesystem::absolute(path, ec).lexically_normal().string() + '\n' +
                             std::to_string(facts.st_dev) + '\n' + std::to_string(facts.st_ino);
    constexpr std::uint32_t basis = 2166136261, prime = 16777619;    // FNV-1a
    std::uint32_t digest = basis;
    for (const char c : text) digest = (digest ^ static_cast<unsigned char>(c)) * prime;
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", digest);
    return digits;
}

Expected<void> check_tokens(const std::string& path) {
    const UniqueFd fd = open_to_read(path);
    if (!fd && errno == ENOENT) return check_place(path);
    if (auto tokens = read_tokens(fd, path); !tokens) return Unexpected{std::move(tokens.error())};
    return {};
}

}    // namespace anogate::http
