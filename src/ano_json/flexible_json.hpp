// Layouts of flexible messages from a configuration:
//
//   "flexible": [{"id": "0xF1", "source": 30, "endian": "big", "when": 3,
//                 "fields": [{"name": "kind", "type": "u8"}, {"name": "a", "type": "i16", "count": 4, "scale": 0.01, "unit": "V"}]}]
#pragma once
#include <ano/flexible.hpp>
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace ano {

/// Adds the layouts of `array`, which is at `pointer`, to `layouts`. Keys: `id` (0xF1 to 0xFA, or the name), `source` (only
/// frames of this source; omitted: of any source), `when` (only frames whose first field has this value), `endian` (little, the
/// default, or big), `fields` with `name`, `type`, and optionally `count` (an array), `scale` (value = number on the wire ×
/// scale, default 1) and `unit`. Returns all faults; a layout with a fault is not added.
std::vector<JsonFault> add_flexible(const nlohmann::json& array, const std::string& pointer, FlexibleLayouts& layouts);

/// Appends the same layouts, without conversion, to `specs`.
std::vector<JsonFault> read_flexible(const nlohmann::json& array, const std::string& pointer, std::vector<FlexibleSpec>& specs);

/// Converts them back to the array.
Json flexible_to_json(const std::vector<FlexibleSpec>& specs);

}    // namespace ano
