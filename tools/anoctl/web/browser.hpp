// Opens the browser of the user at this computer.
#pragma once
#include <array>
#include <csignal>
#include <string>

namespace anoctl {

/// Opens the URL with xdg-open, as the user who called sudo if there is one. Throws Failure with the reason.
void open_in_browser(const std::string& url);

/// A page in the home folder of that user that redirects the browser to a URL. It is readable only for that user, while the
/// command line of a browser is readable for every user of the computer. It is not a hidden file, because a browser from a snap
/// package can't read hidden files.
/// The destructor removes the page, and so does a signal that ends the program. The constructor removes pages of earlier programs
/// that were killed. Only one object may exist at a time.
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
