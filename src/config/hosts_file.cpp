#include <config/hosts_file.hpp>
#include <sys/files/read_file.hpp>

#include <algorithm>
#include <sstream>

namespace anogate {

std::string in_lower_case(std::string_view name) {
    std::string lower{name};
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return lower;
}

HostAddresses names_in_hosts(std::string_view text) {
    HostAddresses names;
    std::istringstream lines{std::string{text}};
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words{line.substr(0, line.find('#'))};
        std::string word;
        const auto address = words >> word ? IpAddress::parse(word) : std::nullopt;
        while (address && words >> word) names[in_lower_case(word)].push_back(*address);
    }
    return names;
}

HostAddresses read_hosts_file(const std::string& path) {
    std::error_code error;
    const std::string text = read_file(path, max_config_size, error);
    return error ? HostAddresses{} : names_in_hosts(text);
}

}    // namespace anogate
