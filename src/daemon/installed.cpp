#include <daemon/installed.hpp>

namespace anogate {
namespace fs = std::filesystem;

std::string config_file_of(const fs::path& program) {
    constexpr char below[] = "etc/anogate/anogate.json";
    const fs::path folder = program.parent_path();
    const fs::path prefix = folder.parent_path();
    std::error_code ec;
    const bool own = (folder.filename() == "bin" || folder.filename() == "sbin") && prefix != "/" && prefix != "/usr" &&
                     prefix != "/usr/local" && fs::is_directory((prefix / below).parent_path(), ec);
    return ((own ? prefix : fs::path{"/"}) / below).string();
}

std::string default_config_file() {
    std::error_code ec;
    return config_file_of(fs::read_symlink("/proc/self/exe", ec));
}

}    // namespace anogate
