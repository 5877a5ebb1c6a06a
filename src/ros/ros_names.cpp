#include <ros/ros_names.hpp>

namespace anogate {
namespace {

constexpr std::size_t max_name = 64;

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }
char lower(char c) noexcept { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
char upper(char c) noexcept { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }
bool is_letter(char c) noexcept { return lower(c) >= 'a' && lower(c) <= 'z'; }

std::string mapped(std::string text, char (*map)(char) noexcept) {
    for (char& c : text) c = map(c);
    return text;
}

}    // namespace

std::string ros_name(std::string_view text, std::string_view instead) {
    std::string name;
    bool gap = false;
    for (const char c : text) {
        if (!is_letter(c) && !is_digit(c)) {
            gap = true;
            continue;
        }
        if (name.empty() && is_digit(c)) name = std::string{instead} + '_';
        else if (gap && !name.empty()) name += '_';
        gap = false;
        if (name.size() >= max_name) break;
        name += c;
    }
    if (name.empty()) return std::string{instead};
    if (name.back() == '_') name.pop_back();
    return name;
}

std::string lower_case_name(std::string_view text, std::string_view instead) { return mapped(ros_name(text, instead), lower); }
std::string upper_case_name(std::string_view text, std::string_view instead) { return mapped(ros_name(text, instead), upper); }

std::string camel_case(std::string_view name) {
    std::string text;
    bool begins = true;
    for (const char c : name) {
        if (c != '_') text += begins ? upper(c) : c;
        begins = c == '_';
    }
    return text;
}

std::string unique_name(const std::string& name, std::set<std::string>& taken) {
    if (taken.insert(name).second) return name;
    for (int n = 2;; ++n) {
        std::string numbered = name + '_' + std::to_string(n);
        if (taken.insert(numbered).second) return numbered;
    }
}

}    // namespace anogate
