// Records of frames as lines of JSON, for watchers.
#pragma once
#include <ano/flexible.hpp>
#include <ano_json/text.hpp>
#include <gateway/frame_record.hpp>
#include <watch/watch_queue.hpp>

#include <string>

namespace anogate {

/// {"from": 220, ..., "time": 1700000000.123456, "link": "fc", "peer": "/dev/ttyUSB0", "direction": "in"}; a dropped frame also
/// has `cause`, and a frame received on a link that is not the home of its source `"elsewhere": true`; the bytes
/// on the wire are `raw`, in hex. Without a line end.
/// `encoding`: of its texts.
std::string record_json(const FrameRecord& record, const WatchTables& tables, const ano::FlexibleLayouts& flexible,
                        ano::Encoding encoding = ano::Encoding::automatic);

/// {"lost": {"euler": 120, "inertial": 120}, "since_ms": 500}
std::string lost_json(const LostFrames& lost);

/// {"links": [...], "channels": [...], "causes": [...]}: null for an unused number.
std::string tables_json(const WatchTables& tables);

}    // namespace anogate
