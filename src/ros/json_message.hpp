// A message of the table as JSON: the `fields` of its frame (ano_json/frame_json.hpp). A field with "no data" has no key, because
// programs that read these schemas do not support null.
#pragma once
#include <ano/flexible.hpp>
#include <ano/reading.hpp>
#include <ano/schema.hpp>
#include <ano_json/frame_json.hpp>

#include <span>
#include <string>

namespace anogate {

/// The JSON Schema for all layouts of one message.
std::string json_schema_of(std::span<const ano::Message> layouts);
std::string json_schema_of(const ano::FlexibleLayout& layout);

/// Appends the message; `reading` must have fields.
void write_json_message(const ano::Reading& reading, const ano::JsonOptions& options, std::string& out);

}    // namespace anogate
