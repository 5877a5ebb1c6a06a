// The settings of a pseudo-terminal.
#pragma once
#include <string>

namespace anogate {

struct PtySettings {
    std::string path;
    bool operator==(const PtySettings&) const = default;
};

}    // namespace anogate
