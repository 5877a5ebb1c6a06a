#include "job_text.hpp"

#include <ano_json/text.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <utility>

namespace anoctl {
namespace {

constexpr std::size_t bar_width = 20;

std::string bar(double share) {
    const auto full = static_cast<std::size_t>(std::lround(std::clamp(share, 0.0, 1.0) * double{bar_width}));
    return "[" + std::string(full, '#') + std::string(bar_width - full, '.') + "] ";
}

std::string counted(double number, const std::string& unit) {
    return unit == "bytes" ? bytes_text(number) : ano::number_text(std::round(number));
}

// "63 of 150 parameters"
std::string counts(double done, double total, const std::string& unit) {
    std::string text = counted(done, unit) + " of " + counted(total, unit);
    if (unit != "bytes" && !unit.empty()) text += " " + unit;
    return text;
}

std::string pace(double done, double total, double seconds, const std::string& unit) {
    if (done <= 0 || seconds <= 0.2) return {};
    const double rate = done / seconds;
    std::string text = ", " + (unit == "bytes" ? bytes_text(rate) : ano::number_text(std::round(rate * 10) / 10)) + "/s";
    if (total > done) text += ", " + time_text((total - done) / rate) + " left";
    return text;
}

// The effects of an unfinished apply, from the rows of its result.
std::string what_became_of(const ano::Json& rows) {
    std::size_t written = 0, undone = 0;
    std::string still, unsure;
    for (const ano::Json& row : rows) {
        const std::string state = text_at(row, "state"), name = text_at(row, "name");
        if (state == "written" || state == "clamped") ++written;
        else if (state == "undone") ++undone;
        else if (state == "not_undone") still += (still.empty() ? "" : ", ") + name;
        else if (state == "failed") unsure += "; " + text_at(row, "what");
    }
    std::string words =
        written > 0 ? plural(written, "parameter") + " written; unless saved, the changes are lost when the device restarts" : "";
    if (undone > 0) words += (words.empty() ? "" : "; ") + plural(undone, "parameter") + " written and restored";
    if (!still.empty()) words += (words.empty() ? "" : "; ") + ("not restored: " + still);
    words = words.empty() ? "nothing was written" : words;
    return undone > 0 || !still.empty() ? words : words + unsure;
}

}    // namespace

std::string bytes_text(double bytes) {
    char text[40];
    if (bytes < 1024) std::snprintf(text, sizeof text, "%.0f bytes", bytes);
    else if (bytes < 1024 * 1024) std::snprintf(text, sizeof text, "%.3g KiB", bytes / 1024);
    else std::snprintf(text, sizeof text, "%.3g MiB", bytes / 1024 / 1024);
    return text;
}

std::string step_text(const ano::Json& job) {
    const std::string message = text_at(job, "message");
    return text_at(job, "unit") == "bytes" ? message.substr(0, message.find(", ")) : message;
}

std::string progress_text(const ano::Json& job, double seconds, std::size_t width) {
    const double done = number_at(job, "done"), total = number_at(job, "total");
    const std::string unit = text_at(job, "unit");
    std::string text = step_text(job);
    if (total > 0) {
        const std::string head = bar(done / total) + counts(done, total, unit) + pace(done, total, seconds, unit);
        text = text.empty() ? head : head + ": " + text;
    }
    return in_cells(text, width);
}

std::string with_options_named(std::string words, std::string_view command) {
    constexpr std::string_view longer = "a longer one must be allowed (longer)", ground = "this is only allowed on the ground";
    if (const std::size_t at = words.find(longer); at != words.npos)
        words.replace(at, longer.size(), "--longer allows a longer one");
    constexpr std::string_view beyond = "a value beyond it must be allowed (force)";
    if (const std::size_t at = words.find(beyond); at != words.npos) words.replace(at, beyond.size(), "--force sends it anyway");
    constexpr std::string_view seven = "state it once (type7)";
    if (const std::size_t at = words.find(seven); at != words.npos)
        words.replace(at, seven.size(), "state it once, --type7 f32 or --type7 u64");
    if (words.find(ground) == words.npos) return words;
    const bool has_force = command == "param" || command == "flash";
    words += has_force ? "; land and lock it, or use --force" : "; land and lock it first";
    return words;
}

std::string command_of_job(const std::string& kind) {
    static constexpr std::pair<std::string_view, std::string_view> commands[]{
        {"parameters", "param list"},  {"write", "param set"},
        {"apply", "param import"},     {"action", "param save/reset"},
        {"commands", "command list"},  {"command", "command call"},
        {"waypoints", "waypoint get"}, {"put_waypoints", "waypoint put"},
        {"firmware", "flash"},         {"calibration", "calibrate"},
        {"scan", "devices --scan"},
    };
    for (const auto& [name, command] : commands)
        if (name == kind) return std::string{command};
    return kind;
}

std::string half_done(const ano::Json& job) {
    const double done = number_at(job, "done"), total = number_at(job, "total");
    const std::string job_kind = text_at(job, "kind"), unit = text_at(job, "unit");
    if (job_kind == "firmware" && done > 0)
        return counts(done, total, unit) + " written; the device is still in its loader: flash it again";
    if (job_kind == "apply" && job.contains("result")) return what_became_of(at(job["result"], "parameters"));
    if (job_kind == "apply" && done > 0)
        return "stopped at " + counts(done, total, unit) + "; unless saved, the changes are lost when the device restarts";
    if (job_kind == "put_waypoints" && done > 0)
        return counts(done, total, unit) +
               " written; the device has a mixture of new and old waypoints until you write all of them";
    if (job_kind == "put_waypoints" && total > 0) return counts(done, total, unit) + " written";
    if (job_kind == "command") return "the command may have been executed";
    return {};
}

}    // namespace anoctl
