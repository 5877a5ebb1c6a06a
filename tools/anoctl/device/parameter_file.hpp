// The file of `anoctl param export`, and what is to be written of it.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// {"device": "0xDC", "name", "dev_id", "hw", "sw", "parameters": {NAME: value}} of what GET /devices/A/parameters answers; null stands for
/// inf and nan, which JSON does not have. Throws Failure, which names them, when parameters did not come, or two have one name: a backup
/// with holes is none.
ano::Json parameter_file(const ano::Json& answer);

/// Of the text of such a file, of one that a calibration kept ("device" is an object there), or of a plain {NAME: value}. Throws UsageError
/// for one that is none of these.
ano::Json parsed_parameter_file(const std::string& text, const std::string& path);

/// Why the file is of another device than `device` ({"name", "dev_id"…}), as a clause; empty: it is of this one, or does not say.
std::string of_another_device(const ano::Json& file, const ano::Json& device);

/// CAL_…: what a calibration found for one piece of hardware.
bool is_calibration(std::string_view name) noexcept;

/// What of `file` is to be written: no null, and what belongs to a calibration only `with_calibration`; `left_out` counts those of a
/// calibration that are not.
ano::Json wanted_values(const ano::Json& file, bool with_calibration, std::size_t& left_out);
/// "A, B": those without a number.
std::string names_without_value(const ano::Json& file);

/// Whether `path` is named as what a calibration keeps: calibration-0xDC-compass.json.
bool is_kept_by_calibration(const std::string& path);

/// What is wrong with a row that "failed" before anything was written, with its name.
std::string misfit_line(const ano::Json& row);
/// A line for each row of an answer of /devices/A/apply that is not "unchanged".
std::vector<std::string> difference_lines(const ano::Json& answer);
/// How many rows have this state.
std::size_t rows_with(const ano::Json& answer, std::string_view state);

/// A value for people: 1.5, "text".
std::string value_text(const ano::Json& value);
/// The value of `key` as it is typed: 1.5, text; empty: it is not there.
std::string plain_at(const ano::Json& object, const char* key);

}    // namespace anoctl
