// Whether the JSON of a frame needs its bytes beside its fields.
#pragma once
#include <ano_json/frame_json.hpp>

namespace ano {

/// Whether frame_from_json() would make `frame` again of the fields of `reading` and what is behind them: found in its bytes, without
/// making that JSON where that is possible.
bool is_restored(FrameView frame, const Reading& reading, const JsonOptions& options);

}    // namespace ano
