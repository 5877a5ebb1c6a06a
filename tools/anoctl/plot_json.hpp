// What a frame says, as the plotter PlotJuggler takes it over UDP: JSON objects, each in a datagram of its own.
//
//   {"timestamp": 1763898044.123456, "fc": {"0xDC": {"euler": {"rol": 1.23, "pit": -0.5}}}}
#pragma once
#include <ano/frame.hpp>
#include <ano_json/frame_json.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// Bytes of a datagram that no network has to cut in pieces.
inline constexpr std::size_t usual_datagram = 1400;

/// Numbers alone: what is text or "no data" can't be plotted. None: nothing of the frame can be. `link` is where it came by. What does
/// not fit into one object of `max_bytes` is told by several of the same time, each with some of the fields. A field stays whole,
/// also one that is longer by itself: the elements of a list are told apart by their places.
std::vector<std::string> plot_json(ano::FrameView frame, const std::string& link, double time, const ano::JsonOptions& options,
                                   std::size_t max_bytes = usual_datagram);

}    // namespace anoctl
