#include <ano_json/nearest.hpp>
#include <config/config_error.hpp>
#include <config/key_facts.hpp>

#include <algorithm>

namespace anogate {

bool KeyFacts::is_of(std::string_view kind) const {
    if (kinds.empty() || kind.empty()) return true;
    const auto all = split(kinds, ' ');
    return std::find(all.begin(), all.end(), kind) != all.end();
}

std::string must_be(const KeyFacts& key, const std::string& given) {
    return in_quotes(key.name) + " must be " + expected(key) + ", not " + given;
}

std::string unknown_key(std::string_view name, const std::vector<std::string_view>& keys, std::string_view kind,
                        const std::vector<std::string_view>& owners) {
    std::string listed;
    for (const std::string_view owner : owners) listed.append(listed.empty() ? "" : ", ").append(owner);
    if (!listed.empty()) return in_quotes(name) + " is not a key of " + std::string{kind} + ", but of " + listed;
    return "unknown key " + in_quotes(name) + ano::did_you_mean(name, keys);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t end = 0; end != std::string_view::npos;) {
        end = text.find(separator);
        parts.push_back(text.substr(0, end));
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    return parts;
}

}    // namespace anogate
