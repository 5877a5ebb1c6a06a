// What a restart is to read while the configuration file has not been confirmed: what ran before it.
#pragma once
#include <config/read_files.hpp>

#include <optional>
#include <string>
#include <vector>

namespace anogate {

struct KeptConfig {
    std::vector<ConfigText> unconfirmed;    // the files, as they are: once somebody changed them, they are what he wants
    std::vector<ConfigText> confirmed;      // what ran before
};

/// Where `what` is kept of the gateway that has this configuration file, in state_folder(): one of several that a user runs has its
/// own. Empty: there is no folder, or no file.
std::string kept_path(const std::string& what, const std::string& config_file);

/// Where that of `config_file` is kept: in $STATE_DIRECTORY of the unit, else in the user's folder for the state of programs. Empty:
/// there is none.
std::string kept_config_path(const std::string& config_file);

/// Whatever their names: the same file may be named in several ways.
bool have_same_texts(const std::vector<ConfigText>& one, const std::vector<ConfigText>& other);

/// These read and write a disk, and may block.

/// Empty, or why it could not be kept. It is on the disk when this returns, also after a loss of power.
std::string keep_config(const std::string& path, const KeptConfig& config);
/// Nothing: there is none, or it can't be read.
std::optional<KeptConfig> kept_config(const std::string& path);
/// Empty, or why it is still there.
std::string forget_config(const std::string& path);

}    // namespace anogate
