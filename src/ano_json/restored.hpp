// Whether the JSON of a frame needs its bytes in addition to its fields.
#pragma once
#include <ano_json/frame_json.hpp>

namespace ano {

/// Whether frame_from_json() would return the same `frame` from the fields of `reading` and the bytes after them. Determined from
/// the bytes if possible, without creating the JSON.
bool is_restored(FrameView frame, const Reading& reading, const JsonOptions& options);

}    // namespace ano
