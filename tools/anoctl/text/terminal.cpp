#include "terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <string_view>

namespace anoctl {
namespace {

bool write_all(std::string_view text) noexcept {
    while (!text.empty()) {
        const ssize_t n = ::write(STDOUT_FILENO, text.data(), text.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        text.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
}

}    // namespace

bool is_screen() noexcept {
    const char* const term = std::getenv("TERM");
    return ::isatty(STDIN_FILENO) == 1 && ::isatty(STDOUT_FILENO) == 1 && term != nullptr && std::string_view{term} != "dumb";
}

void Screen::enter() noexcept {
    if (entered_ || ::tcgetattr(STDIN_FILENO, &before_) != 0) return;
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);    // Ctrl-C and Ctrl-Z still work
    raw.c_cc[VMIN] = 1;
    raw.c_cc[VTIME] = 0;
    ::tcsetattr(STDIN_FILENO, TCSADRAIN, &raw);
    entered_ = true;
    write_all("\x1b[?1049h\x1b[?25l");    // alternate screen, no cursor
}

void Screen::leave() noexcept {
    if (!entered_) return;
    entered_ = false;
    write_all("\x1b[?25h\x1b[?1049l");
    ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
}

Screen::Size Screen::size() noexcept {
    winsize size{};
    for (const int fd : {STDOUT_FILENO, STDERR_FILENO, STDIN_FILENO})    // some of them may be files
        if (::ioctl(fd, TIOCGWINSZ, &size) == 0 && size.ws_col != 0)
            return {size.ws_col, size.ws_row != 0 ? size.ws_row : Size{}.height};
    return {};
}

bool Screen::show(const std::vector<std::string>& lines) {
    std::string text = "\x1b[H";
    for (std::size_t i = 0; i < lines.size(); ++i)
        text.append(lines[i]).append("\x1b[K").append(i + 1 < lines.size() ? "\r\n" : "");
    return write_all(text.append("\x1b[J"));
}

}    // namespace anoctl
