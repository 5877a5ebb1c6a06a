// The web page: its files, and the responses with them.
#pragma once
#include <http/request.hpp>
#include <http/response.hpp>

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace anogate {

/// All files are held in memory, compressed as on the disk: some 60 KB, read before the loop runs. Except for index.html, a file name
/// contains a hash of the content, so that a browser may keep the file for ever.
class Page {
public:
    /// NAME.gz in the folder becomes the file NAME. Empty when the folder is missing, has no index.html.gz, or is larger than 1 MiB.
    static Page read(const std::filesystem::path& folder);

    bool empty() const noexcept { return files_.empty(); }
    /// Whether a browser asks for a page to display, and there is one.
    bool is_wanted_by(const http::Request& request) const;
    /// The file as a response; 404 when it does not exist, 406 when the client does not accept gzip.
    http::Response file(std::string_view name, const http::Request& request) const;

private:
    std::map<std::string, std::string, std::less<>> files_;    // compressed content, by the name without .gz
};

/// Where the page of `program` is: PREFIX/share/anogate/web of PREFIX/bin/NAME; BUILD/web of what was built as BUILD/src/NAME.
std::filesystem::path page_folder_of(const std::filesystem::path& program);

/// The page of the running program.
Page installed_page();

}    // namespace anogate
