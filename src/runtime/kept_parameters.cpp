#include <log/log_line.hpp>
#include <runtime/kept_config.hpp>
#include <runtime/kept_parameters.hpp>
#include <sys/files/state_folder.hpp>
#include <sys/files/write_atomically.hpp>

#include <cstdlib>

namespace anogate {
namespace {

constexpr std::size_t max_parameters = 1 << 20;    // bytes of the file

}    // namespace

std::string kept_state_path(const std::string& what, const std::string& config_file) {
    const char* const of_unit = std::getenv("STATE_DIRECTORY");
    if (of_unit && *of_unit) return state_folder() + "/" + what + ".json";
    const std::string path = kept_path(what, config_file);
    return path.empty() ? path : path + ".json";
}

std::string kept_parameters_path(const std::string& config_file) { return kept_state_path("parameters", config_file); }

WrittenValues kept_parameters(const std::string& path) {
    std::string fault;
    const auto text = read_kept_file(path, max_parameters, fault);
    if (!text && fault.empty()) return {};
    auto written = text ? WrittenValues::parse(*text) : std::nullopt;
    if (written) return *std::move(written);
    log_warning("{}; using the values of the configuration", fault.empty() ? path + ": not a list of parameters" : fault);
    return {};
}

}    // namespace anogate
