// The values of a frame in the format that PlotJuggler receives over UDP: JSON objects, each in its own datagram.
//
//   {"timestamp": 1763898044.123456, "fc": {"0xDC": {"euler": {"rol": 1.23, "pit": -0.5}}}}
#pragma once
#include <ano/frame.hpp>
#include <ano_json/frame_json.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// Size of a datagram, in bytes, that usual networks don't fragment.
inline constexpr std::size_t usual_datagram = 1400;

/// Contains only numbers; text and "no data" can't be plotted. Empty: the frame has no numbers. `link`: the link on which it was
/// received.
/// A frame that exceeds `max_bytes` results in several objects with the same time, each with some of the fields. A field is never
/// split, even if it alone exceeds `max_bytes`, because list elements are identified by their positions.
std::vector<std::string> plot_json(ano::FrameView frame, const std::string& link, double time, const ano::JsonOptions& options,
                                   std::size_t max_bytes = usual_datagram);

}    // namespace anoctl
