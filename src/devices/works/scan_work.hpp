// Asks all devices whether they are present.
#pragma once
#include <devices/works/work.hpp>

#include <memory>

namespace anogate {

/// Sends 0xE0 0 to address 0xFF three times. The answers are collected by the service, whose list is the result.
std::unique_ptr<Work> scan(const WorkPlace& place);

}    // namespace anogate
