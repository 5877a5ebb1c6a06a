// Keeps the last confirmed configuration, for a restart while the new configuration file has not been confirmed.
#pragma once
#include <config/read_files.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

struct KeptConfig {
    std::vector<ConfigText> unconfirmed;    // the files of the new one; used again once they are changed
    std::vector<ConfigText> confirmed;      // the previous configuration
};

/// The path in state_folder() for `what` of the gateway with this configuration file: each gateway of a user has its own. Empty:
/// no folder, or no configuration file.
std::string kept_path(const std::string& what, const std::string& config_file);

/// The path for the kept configuration of `config_file`: in $STATE_DIRECTORY of the unit, else in the user's folder for the state
/// of programs. Empty: none.
std::string kept_config_path(const std::string& config_file);

/// Ignores the names, because one file may have several.
bool have_same_texts(const std::vector<ConfigText>& one, const std::vector<ConfigText>& other);

/// Parses the bytes of a file of keep_config(). std::nullopt: they are damaged. The use of the stack is bounded for any input.
std::optional<KeptConfig> parse_kept_config(std::string_view bytes);

// These functions access the disk and may block.

/// Returns empty, or the reason for the failure. After a success the file is synced to the disk and survives a loss of power.
std::string keep_config(const std::string& path, const KeptConfig& config);
/// std::nullopt: the file does not exist or is not readable; then `fault` is the reason.
std::optional<KeptConfig> kept_config(const std::string& path, std::string& fault);
/// Removes the file. Returns empty, or the reason for the failure.
std::string forget_config(const std::string& path);

}    // namespace anogate
