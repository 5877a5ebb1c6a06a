#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <ano_json/fault_json.hpp>
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
    ano::FaultId<> action;
};

constexpr std::size_t number_of_kinds = static_cast<std::size_t>(JobKind::scan) + 1;

constexpr std::uint8_t questions = ano::id_of<"parameter_command">, command_query = ano::id_of<"command_query">,
                       waypoint_read = ano::id_of<"waypoint_read">;

// In the order of JobKind.
constexpr KindRow kinds[] = {
    {"parameters", "answers", questions, "reading_parameters"},
    {"write", "steps", questions, "writing_parameter"},
    {"apply", "parameters", questions, "writing_parameters"},
    {"action", "steps", questions, "saving_parameters"},
    {"commands", "commands", command_query, "reading_commands"},
    {"command", "steps", command_query, "calling_command"},
    {"waypoints", "waypoints", waypoint_read, "reading_waypoints"},
    {"put_waypoints", "waypoints", waypoint_read, "writing_waypoints"},
    {"firmware", "bytes", questions, "firmware_upgrade"},
    {"calibration", "steps", questions, "calibration"},
    {"scan", "devices", questions, "scan"},
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

const KindRow& row_of(JobKind kind) noexcept { return kinds[static_cast<std::size_t>(kind)]; }

}    // namespace

std::string_view name_of(JobKind kind) noexcept { return row_of(kind).name; }
std::string_view unit_of(JobKind kind) noexcept { return row_of(kind).unit; }
std::string_view name_of(JobState state) noexcept { return states[static_cast<std::size_t>(state)]; }

bool asks_by(JobKind kind, std::uint8_t id) noexcept { return row_of(kind).asks_by == id; }

ano::Fault name_of(const Job& job) {
    const ano::Fault action{row_of(job.order.kind).action};
    if (job.order.client.empty()) return {"job_alone", job.id, action};
    return {"job_by", job.id, action, job.order.client};
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
    if (!job.conflict.empty()) json["conflict"] = job.conflict.text();
    if (!job.stopped.empty()) json["stopped"] = job.stopped.text();
    if (!job.step.empty()) json["step"] = Json::parse(job.step, nullptr, false);
    if (!job.end || job.end->status < 300) return json;
    ano::add_fault(json, job.end->fault);
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
    Json json;
    ano::add_fault(json, job.end->fault);
    json.update({{"what", job.end->what}, {"job", job.id}, {"evidence", evidence_json(job.end->evidence)}});
    return std::make_shared<const std::string>(with_result_of(job, json));
}

}    // namespace anogate
