// The file of `anoctl param export`, and the selection of its values for writing.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// Makes {"device": "0xDC", "name", "dev_id", "hw", "sw", "parameters": {NAME: value}} from the response of GET
/// /devices/A/parameters. inf and nan, which JSON does not have, become null. A name that is empty or not unique gets its number
/// as a suffix: "NAME#3". Unreadable values are omitted.
/// Throws Failure with the names of parameters that were not received: an incomplete backup would be useless.
ano::Json parameter_file(const ano::Json& answer);

/// Parses such a file, a file stored by a calibration ("device" is an object there), or a plain {NAME: value}. Throws UsageError
/// for anything else.
ano::Json parsed_parameter_file(const std::string& text, const std::string& path);

/// A clause with the reason why the file belongs to another device than `device` ({"name", "dev_id"…}). Empty: it belongs to this
/// one, or its device is not known.
std::string of_another_device(const ano::Json& file, const ano::Json& device);

/// CAL_…: calibration values of one piece of hardware.
bool is_calibration(std::string_view name) noexcept;

/// The values of `file` to be written: not null, and calibration values only if `with_calibration`. `left_out`: the number of
/// omitted calibration values.
ano::Json wanted_values(const ano::Json& file, bool with_calibration, std::size_t& left_out);
/// "A, B": the names whose value is null.
std::string names_without_value(const ano::Json& file);

/// "A (4 bytes for u8), B (…)": the rows whose value has another length than its type.
std::string names_not_readable(const ano::Json& rows);

/// Whether `path` has the name of a file stored by a calibration: calibration-0xDC-compass.json.
bool is_kept_by_calibration(const std::string& path);

/// The name and the error of a row whose state is "failed", when nothing was written.
std::string misfit_line(const ano::Json& row);
/// A line for each row of an answer of /devices/A/apply that is not "unchanged".
std::vector<std::string> difference_lines(const ano::Json& answer);
/// The number of rows in this state.
std::size_t rows_with(const ano::Json& answer, std::string_view state);

/// A value as text for people: 1.5, "text".
std::string value_text(const ano::Json& value);
/// The value of `key` as it is typed: 1.5, text. Empty: missing.
std::string plain_at(const ano::Json& object, const char* key);

}    // namespace anoctl
