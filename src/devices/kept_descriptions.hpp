// Descriptions of parameters that an earlier run has read and stored, so that they need not be read again. No I/O.
#pragma once
#include <devices/works/work.hpp>
#include <host/parameter_info.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

/// "descriptions-0xDC-1a2b3c4d.json" (unit_note_name()).
std::string descriptions_name(const WorkPlace& place);
/// `all`, with the unit that they belong to. The device info must be known.
std::string descriptions_text(const WorkPlace& place, const std::vector<ano::host::ParameterInfo>& all);
/// std::nullopt: damaged, of another unit, or not `count` descriptions.
std::optional<std::vector<ano::host::ParameterInfo>> descriptions_in(const std::string& text, const WorkPlace& place,
                                                                     std::uint16_t count);

}    // namespace anogate
