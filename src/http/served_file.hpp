// Serves a file by HTTP, with ranges. Operations that may block on the disk are done in a thread.
#pragma once
#include <http/request.hpp>
#include <http/response.hpp>
#include <http/task_pool.hpp>
#include <sys/unique_fd.hpp>

#include <functional>
#include <string>
#include <variant>

namespace anogate {

struct ServedFile {
    /// Called in a thread. Opens the file, or returns the response to send instead.
    std::function<std::variant<UniqueFd, http::Response>()> open;
    std::string type;
    std::string save_as{};    // the file name for a download; empty: the browser displays the file
};

/// 200 with a whole regular file, 206 with the requested range, 416 if the range is outside the file. `disk` must outlive the
/// response. If the file grows meanwhile, only the part that existed at the beginning is sent.
http::Response served(TaskPool& disk, const http::Request& request, ServedFile file);

/// Opens a regular file in `folder`, no symbolic link; `writable`: also for writing. On failure the UniqueFd is empty and errno
/// is set; EINVAL: not a regular file.
UniqueFd open_regular(int folder, const std::string& name, bool writable = false);

}    // namespace anogate
