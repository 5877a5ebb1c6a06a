#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <devices/job.hpp>

#include <nlohmann/json.hpp>

#include <chrono>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

struct KindRow {
    std::string_view name, unit;
    std::uint8_t asks_by;    // the id of its questions
};

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
constexpr std::string_view states[] = {"running", "waiting", "done", "failed", "cancelled"};

const KindRow& row_of(JobKind kind) noexcept { return kinds[static_cast<std::size_t>(kind)]; }

}    // namespace

std::string_view name_of(JobKind kind) noexcept { return row_of(kind).name; }
std::string_view unit_of(JobKind kind) noexcept { return row_of(kind).unit; }
std::string_view name_of(JobState state) noexcept { return states[static_cast<std::size_t>(state)]; }

bool asks_by(JobKind kind, std::uint8_t id) noexcept { return row_of(kind).asks_by == id; }

std::string words_of(const Job& job) {
    std::string words = "job " + std::to_string(job.id) + " (" + std::string{name_of(job.order.kind)};
    if (!job.order.client.empty()) words += " of " + job.order.client;
    return words + ")";
}

nlohmann::ordered_json job_json(const Job& job, bool with_result) {
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
    if (!job.step.empty()) json["step"] = Json::parse(job.step, nullptr, false);
    if (!job.end) return json;
    if (!with_result && job.end->status < 300) return json;
    if (job.end->status < 300) {
        json["result"] = job.end->result.empty() ? Json(nullptr) : Json::parse(job.end->result, nullptr, false);
        return json;
    }
    json["error"] = job.end->error;
    json["what"] = job.end->what;
    json["status"] = job.end->status;
    if (with_result && !job.end->result.empty()) json["result"] = Json::parse(job.end->result, nullptr, false);
    Json evidence{{"sent", job.end->evidence.sent}};
    if (job.end->evidence.round_trip)
        evidence["rtt_ms"] = static_cast<double>(
                                 std::chrono::duration_cast<std::chrono::microseconds>(*job.end->evidence.round_trip).count()) /
                             1000;
    json["evidence"] = std::move(evidence);
    return json;
}

}    // namespace anogate
