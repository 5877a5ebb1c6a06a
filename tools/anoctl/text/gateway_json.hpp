// Reads the JSON of a gateway's responses. Other versions of the gateway may have other keys; a missing value counts as empty or
// 0.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// Throws Failure if `body` is not JSON.
ano::Json parse_answer(const std::string& body);

/// The value of `key` for people: text without control characters, numbers as digits. Empty: missing or null.
std::string text_at(const ano::Json& object, std::string_view key);
/// 0 if it is missing. Numbers beyond 2^53 may be given as text.
double number_at(const ano::Json& object, std::string_view key);
/// The object or array at `key`; an empty array if it is missing.
const ano::Json& at(const ano::Json& object, std::string_view key);

/// The endpoint on which a link listens, "0.0.0.0:12333", with the port that the system has chosen. Empty: the link does not
/// listen.
std::string listening_place(const ano::Json& link);

/// Remembers the texts printed for several links: a hint that several links have is printed once.
class PrintedHints {
public:
    /// `text`, or empty if it is a hint that was returned before.
    std::string once(std::string_view key, const std::string& text);

private:
    std::set<std::string> hints_;
};

/// "fc, radio": the texts of an array.
std::string names_at(const ano::Json& object, std::string_view key);

/// "bad_check 3, stale 12": the counters among `names` that are not 0.
std::vector<std::string> not_zero(const ano::Json& object, const std::vector<std::string>& names);
/// `head` and `items`, separated by ", ", on lines of at most 80 cells. The following lines are indented by the length of `head`.
std::string list_text(const std::string& head, const std::vector<std::string>& items);

/// Of a device that is lost, as in the status: "airborne 4.7 s ago, now received on radio". A device without a state: "silent for 4.7 s".
std::string lost_text(const ano::Json& lost);
/// It was not locked: it may be flying.
bool may_fly(const ano::Json& lost);

/// The name and size of a recording: "flight-2.mcap" and "7 frames"; with more than one file, "flight" and "18461 frames in 8 files".
struct RecordingSum {
    std::string of, frames;
};
RecordingSum sum_of_recording(const ano::Json& recording);

/// From `recording` of the status: one line for each running recording, with its error, and one if keep_last was not saved.
std::vector<std::string> recording_lines(const ano::Json& recording);

/// The length of a listed file in seconds; std::nullopt: not known. Older gateways report only the times of begin and end. Then
/// it is their difference, unless the clock was not set at the begin or was changed meanwhile.
std::optional<double> length_of_recording(const ano::Json& file);

/// Whether frames of this link that no link accepts are no loss: it is a replay, or there is no host. anoctl and the page receive
/// them in any case.
template <class Json>
bool is_alone(const Json& link) {
    return link.is_object() && (link.contains("replayed") || (link.contains("hint_id") && link.at("hint_id") == "no_host_takes"));
}
/// The names of the counters of dropped frames. `is_alone`: whether is_alone() is true for the link.
const std::vector<std::string>& drop_causes(bool is_alone);
/// The names of counters that only some kinds of links have.
const std::vector<std::string>& counts_of_kinds();
/// The names of all counters of received data, except the number of frames.
const std::vector<std::string>& causes_in();
const std::vector<std::string>& causes_out();

}    // namespace anoctl
