// Work that asks everybody who is there.
#pragma once
#include <devices/work.hpp>

#include <memory>

namespace anogate {

/// 0xE0 0 to 0xFF, three times; what came is known to the service, and its list is the answer.
std::unique_ptr<Work> scan(const WorkPlace& place);

}    // namespace anogate
