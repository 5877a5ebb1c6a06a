// What a frame says, as the plotter PlotJuggler takes it over UDP: one JSON object in a datagram.
//
//   {"timestamp": 1763898044.123456, "fc": {"0xDC": {"euler": {"rol": 1.23, "pit": -0.5}}}}
#pragma once
#include <ano/frame.hpp>
#include <ano_json/frame_json.hpp>

#include <string>

namespace anoctl {

/// Numbers alone: what is text or "no data" can't be plotted. Empty: nothing of the frame can be. `link` is where it came by.
std::string plot_json(ano::FrameView frame, const std::string& link, double time, const ano::JsonOptions& options);

}    // namespace anoctl
