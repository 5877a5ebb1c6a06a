// The routes of recordings: GET POST /recordings, GET DELETE /recordings/{name}, POST /recordings/{name}/end, GET /recordings/last.
//
// GET /recordings answers
//   {"folder": "/var/lib/anogate/recordings",
//    "free_bytes": 12000000000,            null: unknown
//    "free_needed": 505242880,             while fewer are free, nothing is written
//    "error": "",                          why the folder can't be read
//    "others": 0,                          files in it that the gateway did not write
//    "keep_last": null,                    or {"seconds": 60, "held_s": 59.9, "frames": 1200, "bytes": 48000, "saved": 2,
//                                          "skipped": 0, "last": "20261123-154735Z-fault.pcapng", "error": ""}
//    "running": [{"name": "flight", "by": "request", "file": "flight-2.pcapng", "files": 2, "format": "pcapng", "frames": 123,
//                 "bytes": 4567, "file_frames": 23, "file_bytes": 967, "file_seconds": 2.1, "not_written": 0,
//                 "error": "", "since": 1763898044.1, "seconds": 12.3, "ends_in_s": null}],
//    "recordings": [{"name": "flight.pcapng", "format": "pcapng", "bytes": 4567, "frames": 123, "seconds": 5.9,
//                    "begun": 1763898044.1, "time": 1763898050, "state": "ended"}]}
// In "running", frames, bytes and seconds are totals of all files of the recording; file_frames, file_bytes and file_seconds are
// those of the current file, `file`. by: "configuration" or "request"; state: "recording", "ended" or "unfinished". In
// "recordings", frames and seconds (from the first frame to the last) are null if the file does not contain them; begun and time
// (of the last change) are Unix seconds. The newest recording is first.
//
// POST /recordings takes {"name": "flight", "format": "mcap", "message_encoding": "cdr", "direction": "in,out", "id": "euler",
// "from": …, "to": …, "link": …, "limit": {"euler": 10}, "seconds": 60}, all of them optional, and returns the entry of
// "running"; with {"last": true, "name", "format", "message_encoding"} it saves the content of keep_last and returns {"name":
// "….pcapng", "bytes", "frames"}. message_encoding is only for MCAP. POST /recordings/flight/end returns the last entry of
// "running". GET /recordings/last?format=mcap&message_encoding=json returns the content of keep_last as a file.
#pragma once

namespace anogate {

namespace http {
class Routes;
}
class Recordings;

/// `recordings` must outlive the routes.
void add_recording_routes(http::Routes& routes, Recordings& recordings);

}    // namespace anogate
