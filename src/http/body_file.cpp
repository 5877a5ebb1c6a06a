#include <http/body_file.hpp>
#include <sys/asio.hpp>
#include <sys/errors.hpp>
#include <sys/files/state_folder.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <utility>

namespace anogate {
namespace {

std::string temporary_folder() {
    const char* folder = std::getenv("TMPDIR");
    return folder && *folder != '\0' ? folder : "/tmp";
}

// O_TMPFILE is not supported by all file systems.
int unnamed_file(const std::string& folder) {
    const int fd = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (fd >= 0 || (errno != EOPNOTSUPP && errno != EISDIR)) return fd;
    std::string name = folder + "/body-XXXXXX";
    const int named = ::mkostemp(name.data(), O_CLOEXEC);
    if (named >= 0) ::unlink(name.c_str());
    return named;
}

Expected<std::shared_ptr<BodyFile>> file_somewhere() {
    const std::string state = state_folder();
    if (!state.empty())
        if (auto file = BodyFile::make(state)) return file;
    return BodyFile::make(temporary_folder());
}

std::string with_advice(const std::string& fault) {
    return "no space for such a large body: " + fault + "; free some space there, or set STATE_DIRECTORY to another folder";
}

}    // namespace

Expected<std::shared_ptr<BodyFile>> BodyFile::make(const std::string& folder) {
    std::error_code ec;
    std::filesystem::create_directories(folder, ec);
    UniqueFd fd{unnamed_file(folder)};
    if (!fd) return Unexpected{error_text(folder, errno)};
    return std::make_shared<BodyFile>(std::move(fd));
}

std::string BodyFile::append(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::pwrite(fd_.get(), bytes.data(), bytes.size(), static_cast<off_t>(size_));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return error_text(n < 0 ? errno : ENOSPC);
        size_ += static_cast<std::uint64_t>(n);
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return {};
}

bool BodyFile::read(std::uint64_t at, std::span<std::uint8_t> into) const {
    while (!into.empty()) {
        const ssize_t n = ::pread(fd_.get(), into.data(), into.size(), static_cast<off_t>(at));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        at += static_cast<std::uint64_t>(n);
        into = into.subspan(static_cast<std::size_t>(n));
    }
    return true;
}

void FileKeeper::put(std::string part, std::function<void(std::string fault)> done) {
    const auto work = [kept = kept_, part = std::move(part)] {
        if (!kept->file) {
            auto made = file_somewhere();
            if (!made) kept->fault = made.error();
            else kept->file = std::move(*made);
        }
        if (kept->file) kept->fault = kept->file->append(part);
    };
    const auto on_done = [kept = kept_, done](const std::string& thrown) {
        const std::string& fault = thrown.empty() ? kept->fault : thrown;
        done(fault.empty() ? fault : with_advice(fault));
    };
    if (background_task_.run(work, on_done)) return;
    asio::post(io_,
               [done = std::move(done), why = background_task_.why_not()] { done(std::string{why} + " for so large a body"); });
}

}    // namespace anogate
