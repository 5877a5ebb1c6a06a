#include <config/read_file.hpp>
#include <daemon/kept_config.hpp>
#include <daemon/kept_parameters.hpp>
#include <daemon/state_folder.hpp>

#include <spdlog/spdlog.h>

#include <cstdlib>
#include <system_error>

namespace anogate {
namespace {

constexpr std::size_t max_parameters = 1 << 20;    // bytes of the file

}    // namespace

std::string kept_parameters_path(const std::string& config_file) {
    const char* const of_unit = std::getenv("STATE_DIRECTORY");
    if (of_unit && *of_unit) return state_folder() + "/parameters.json";
    const std::string path = kept_path("parameters", config_file);
    return path.empty() ? path : path + ".json";
}

WrittenValues kept_parameters(const std::string& path) {
    if (path.empty()) return {};
    std::error_code error;
    const std::string text = read_file(path, max_parameters, error);
    if (error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory) return {};
    auto written = WrittenValues::parse(text);
    if (!error && written) return *std::move(written);
    spdlog::warn("{}: {}; the configuration holds", path, error ? error.message() : "it is no list of parameters");
    return {};
}

}    // namespace anogate
