// A calibration as somebody sees it who turns the device.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// Which face is up as a drawing, how still it lies, which faces are done; or the map of the directions from which there is something.
/// Empty while there is neither.
std::vector<std::string> calibration_lines(const ano::Json& job);
/// In lines that a terminal of so many columns has room for, broken between words.
std::vector<std::string> broken_lines(const std::vector<std::string>& lines, std::size_t width);
/// The same in a line for a file or a pipe, which changes with each face and each tenth of the sphere.
std::string calibration_step(const ano::Json& job);
/// "residual 25.3 cm/s² before, 1.2 cm/s² now", the values found, and that they stay.
std::vector<std::string> calibration_result(const ano::Json& result, const std::string& what);

}    // namespace anoctl
