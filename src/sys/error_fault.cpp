#include <sys/error_fault.hpp>
#include <sys/errors.hpp>

namespace anogate {

ano::Fault error_fault(const std::string& place, int error) {
    switch (error) {
    case ENOSPC: return {"disk_full", place};
    case EROFS: return {"disk_read_only", place};
    case EIO: return {"disk_error", place};
    case ENOTDIR: return {"no_folder", place};
    case EEXIST: return {"exists_already", place};
    case EACCES: return {"no_permission_for", place};
    case ENOENT: return {"file_missing", place};
    default: return {"system_error", place, error_text(error)};
    }
}

}    // namespace anogate
