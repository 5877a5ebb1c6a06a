// Texts and drawings for the user who turns the device during a calibration.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

/// A drawing of the face that is up, whether the device is still, and which faces are done; or a map of the directions that have
/// measurements. Empty if `job` contains neither.
std::vector<std::string> calibration_lines(const ano::Json& job);
/// Breaks lines between words, to at most `width` columns.
std::vector<std::string> broken_lines(const std::vector<std::string>& lines, std::size_t width);
/// The state of the job as one line for a file or a pipe. It changes with each face, or with each tenth of the sphere.
std::string calibration_step(const ano::Json& job);
/// "residual 25.3 cm/s² before, 1.2 cm/s² now", the values found, and that they are saved.
std::vector<std::string> calibration_result(const ano::Json& result, const std::string& what);

}    // namespace anoctl
