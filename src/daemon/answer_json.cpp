#include <daemon/answer_json.hpp>

#include <nlohmann/json.hpp>

#include <chrono>

namespace anogate {

double in_seconds(ano::Duration d) {
    return static_cast<double>(std::chrono::duration_cast<std::chrono::milliseconds>(d).count()) / 1000;
}

std::string line_of(const nlohmann::ordered_json& json) {
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}    // namespace anogate
