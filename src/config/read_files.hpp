// The files of a configuration: the given file, and those in conf.d beside it.
#pragma once
#include <config/config.hpp>

#include <string>
#include <vector>

namespace anogate {

/// The name and the content of a file.
struct ConfigText {
    std::string file, text;
    bool operator==(const ConfigText&) const = default;
};

/// `file`, then conf.d/*.json in its folder, sorted by name. A file that can't be read is an error. May block on the disk.
std::vector<ConfigText> read_config_files(const std::string& file, ConfigErrors& errors);

/// `file` alone, if it can be read.
std::vector<ConfigText> read_config_file(const std::string& file, ConfigErrors& errors);

/// Adds all of them to the draft.
void read_config(const std::vector<ConfigText>& files, Draft& draft);

}    // namespace anogate
