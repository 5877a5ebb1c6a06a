// The browser of the person at this computer.
#pragma once
#include <array>
#include <csignal>
#include <string>

namespace anoctl {

/// Opens the URL by xdg-open, as the user who called sudo if somebody did. Throws Failure, which names `url`.
void open_in_browser(const std::string& url);

/// A page in the home of that user which leads the browser to a URL, and which others can't read: the command line of a browser is readable for
/// every user of the computer. It is not hidden, since a browser from a snap package can't read hidden files. Removed at the end, also when a signal ends the
/// program; those of earlier programs that were killed are removed at the start. There is one at a time.
class RedirectFile {
public:
    explicit RedirectFile(const std::string& url);
    RedirectFile(const RedirectFile&) = delete;
    RedirectFile& operator=(const RedirectFile&) = delete;
    ~RedirectFile();

    std::string url() const { return "file://" + path_; }

private:
    void end_removal() noexcept;

    std::string path_;
    std::array<struct sigaction, 3> before_{};
};

}    // namespace anoctl
