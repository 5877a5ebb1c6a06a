#include <ano_json/answer_json.hpp>
#include <ano_json/json_line.hpp>

#include <nlohmann/json.hpp>

#include <chrono>
#include <utility>

namespace anogate {

double in_seconds(ano::Duration d) {
    return static_cast<double>(std::chrono::duration_cast<std::chrono::milliseconds>(d).count()) / 1000;
}

std::string line_of(nlohmann::ordered_json json) { return ano::json_line(std::move(json)); }

}    // namespace anogate
