// What a gateway answers, as JSON: another version may have other keys, and what is missing is shown as nothing.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// Throws Failure when it is no JSON.
ano::Json parse_answer(const std::string& body);

/// The value of `key` for people, without control characters: a text as it is, a number in digits; empty: it is not there, or null.
std::string text_at(const ano::Json& object, std::string_view key);
/// 0 when it is not there. What is beyond 2^53 stands there as text.
double number_at(const ano::Json& object, std::string_view key);
/// The object or array; an empty array when it is not there.
const ano::Json& at(const ano::Json& object, std::string_view key);

/// Where a link listens, "0.0.0.0:12333", as soon as it does: the port may be one that the system chose. Empty for others.
std::string listening_place(const ano::Json& link);

/// "fc, radio": the texts of an array.
std::string names_at(const ano::Json& object, std::string_view key);

/// "bad_check 3, stale 12": those of `names` that are not 0.
std::vector<std::string> not_zero(const ano::Json& object, const std::vector<std::string>& names);
/// `head` and `items` with ", " between them, on lines of at most 80 cells; the next ones are indented as far as `head`.
std::string list_text(const std::string& head, const std::vector<std::string>& items);

/// What a recording that runs, or ended, amounts to: "flight-2.mcap" and "7 frames"; of one that has more than one file, "flight" and
/// "18461 frames in 8 files".
struct RecordingSum {
    std::string of, frames;
};
RecordingSum sum_of_recording(const ano::Json& recording);

/// Of the status' `recording`: a line for each that runs, with what is wrong with it, and one when keep_last was not saved.
std::vector<std::string> recording_lines(const ano::Json& recording);

/// In seconds, of a file that is listed; nothing: it does not tell. Where an older gateway says only two times of it, what is between
/// them, unless the clock was not set at its begin, or was set meanwhile.
std::optional<double> length_of_recording(const ano::Json& file);

/// The counters of frames that were to be sent and were not.
const std::vector<std::string>& drop_causes();
/// What kinds of links count beside frames and bytes.
const std::vector<std::string>& counts_of_kinds();
/// All counters but the frames of their direction.
const std::vector<std::string>& causes_in();
const std::vector<std::string>& causes_out();

}    // namespace anoctl
