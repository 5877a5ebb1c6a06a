// Records of frames as lines of JSON, for watchers.
#pragma once
#include <ano/flexible.hpp>
#include <daemon/watch_queue.hpp>
#include <gateway/frame_record.hpp>

#include <string>

namespace anogate {

/// {"from": 220, ..., "time": 1700000000.123456, "link": "fc", "peer": "/dev/ttyUSB0", "direction": "in"}; a dropped frame also has
/// `cause`. Without a line end.
std::string record_json(const FrameRecord& record, const WatchTables& tables, const ano::FlexibleLayouts& flexible);

/// {"lost": {"euler": 120, "inertial": 120}, "since_ms": 500}
std::string lost_json(const LostFrames& lost);

/// {"links": [...], "channels": [...], "causes": [...]}: null for an unused number.
std::string tables_json(const WatchTables& tables);

}    // namespace anogate
