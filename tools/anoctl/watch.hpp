// The frames of a gateway that runs, as they pass (GET /frames).
#pragma once
#include "anoctl.hpp"
#include "frame_printer.hpp"

#include <ano/time.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace anoctl {

struct Watching {
    std::string socket;         // of the gateway
    std::string query;          // the filters: "&id=euler"
    std::uint64_t count = 0;    // ends after so many frames; 0: no end
    FrameOptions frames;
};

/// Gives them to `taker` until it is interrupted or wants no more, or `time` is over: then it returns nothing; or it returns why no more will
/// come. Throws UsageError for a filter that the gateway does not take, Failure when there is no gateway.
std::string watch_frames(const std::string& socket, const std::string& query, FrameTaker& taker,
                         std::optional<ano::Duration> time = std::nullopt);

/// Shows them until it is interrupted. Throws Failure when the gateway is not there or ends.
int watch(const Watching& watching, Streams& streams);

/// "&id=euler,0x01", each word as it may stand in a query; empty when there are no words.
std::string filter_words(const std::string& name, const std::vector<std::string>& words);

}    // namespace anoctl
