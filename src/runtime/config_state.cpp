#include <ano_json/answer_json.hpp>
#include <runtime/config_state.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>

namespace anogate {
namespace {

const char* words(const ConfigState& state) {
    if (state.file.empty()) return "command line";
    if (state.runs == ConfigState::Runs::file) return "file";
    return state.runs == ConfigState::Runs::unconfirmed ? "unconfirmed" : "not the file";
}

}    // namespace

nlohmann::ordered_json config_json(const ConfigState& state, ano::TimePoint now) {
    nlohmann::ordered_json json;
    if (state.file.empty()) json["file"] = nullptr;
    else json["file"] = state.file;
    json["state"] = words(state);
    if (state.confirm_by) json["confirm_within_s"] = in_seconds(std::max(*state.confirm_by - now, ano::Duration::zero()));
    if (!state.needs_restart.empty()) json["needs_restart"] = state.needs_restart;
    return json;
}

}    // namespace anogate
