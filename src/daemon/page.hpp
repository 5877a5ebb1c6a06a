// The page for browsers: files that its build made, and how they are answered.
#pragma once
#include <http/request.hpp>
#include <http/response.hpp>

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace anogate {

/// All of it is held in memory, compressed as it stands on the disk: some 60 KB, read before the loop runs. Names of files tell
/// their content but for index.html, so that a browser may keep them for ever.
class Page {
public:
    /// What is NAME.gz in the folder is the file NAME. Empty where there is no such folder, or no index.html.gz in it, or more than
    /// a page has.
    static Page read(const std::filesystem::path& folder);

    bool empty() const noexcept { return files_.empty(); }
    /// Whether the request is that of a browser for a page to look at, and there is one.
    bool is_wanted_by(const http::Request& request) const;
    /// The file as the answer to the request; 404, or 406 for who does not take gzip.
    http::Response file(std::string_view name, const http::Request& request) const;

private:
    std::map<std::string, std::string, std::less<>> files_;    // name without .gz, compressed content
};

/// Where the page of `program` is: PREFIX/share/anogate/web of PREFIX/bin/NAME; BUILD/web of what was built as BUILD/src/NAME.
std::filesystem::path page_folder_of(const std::filesystem::path& program);

/// That of the program that runs.
Page installed_page();

}    // namespace anogate
