// The settings of a pseudo-terminal.
#pragma once
#include <link/v7_settings.hpp>

#include <string>

namespace anogate {

struct PtySettings {
    std::string path;
    V7LinkSettings v7{};
    bool operator==(const PtySettings&) const = default;
};

}    // namespace anogate
