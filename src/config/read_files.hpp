// The files of a configuration: the one that is named, and those in conf.d beside it.
#pragma once
#include <config/config.hpp>

#include <string>
#include <vector>

namespace anogate {

/// A file as it was read.
struct ConfigText {
    std::string file, text;
    bool operator==(const ConfigText&) const = default;
};

/// `file`, then conf.d/*.json in its folder, by name. What can't be read is an error that names it. May block, as any disk.
std::vector<ConfigText> read_config_files(const std::string& file, ConfigErrors& errors);

/// Adds all of them to the draft.
void read_config(const std::vector<ConfigText>& files, Draft& draft);

}    // namespace anogate
