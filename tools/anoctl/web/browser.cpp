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
#include <cstdlib>
#include <vector>

namespace anoctl {
namespace {

/// Who called sudo; nullptr: nobody did.
const passwd* caller_of_sudo() {
    const char* const name = ::geteuid() == 0 ? std::getenv("SUDO_USER") : nullptr;
    return name ? ::getpwnam(name) : nullptr;
}

std::string home() {
    if (const passwd* const caller = caller_of_sudo()) return caller->pw_dir;
    const char* const home = std::getenv("HOME");
    return home ? home : "";
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
    const auto secret = anogate::random_hex(8);
    const std::string folder = home();
    if (folder.empty() || !secret) throw Failure{"there is no home folder for the page that leads a browser to it"};
    path_ = folder + "/anogate-" + *secret + ".html";
    const anogate::UniqueFd fd{::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR)};
    const std::string page = "<!doctype html><meta http-equiv=\"refresh\" content=\"0;url=" + url + "\">\n";
    const passwd* const caller = caller_of_sudo();
    const bool written = fd && anogate::write_all(fd.get(), page) &&
                         (!caller || ::fchown(fd.get(), caller->pw_uid, caller->pw_gid) == 0);
    const int error = errno;
    if (written) return;
    if (fd) ::unlink(path_.c_str());
    throw Failure{anogate::error_text(path_, error)};
}

RedirectFile::~RedirectFile() { ::unlink(path_.c_str()); }

}    // namespace anoctl
