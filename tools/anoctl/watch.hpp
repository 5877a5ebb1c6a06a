// The frames of a gateway that runs, as they pass (GET /frames).
#pragma once
#include "anoctl.hpp"
#include "frame_printer.hpp"

#include <cstdint>
#include <string>

namespace anoctl {

struct Watching {
    std::string socket;         // of the gateway
    std::string query;          // the filters: "&id=euler"
    std::uint64_t count = 0;    // ends after so many frames; 0: no end
    FrameOptions frames;
};

/// Shows them until it is interrupted. Throws Failure when the gateway is not there or ends.
int watch(const Watching& watching, Streams& streams);

/// "&id=euler,0x01", each word as it may stand in a query; empty when there are no words.
std::string filter_words(const std::string& name, const std::vector<std::string>& words);

}    // namespace anoctl
