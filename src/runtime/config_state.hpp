// Whether the running configuration is that of the configuration file.
#pragma once
#include <ano/time.hpp>

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace anogate {

struct ConfigState {
    enum class Runs {
        file,            // the last configuration read
        unconfirmed,     // the same, but restored to the previous one unless confirmed in time
        not_the_file,    // the previous one: that of the file was not confirmed
    };
    std::string file;    // empty: the configuration is from the command line
    Runs runs = Runs::file;
    std::optional<ano::TimePoint> confirm_by{};
    std::vector<std::string> needs_restart{};    // settings of the file that take effect at the next start
};

/// {"file", "state": "file|unconfirmed|not the file|command line", …}
nlohmann::ordered_json config_json(const ConfigState& state, ano::TimePoint now);

}    // namespace anogate
