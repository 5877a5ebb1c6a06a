#include "browser.hpp"
#include <anoctl/anoctl.hpp>
#include <anoctl/run_program.hpp>

#include <sys/errors.hpp>
#include <sys/files/write_all.hpp>
#include <sys/random.hpp>
#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <vector>

namespace anoctl {
namespace {

/// The user who called sudo; nullptr: none.
const passwd* caller_of_sudo() {
    const char* const name = ::geteuid() == 0 ? std::getenv("SUDO_USER") : nullptr;
    return name ? ::getpwnam(name) : nullptr;
}

std::string home() {
    if (const passwd* const caller = caller_of_sudo()) return caller->pw_dir;
    const char* const home = std::getenv("HOME");
    return home ? home : "";
}

constexpr std::string_view page_begin = "anogate-", page_end = ".html";
constexpr std::size_t page_bytes = 8;                    // random bytes in the name
constexpr auto page_serves = std::chrono::minutes{5};    // the code is valid as long

// Removes the pages of programs that were killed.
void remove_old_pages(const std::string& folder) {
    std::error_code ec;
    for (std::filesystem::directory_iterator one{folder, ec}, end; !ec && one != end; one.increment(ec)) {
        const std::string name = one->path().filename().string();
        const bool is_one = name.size() == page_begin.size() + 2 * page_bytes + page_end.size() && name.starts_with(page_begin) &&
                            name.ends_with(page_end);
        std::error_code unknown;
        const auto made = is_one ? std::filesystem::last_write_time(one->path(), unknown)
                                 : std::filesystem::file_time_type::max();
        if (is_one && !unknown && std::filesystem::file_time_type::clock::now() - made > page_serves)
            ::unlink(one->path().c_str());
    }
}

constexpr int ending_signals[] = {SIGINT, SIGTERM, SIGHUP};
const char* page_to_remove = nullptr;    // for the signal handler below, which may use only few functions

void remove_page_and_end(int signal) {
    ::unlink(page_to_remove);
    ::signal(signal, SIG_DFL);
    ::raise(signal);
}

}    // namespace

void open_in_browser(const std::string& url) {
    std::vector<std::string> words{"xdg-open", url};
    if (const passwd* const caller = caller_of_sudo()) words.insert(words.begin(), {"runuser", "-u", caller->pw_name, "--"});
    const auto status = run_program(words);
    if (!status)
        throw Failure{words[0] + " is not installed (package " + (words[0] == "runuser" ? "util-linux" : "xdg-utils") + ")"};
    if (*status != 0) throw Failure{"xdg-open found no browser"};
}

RedirectFile::RedirectFile(const std::string& url) {
    const auto secret = anogate::random_hex(page_bytes);
    const std::string folder = home();
    if (folder.empty() || !secret) throw Failure{"cannot create the sign-in page: no home folder"};
    remove_old_pages(folder);
    path_ = folder + '/' + std::string{page_begin} + *secret + std::string{page_end};
    page_to_remove = path_.c_str();
    struct sigaction removal {};
    removal.sa_handler = remove_page_and_end;
    for (std::size_t i = 0; i < before_.size(); ++i) {
        ::sigaction(ending_signals[i], nullptr, &before_[i]);
        if (before_[i].sa_handler != SIG_IGN) ::sigaction(ending_signals[i], &removal, nullptr);    // nohup ignores SIGHUP
    }
    const anogate::UniqueFd fd{::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR)};
    const std::string page = "<!doctype html><meta http-equiv=\"refresh\" content=\"0;url=" + url + "\">\n";
    const passwd* const caller = caller_of_sudo();
    const bool written = fd && anogate::write_all(fd.get(), page) &&
                         (!caller || ::fchown(fd.get(), caller->pw_uid, caller->pw_gid) == 0);
    const int error = errno;
    if (written) return;
    if (fd) ::unlink(path_.c_str());
    end_removal();
    throw Failure{anogate::error_text(path_, error)};
}

RedirectFile::~RedirectFile() {
    ::unlink(path_.c_str());
    end_removal();
}

void RedirectFile::end_removal() noexcept {
    for (std::size_t i = 0; i < before_.size(); ++i) ::sigaction(ending_signals[i], &before_[i], nullptr);
}

}    // namespace anoctl
