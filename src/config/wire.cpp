#include <config/wire.hpp>

namespace anogate {

std::string wire_of(const LinkSettings& link) {
    std::string end;
    if (link.kind->path) end = link.kind->path(link).path;
    else if (link.kind->usual_name) end = link.kind->usual_name(link);
    return std::string{link.kind->name} + ":" + end;
}

}    // namespace anogate
