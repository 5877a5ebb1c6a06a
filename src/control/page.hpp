// The web page: its files, and the responses with them.
#pragma once
#include <http/request.hpp>
#include <http/response.hpp>

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace anogate {

/// All files are in memory, compressed as on the disk: about 60 KB, read before the loop runs. Except for index.html, file names
/// contain a hash of the content, so that a browser may cache the files for ever.
class Page {
public:
    /// NAME.gz in the folder becomes the file NAME. Empty if the folder is missing, has no index.html.gz, or is larger than 1
    /// MiB.
    static Page read(const std::filesystem::path& folder);

    bool empty() const noexcept { return files_.empty(); }
    /// Whether a browser requests a page to display, and there is one.
    bool is_wanted_by(const http::Request& request) const;
    /// The file as a response; 404 if it does not exist, 406 if the client does not accept gzip.
    http::Response file(std::string_view name, const http::Request& request) const;

private:
    std::map<std::string, std::string, std::less<>> files_;    // compressed content, by the name without .gz
};

/// The folder of the page of `program`: PREFIX/share/anogate/web for PREFIX/bin/NAME; BUILD/web for BUILD/src/NAME.
std::filesystem::path page_folder_of(const std::filesystem::path& program);

/// The page of the running program.
Page installed_page();

}    // namespace anogate
