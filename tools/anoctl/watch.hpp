// Gets the frames of a running gateway as they pass (GET /frames).
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
    std::string query;          // the filters: "&id=euler"
    std::uint64_t count = 0;    // number of frames until it ends; 0: no end
    FrameOptions frames;
};

/// Passes frames to `taker`. Returns empty when it is interrupted, `taker` wants no more, or `time` is over; otherwise why no more will
/// come. Throws UsageError for a filter that the gateway refuses, Failure when there is no gateway.
std::string watch_frames(const std::string& socket, const std::string& query, FrameTaker& taker,
                         std::optional<ano::Duration> time = std::nullopt);

/// Shows frames until it is interrupted. Throws Failure when there is no gateway, or it ends.
int watch(const Watching& watching, Streams& streams);

/// "&id=euler,0x01", with each word percent-encoded; empty when there are no words.
std::string filter_words(const std::string& name, const std::vector<std::string>& words);

}    // namespace anoctl
