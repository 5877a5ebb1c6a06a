// Texts about a job, while it runs and when it ends.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <string_view>

namespace anoctl {

/// "[#####.....] 63 of 150 parameters, 12/s, 7 s left", in at most `width` cells; only the message if the job has no progress.
/// `seconds`: since the job began.
std::string progress_text(const ano::Json& job, double seconds, std::size_t width);

/// The message of the job; for an upgrade without the rate.
std::string step_text(const ano::Json& job);

/// The anoctl command that starts jobs of this kind: "waypoint put".
std::string command_of_job(const std::string& kind);

/// A clause with the effects of a cancelled job: "4096 of 16384 bytes written; the device is still in its loader: flash it
/// again". Empty: no effects.
std::string half_done(const ano::Json& job);

/// The text of a refusal; names the option of the anoctl `command` that overrides the refusal.
std::string with_options_named(std::string words, std::string_view command);

/// "128 KiB", "900 bytes".
std::string bytes_text(double bytes);

}    // namespace anoctl
