#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <ano_json/json_line.hpp>
#include <devices/job.hpp>

#include <nlohmann/json.hpp>

#include <chrono>
#include <cstddef>
#include <iterator>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

struct KindRow {
    std::string_view name, unit;
    std::uint8_t asks_by;    // the id of its questions
};

constexpr std::size_t number_of_kinds = static_cast<std::size_t>(JobKind::scan) + 1;

constexpr std::uint8_t questions = ano::id_of<"parameter_command">, command_query = ano::id_of<"command_query">,
                       waypoint_read = ano::id_of<"waypoint_read">;

// In the order of JobKind.
constexpr KindRow kinds[] = {
    {"parameters", "answers", questions},
    {"write", "steps", questions},
    {"apply", "parameters", questions},
    {"action", "steps", questions},
    {"commands", "commands", command_query},
    {"command", "steps", command_query},
    {"waypoints", "waypoints", waypoint_read},
    {"put_waypoints", "waypoints", waypoint_read},
    {"firmware", "bytes", questions},
    {"calibration", "steps", questions},
    {"scan", "devices", questions},
};
static_assert(std::size(kinds) == number_of_kinds);
constexpr std::string_view states[] = {"running", "waiting", "done", "failed", "cancelled"};
static_assert(std::size(states) == static_cast<std::size_t>(JobState::cancelled) + 1);

Json evidence_json(const ano::host::Evidence& of) {
    Json evidence{{"sent", of.sent}};
    if (of.round_trip)
        evidence["rtt_ms"] = static_cast<double>(std::chrono::duration_cast<std::chrono::microseconds>(*of.round_trip).count()) /
                             1000;
    if (of.by_port) evidence["acknowledged_by"] = ano::hex_byte(*of.by_port);
    if (of.may_be_of_equal) evidence["ambiguous"] = true;
    if (!of.unfit.empty()) evidence["unfit"] = ano::hex(of.unfit);
    return evidence;
}

// Inserts the result as text, without parsing it, because it may be large.
std::string with_result_of(const Job& job, const Json& json) {
    std::string line = ano::json_line(json);
    if (!job.end || (!job.result && job.end->status >= 300)) return line;
    const std::string_view result = job.result ? std::string_view{*job.result} : "null\n";
    constexpr std::string_view between = ",\"result\":";
    line.reserve(line.size() + between.size() + result.size());
    line.resize(line.size() - 2);    // "}\n"
    return line.append(between).append(result.substr(0, result.size() - 1)).append("}\n");
}

// The action of each kind as text for people; in the order of JobKind.
constexpr std::string_view actions[] = {
    "reading parameters",
    "writing a parameter",
    "writing parameters",
    "saving or restoring parameters",
    "reading commands",
    "calling a command",
    "reading waypoints",
    "writing waypoints",
    "firmware upgrade",
    "calibration",
    "scan",
};
static_assert(std::size(actions) == number_of_kinds);

std::string_view action_of(JobKind kind) noexcept { return actions[static_cast<std::size_t>(kind)]; }

const KindRow& row_of(JobKind kind) noexcept { return kinds[static_cast<std::size_t>(kind)]; }

}    // namespace

std::string_view name_of(JobKind kind) noexcept { return row_of(kind).name; }
std::string_view unit_of(JobKind kind) noexcept { return row_of(kind).unit; }
std::string_view name_of(JobState state) noexcept { return states[static_cast<std::size_t>(state)]; }

bool asks_by(JobKind kind, std::uint8_t id) noexcept { return row_of(kind).asks_by == id; }

std::string to_string(const Job& job) {
    std::string words = "job " + std::to_string(job.id) + " (" + std::string{action_of(job.order.kind)};
    if (!job.order.client.empty()) words += ", by " + job.order.client;
    return words + ")";
}

std::string exact_json(const std::string& text) {
    std::string line = ano::json_line(Json::parse(text, nullptr, false));
    line.pop_back();
    return line;
}

nlohmann::ordered_json job_json(const Job& job) {
    Json json{{"id", job.id}};
    if (job.order.address) json["device"] = ano::hex_byte(*job.order.address);
    json["kind"] = name_of(job.order.kind);
    if (!job.order.client.empty()) json["client"] = job.order.client;
    json["state"] = name_of(job.state);
    if (job.progress.total > 0) {
        json["progress"] = static_cast<double>(job.progress.done) / static_cast<double>(job.progress.total);
        json["done"] = job.progress.done;
        json["total"] = job.progress.total;
        json["unit"] = unit_of(job.order.kind);
    }
    json["message"] = job.message;
    if (!job.conflict.empty()) json["conflict"] = job.conflict;
    if (!job.stopped.empty()) json["stopped"] = job.stopped;
    if (!job.step.empty()) json["step"] = Json::parse(job.step, nullptr, false);
    if (!job.end || job.end->status < 300) return json;
    json["error"] = job.end->error;
    json["what"] = job.end->what;
    json["status"] = job.end->status;
    json["evidence"] = evidence_json(job.end->evidence);
    return json;
}

std::shared_ptr<const std::string> job_line(const Job& job) {
    if (auto line = job.line.lock()) return line;
    auto line = std::make_shared<const std::string>(with_result_of(job, job_json(job)));
    if (job.is_over()) job.line = line;
    return line;
}

std::shared_ptr<const std::string> end_line(const Job& job) {
    if (job.end->status < 300) return job.result ? job.result : std::make_shared<const std::string>("null\n");
    return std::make_shared<const std::string>(with_result_of(job, Json{{"error", job.end->error},
                                                                        {"what", job.end->what},
                                                                        {"job", job.id},
                                                                        {"evidence", evidence_json(job.end->evidence)}}));
}

}    // namespace anogate
