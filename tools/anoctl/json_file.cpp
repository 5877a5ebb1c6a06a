#include "json_file.hpp"

#include <ano_json/strict_json.hpp>
#include <sys/files/read_file.hpp>

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>
#include <vector>

namespace anoctl {
namespace {

std::string read_all(int fd, std::error_code& error) {
    std::string text;
    std::array<char, 4096> room;
    while (text.size() <= anogate::max_config_size) {
        const ssize_t n = ::read(fd, room.data(), room.size());
        if (n == 0) return text;
        if (n > 0) text.append(room.data(), static_cast<std::size_t>(n));
        else if (errno != EINTR) break;
    }
    error = text.size() > anogate::max_config_size ? std::make_error_code(std::errc::file_too_large)
                                                   : std::error_code{errno, std::generic_category()};
    return {};
}

template <class Document>
Document strictly(std::string_view text, const std::string& where, bool with_comments) {
    std::vector<ano::JsonFault> faults;
    auto document = ano::strict_json<Document>(text, with_comments, faults);
    if (document && faults.empty()) return *std::move(document);
    const ano::JsonFault& first = faults.front();
    throw UsageError{where + ": " + (first.pointer.empty() ? "not valid JSON: " : first.pointer + ": ") + first.what};
}

}    // namespace

nlohmann::json json_in_file(const std::string& path, Streams& streams) {
    std::error_code error;
    const std::string text = path == "-" ? read_all(streams.in, error)
                                         : anogate::read_file(path, anogate::max_config_size, error);
    if (error) throw UsageError{path + ": cannot read: " + error.message()};
    return json_with_comments(text, path);
}

nlohmann::json json_with_comments(std::string_view text, const std::string& where) {
    return strictly<nlohmann::json>(text, where, true);
}

nlohmann::ordered_json json_in_text(std::string_view text, const std::string& where) {
    return strictly<nlohmann::ordered_json>(text, where, false);
}

}    // namespace anoctl
