// The file of `anoctl param export`, and the values of it that are to be written.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// Makes {"device": "0xDC", "name", "dev_id", "hw", "sw", "parameters": {NAME: value}} from the response of GET /devices/A/parameters; null
/// stands for inf and nan, which JSON does not have. A name that is empty or not the only one has its number behind it: "NAME#3".
/// What is not readable is left out.
/// Throws Failure with the names of parameters that were not received: an incomplete backup would be useless.
ano::Json parameter_file(const ano::Json& answer);

/// Parses such a file, one that a calibration kept ("device" is an object there), or a plain {NAME: value}. Throws UsageError for anything
/// else.
ano::Json parsed_parameter_file(const std::string& text, const std::string& path);

/// A clause: why the file is for another device than `device` ({"name", "dev_id"…}); empty: it is of this one, or its device is not known.
std::string of_another_device(const ano::Json& file, const ano::Json& device);

/// CAL_…: what a calibration found for one piece of hardware.
bool is_calibration(std::string_view name) noexcept;

/// The values of `file` to be written: without null, and calibration values only `with_calibration`; `left_out`: the number of calibration
/// values that are omitted.
ano::Json wanted_values(const ano::Json& file, bool with_calibration, std::size_t& left_out);
/// "A, B": the names whose value is null.
std::string names_without_value(const ano::Json& file);

/// "A (4 bytes for u8), B (…)": those of the rows that the device sends in another length than their type has.
std::string names_not_readable(const ano::Json& rows);

/// Whether `path` has the name of a file that a calibration keeps: calibration-0xDC-compass.json.
bool is_kept_by_calibration(const std::string& path);

/// The name and the error of a row that "failed" before anything was written.
std::string misfit_line(const ano::Json& row);
/// A line for each row of an answer of /devices/A/apply that is not "unchanged".
std::vector<std::string> difference_lines(const ano::Json& answer);
/// How many rows have this state.
std::size_t rows_with(const ano::Json& answer, std::string_view state);

/// A value for people: 1.5, "text".
std::string value_text(const ano::Json& value);
/// The value of `key` as it is typed: 1.5, text; empty: it is missing.
std::string plain_at(const ano::Json& object, const char* key);

}    // namespace anoctl
