// Whether what runs is what the configuration file says.
#pragma once
#include <ano/time.hpp>

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <vector>

namespace anogate {

struct ConfigState {
    enum class Runs {
        file,            // what was read last
        unconfirmed,     // the same, until the time to confirm it is over
        not_the_file,    // what the file says was not confirmed: what ran before
    };
    std::string file;    // empty: all is from the command line
    Runs runs = Runs::file;
    std::optional<ano::TimePoint> confirm_by{};
    std::vector<std::string> needs_restart{};    // what the file says and takes effect at the next start
};

/// {"file", "state": "file|unconfirmed|not the file|command line", …}
nlohmann::ordered_json config_json(const ConfigState& state, ano::TimePoint now);

}    // namespace anogate
