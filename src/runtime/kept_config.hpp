// Keeps the last confirmed configuration, for a restart while the new configuration file has not been confirmed.
#pragma once
#include <config/read_files.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

struct KeptConfig {
    std::vector<ConfigText> unconfirmed;    // the files of the new one: when they were changed since, they count as wanted
    std::vector<ConfigText> confirmed;      // the configuration that ran before
};

/// The path in state_folder() for `what` of the gateway with this configuration file: each gateway of a user has its own.
/// Empty: there is no folder, or no configuration file.
std::string kept_path(const std::string& what, const std::string& config_file);

/// The path for the kept configuration of `config_file`: in $STATE_DIRECTORY of the unit, else in the user's folder for the state of
/// programs. Empty: there is none.
std::string kept_config_path(const std::string& config_file);

/// Compares without the names: the same file may be named in several ways.
bool have_same_texts(const std::vector<ConfigText>& one, const std::vector<ConfigText>& other);

/// The bytes of a file of keep_config(). std::nullopt: they are damaged. Whatever the bytes are, this needs little of the stack.
std::optional<KeptConfig> parse_kept_config(std::string_view bytes);

// These read and write a disk, and may block.

/// Returns empty, or why it could not be kept. When it returns, the file is synced to the disk and survives a loss of power.
std::string keep_config(const std::string& path, const KeptConfig& config);
/// std::nullopt: there is none, or, with a `fault` in words, it can't be read.
std::optional<KeptConfig> kept_config(const std::string& path, std::string& fault);
/// Returns empty, or why it is still there.
std::string forget_config(const std::string& path);

}    // namespace anogate
