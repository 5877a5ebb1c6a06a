// A file as an answer, with ranges. All that may wait for the disk is done beside the loop.
#pragma once
#include <daemon/disk_works.hpp>
#include <http/request.hpp>
#include <http/response.hpp>
#include <link/unique_fd.hpp>

#include <functional>
#include <string>
#include <variant>

namespace anogate {

struct ServedFile {
    /// In a thread; or what is answered instead.
    std::function<std::variant<UniqueFd, http::Response>()> open;
    std::string type;
    std::string save_as{};    // the name under which a browser keeps it; empty: it shows it
};

/// 200 with the whole of a regular file, 206 with the range that the request names, 416 where it has none of it. `disk` outlives the
/// answer. A file that grows meanwhile is sent as far as it went.
http::Response served(DiskWorks& disk, const http::Request& request, ServedFile file);

/// Opens a regular file in `folder`, no link; `writable`: to write as well. None: errno says why, EINVAL for what is no regular file.
UniqueFd open_regular(int folder, const std::string& name, bool writable = false);

}    // namespace anogate
