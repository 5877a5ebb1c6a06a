#include <ano_json/json_pointer.hpp>

namespace ano {

// The time of the function in nlohmann-json grows with the square of the length.
std::string pointer_step(std::string_view key) {
    std::string step = "/";
    for (const char c : key) {
        if (c == '~') step += "~0";
        else if (c == '/') step += "~1";
        else step += c;
    }
    return step;
}

}    // namespace ano
