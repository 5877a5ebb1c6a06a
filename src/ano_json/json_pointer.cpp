#include <ano_json/json_pointer.hpp>

#include <nlohmann/json.hpp>

namespace ano {

std::string pointer_step(std::string_view key) { return (nlohmann::json::json_pointer{} / std::string{key}).to_string(); }

}    // namespace ano
