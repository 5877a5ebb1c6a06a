// A terminal that is used as a screen, and given back as it was.
#pragma once
#include <termios.h>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// Standard input and output are one, and it can move its cursor.
bool is_screen() noexcept;

/// While it lives, keys come without Enter and are not shown, and lines stand at their places.
class Screen {
public:
    Screen() noexcept { enter(); }
    ~Screen() { leave(); }
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    /// As it was before, and back: for a program that is stopped meanwhile.
    void leave() noexcept;
    void enter() noexcept;

    struct Size {
        std::size_t width = 80, height = 24;
    };
    static Size size() noexcept;
    /// False: it is gone.
    static bool show(const std::vector<std::string>& lines);

private:
    termios before_{};
    bool entered_ = false;
};

}    // namespace anoctl
