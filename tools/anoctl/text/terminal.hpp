// Uses a terminal as a full screen, and restores it afterwards.
#pragma once
#include <termios.h>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// Whether standard input and output are a terminal that can move its cursor.
bool is_screen() noexcept;

/// While this object exists, keys are read without Enter and not echoed, and the alternate screen is shown.
class Screen {
public:
    Screen() noexcept { enter(); }
    ~Screen() { leave(); }
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    /// Restores the terminal, then uses it again: for a program stopped by Ctrl-Z.
    void leave() noexcept;
    void enter() noexcept;

    struct Size {
        std::size_t width = 80, height = 24;
    };
    static Size size() noexcept;
    /// False: the terminal was closed.
    static bool show(const std::vector<std::string>& lines);

private:
    termios before_{};
    bool entered_ = false;
};

}    // namespace anoctl
