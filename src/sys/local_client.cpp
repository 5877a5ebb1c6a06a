#include <sys/files/read_file.hpp>
#include <sys/local_client.hpp>

#include <pwd.h>

#include <array>
#include <cctype>
#include <system_error>

namespace anogate {
namespace {

std::string user_name(uid_t user) {
    std::array<char, 4096> text;
    passwd entry{};
    passwd* found = nullptr;
    const bool is_read = ::getpwuid_r(user, &entry, text.data(), text.size(), &found) == 0 && found != nullptr;
    return is_read ? entry.pw_name : "user " + std::to_string(user);
}

// A program chooses the name of its process, which must not look like another text.
std::string process_name(pid_t process) {
    constexpr std::size_t max_bytes = 64;
    constexpr char not_readable[] = "a program";
    std::error_code error;
    std::string name = read_file("/proc/" + std::to_string(process) + "/comm", max_bytes, error);
    if (error) return not_readable;
    if (name.ends_with('\n')) name.pop_back();
    for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '.') c = '_';
    return name.empty() ? not_readable : name;
}

}    // namespace

std::string local_client(uid_t user, pid_t process) {
    const std::string number = process > 0 ? ", process " + std::to_string(process) : "";
    return process_name(process) + " of " + user_name(user) + number;
}

}    // namespace anogate
