// Receives the frames of a running gateway (GET /frames).
#pragma once
#include <anoctl/text/frame_printer.hpp>
#include "anoctl.hpp"

#include <ano/time.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace anoctl {

struct Watching {
    std::string socket;         // of the gateway
    std::string query;          // filters: "&id=euler"
    std::uint64_t count = 0;    // exit after this number of frames; 0: no limit
    FrameOptions frames;
};

/// Passes frames to `receiver`. Returns empty if interrupted, `receiver` needs no more frames, or `time` has passed; otherwise the
/// reason why no more frames will arrive. Throws UsageError for a filter that the gateway rejects, Failure if there is no
/// gateway.
std::string watch_frames(const std::string& socket, const std::string& query, FrameReceiver& receiver,
                         std::optional<ano::Duration> time = std::nullopt);

/// Prints frames until interrupted. Throws Failure if there is no gateway, or it stops.
int watch(const Watching& watching, Streams& streams);

/// "&id=euler,0x01", with each word percent-encoded; empty if there are no words.
std::string filter_words(const std::string& name, const std::vector<std::string>& words);

}    // namespace anoctl
