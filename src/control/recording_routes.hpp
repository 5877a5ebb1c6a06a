// The routes of recordings: GET POST /recordings, GET DELETE /recordings/{name}, POST /recordings/{name}/end, GET /recordings/last.
//
// GET /recordings answers
//   {"folder": "/var/lib/anogate/recordings",
//    "free_bytes": 12000000000,            null: it is not known
//    "free_needed": 505242880,             while fewer are free, nothing is written
//    "error": "",                          why the folder can't be looked at
//    "others": 0,                          files in it that the gateway did not write
//    "keep_last": null,                    or {"seconds": 60, "held_s": 59.9, "frames": 1200, "bytes": 48000, "saved": 2,
//                                          "skipped": 0, "last": "20261123-154735Z-fault.pcapng", "error": ""}
//    "running": [{"name": "flight", "by": "request", "file": "flight-2.pcapng", "files": 2, "format": "pcapng", "frames": 123,
//                 "bytes": 4567, "file_frames": 23, "file_bytes": 967, "file_seconds": 2.1, "not_written": 0,
//                 "error": "", "since": 1763898044.1, "seconds": 12.3, "ends_in_s": null}],
//    "recordings": [{"name": "flight.pcapng", "format": "pcapng", "bytes": 4567, "frames": 123, "seconds": 5.9,
//                    "begun": 1763898044.1, "time": 1763898050, "state": "ended"}]}
// Of one that runs frames, bytes and seconds are those of all its files; file_frames, file_bytes and file_seconds of the one that is
// written now, which `file` names. by: "configuration" or "request"; state: "recording", "ended" or "unfinished". Of a file, frames and
// seconds, from its first frame to its last, are null where it does not tell them; begun and time, that of its last change, are Unix
// seconds. The newest recording is the first.
//
// POST /recordings takes {"name": "flight", "format": "mcap", "message_encoding": "cdr", "direction": "in,out", "id": "euler", "from": …,
// "to": …, "link": …, "limit": {"euler": 10}, "seconds": 60}, all of them optional, and answers with the entry of "running"; with
// {"last": true, "name", "format", "message_encoding"} it saves what keep_last holds and answers {"name": "….pcapng", "bytes", "frames"}.
// message_encoding is of MCAP alone. POST /recordings/flight/end answers with the entry of "running" as it ended. GET
// /recordings/last?format=mcap&message_encoding=json is what keep_last holds, as a file.
#pragma once

namespace anogate {

namespace http {
class Routes;
}
class Recordings;

/// `recordings` outlives the routes.
void add_recording_routes(http::Routes& routes, Recordings& recordings);

}    // namespace anogate
