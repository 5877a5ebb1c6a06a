// Whole frames as messages of a channel of their own, the same as in a recording that is MCAP. No I/O.
#pragma once
#include <record/decoded_channels.hpp>

#include <string>
#include <string_view>

namespace anogate {

inline constexpr std::string_view raw_frame_topic = "/anogate/frames";

const DecodedSchema& raw_frame_schema();
/// A message of that schema, as CDR.
std::string raw_frame(const RecordedFrame& frame);

}    // namespace anogate
