#include <control/page.hpp>
#include <http/listeners/accept.hpp>

#include <fstream>
#include <optional>
#include <sstream>
#include <utility>

namespace anogate {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view front_page = "index.html";
constexpr std::uintmax_t max_bytes = 1024 * 1024;    // for all files together

struct FileType {
    std::string_view ending, type;
};
constexpr FileType file_types[] = {
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".svg", "image/svg+xml"},
};

std::string_view page_type_of(std::string_view name) {
    for (const auto& [ending, type] : file_types)
        if (name.ends_with(ending)) return type;
    return {};
}

// No content from other servers, no inline code or style, no embedding in frames. Pictures may also be made in the browser.
constexpr const char* policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; base-uri 'none'; "
    "form-action 'none'; frame-ancestors 'none'";

std::optional<std::string> content_of(const fs::path& file) {
    std::ifstream in{file, std::ios::binary};
    std::ostringstream read;
    read << in.rdbuf();
    if (read.bad()) return std::nullopt;
    std::string content = std::move(read).str();
    return content.empty() ? std::nullopt : std::optional{std::move(content)};
}

}    // namespace

Page Page::read(const fs::path& folder) {
    Page page;
    std::uintmax_t total = 0;
    std::error_code ec;
    for (fs::directory_iterator it{folder, ec}, end; !ec && it != end; it.increment(ec)) {
        const fs::path& path = it->path();
        std::error_code no_size;
        const std::uintmax_t size = it->is_regular_file(no_size) ? it->file_size(no_size) : 0;
        if (path.extension() != ".gz" || no_size || size == 0 || page_type_of(path.stem().string()).empty()) continue;
        total += size;
        if (total > max_bytes) return {};
        if (auto content = content_of(path)) page.files_.emplace(path.stem().string(), std::move(*content));
    }
    if (page.files_.find(front_page) == page.files_.end()) return {};
    return page;
}

bool Page::is_wanted_by(const http::Request& request) const {
    return !empty() && http::quality(request.header("Accept"), "text/html").value_or(0) > 0;
}

http::Response Page::file(std::string_view name, const http::Request& request) const {
    const auto found = files_.find(name.empty() ? front_page : name);
    if (found == files_.end()) return http::error(404, "the page has no such file; reload the page");
    const std::string_view encodings = request.header("Accept-Encoding");
    if (http::quality(encodings, "gzip").value_or(http::quality(encodings, "*").value_or(0)) == 0)
        return http::error(406, "the files of the page are compressed: send Accept-Encoding: gzip");
    http::Response response;
    response.type = page_type_of(found->first);
    response.body = found->second;
    response.headers = {{"Content-Encoding", "gzip"},
                        {"Cache-Control", found->first == front_page ? "no-cache" : "public, max-age=31536000, immutable"},
                        {"Content-Security-Policy", policy},
                        {"X-Content-Type-Options", "nosniff"},
                        {"Referrer-Policy", "no-referrer"}};
    return response;
}

fs::path page_folder_of(const fs::path& program) {
    const fs::path folder = program.parent_path();
    const bool installed = folder.filename() == "bin" || folder.filename() == "sbin";
    return folder.parent_path() / (installed ? "share/anogate/web" : "web");
}

Page installed_page() {
    std::error_code ec;
    return Page::read(page_folder_of(fs::read_symlink("/proc/self/exe", ec)));
}

}    // namespace anogate
