// The values of a frame in the form that the plotter PlotJuggler takes over UDP: JSON objects, each in a datagram of its own.
//
//   {"timestamp": 1763898044.123456, "fc": {"0xDC": {"euler": {"rol": 1.23, "pit": -0.5}}}}
#pragma once
#include <ano/frame.hpp>
#include <ano_json/frame_json.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// Bytes of a datagram that networks need not fragment.
inline constexpr std::size_t usual_datagram = 1400;

/// Only numbers: text and "no data" can't be plotted. Empty: the frame has no numbers. `link`: where it was received. A frame that does
/// not fit into one object of `max_bytes` gives several with the same time, each with some of the fields. A field is never split, even
/// if it is longer than that by itself, since the elements of a list are identified by their positions.
std::vector<std::string> plot_json(ano::FrameView frame, const std::string& link, double time, const ano::JsonOptions& options,
                                   std::size_t max_bytes = usual_datagram);

}    // namespace anoctl
