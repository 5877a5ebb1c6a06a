// The texts about a job while it runs and when it ends.
#pragma once
#include <ano_json/frame_json.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <string_view>

namespace anoctl {

/// "[#####.....] 63 of 150 parameters, 12/s, 7 s left", in at most `width` cells; `seconds`: since it began. Its message, when it counts
/// nothing.
std::string progress_text(const ano::Json& job, double seconds, std::size_t width);

/// Its message; that of an upgrade without the rate.
std::string step_text(const ano::Json& job);

/// The command of anoctl that asks for jobs of this kind: "waypoint put".
std::string command_of_job(const std::string& kind);

/// A clause: what is half done after it was cancelled: "4096 of 16384 bytes written; the device is still in its loader: flash it
/// again". Empty: nothing.
std::string half_done(const ano::Json& job);

/// The text of a refusal, with the option of anoctl `command` that overrides it.
std::string with_options_named(std::string words, std::string_view command);

/// "128 KiB", "900 bytes".
std::string bytes_text(double bytes);

}    // namespace anoctl
