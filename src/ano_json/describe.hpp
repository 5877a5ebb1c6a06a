// The message table as JSON, for programs that read and write frames with it.
#pragma once
#include <ano/flexible.hpp>
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <vector>

namespace ano {

/// One row of the table: `id`, `name`, `title`, `layout` (its label), `fields` and more.
Json describe(const Message& row);

/// All rows. For flexible messages one row per layout in `flexible`, with `source` if it is for frames of only one source.
std::vector<Json> describe_all(const FlexibleLayouts& flexible);

}    // namespace ano
