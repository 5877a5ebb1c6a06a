#include <ano_json/answer_json.hpp>
#include <ano_json/fault_json.hpp>
#include <ano_json/flexible_json.hpp>
#include <ano_json/strict_json.hpp>
#include <control/flexible_control.hpp>
#include <log/log_line.hpp>
#include <runtime/gateway.hpp>
#include <runtime/kept_parameters.hpp>
#include <sys/files/write_atomically.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <utility>
#include <variant>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using Specs = std::vector<ano::FlexibleSpec>;

constexpr std::size_t max_flexible = 1 << 20;    // bytes of the file

http::Response answer(const Gateway& gateway, std::optional<std::string> not_kept = std::nullopt) {
    Json json{{"flexible", ano::flexible_to_json(gateway.decoding()->flexible())},
              {"from", gateway.layouts().is_of_client() ? "client" : "configuration"}};
    if (not_kept) json["kept"] = not_kept->empty();
    if (not_kept && !not_kept->empty()) json["why"] = *not_kept;
    http::Response response;
    response.body = line_of(std::move(json));
    return response;
}

http::Response faulty(const std::vector<ano::JsonFault>& faults) {
    constexpr std::size_t most = 20;
    Json lines = Json::array();
    for (std::size_t i = 0; i < std::min(faults.size(), most); ++i)
        lines.push_back((faults[i].pointer.empty() ? "" : faults[i].pointer + ": ") + faults[i].what);
    if (faults.size() > most) lines.push_back("and " + std::to_string(faults.size() - most) + " more errors");
    http::Response response;
    response.status = 422;
    Json json;
    ano::add_fault(json, {"other", "nothing was changed: " + lines[0].get<std::string>()});
    json.update({{"what", "invalid"}, {"faults", std::move(lines)}});
    response.body = line_of(std::move(json));
    return response;
}

// `body` is the list of layouts, or an object that contains it: a configuration, or the response of GET.
std::variant<Specs, http::Response> layouts_in(const std::string& body) {
    const auto parsed = ano::json_body(body);
    if (const auto* wrong = std::get_if<std::string>(&parsed)) return http::error(400, *wrong);
    const nlohmann::json read = std::get<Json>(parsed);
    const nlohmann::json* const json = &read;
    const bool is_inside = json->is_object() && json->contains("flexible");
    if (!is_inside && !json->is_array())
        return http::error(400, R"(the body must be a list of layouts, or an object such as {"flexible": [...]})");
    Specs specs;
    const auto faults = ano::read_flexible(is_inside ? (*json)["flexible"] : *json, is_inside ? "/flexible" : "", specs);
    if (!faults.empty()) return faulty(faults);
    return specs;
}

}    // namespace

std::string KeptFlexible::text() const {
    return line_of(Json{{"flexible", ano::flexible_to_json(flexible)}, {"file", ano::flexible_to_json(of_file)}});
}

std::optional<KeptFlexible> KeptFlexible::parse(std::string_view text) {
    std::vector<ano::JsonFault> faults;
    const auto json_text = ano::strict_json<nlohmann::json>(text, false, faults);
    if (!json_text || !faults.empty()) return std::nullopt;
    const nlohmann::json& json = *json_text;
    if (!json.is_object() || !json.contains("flexible") || !json.contains("file")) return std::nullopt;
    KeptFlexible kept;
    if (!ano::read_flexible(json["flexible"], {}, kept.flexible).empty()) return std::nullopt;
    if (!ano::read_flexible(json["file"], {}, kept.of_file).empty()) return std::nullopt;
    return kept;
}

std::string kept_flexible_path(const std::string& config_file) { return kept_state_path("flexible", config_file); }

std::optional<KeptFlexible> kept_flexible(const std::string& path) {
    std::string fault;
    const auto text = read_kept_file(path, max_flexible, fault);
    if (!text && fault.empty()) return std::nullopt;
    auto kept = text ? KeptFlexible::parse(*text) : std::nullopt;
    if (!kept)
        log_warning("{}; the layouts of the configuration are used", fault.empty() ? path + ": not a list of layouts" : fault);
    return kept;
}

FlexibleControl::FlexibleControl(Gateway& gateway, std::string path, std::optional<KeptFlexible> kept)
    : gateway_{gateway}, path_{std::move(path)}, background_task_{gateway.io()} {
    gateway_.parts().enter(*this);
    if (!kept) return;
    if (kept->of_file == gateway_.settings().flexible) gateway_.layouts().set(std::move(kept->flexible));
    else layouts_overruled();
}

FlexibleControl::~FlexibleControl() {
    gateway_.parts().leave(*this);
    stopping();
}

void FlexibleControl::layouts_overruled() {
    if (is_stopped_) return;
    log_info("layouts of flexible messages set by a client are discarded: the configuration changed after that");
    keep({});
}

void FlexibleControl::stopping() {
    is_stopped_ = true;
    background_task_.stop();
    waiting_.clear();
}

void FlexibleControl::add_routes(http::Routes& routes) {
    routes.add({"GET", "/flexible", http::Access::view, "the layouts of flexible messages in use, and where they come from",
                [this](const http::Request&) { return answer(gateway_); }});
    routes.add({"PUT", "/flexible", http::Access::control,
                "replaces the layouts of flexible messages, a list as in the configuration; stored across restarts until the "
                "configuration changes them",
                [this](const http::Request& request) { return set(request); }});
}

http::Response FlexibleControl::set(const http::Request& request) {
    gateway_.turn();
    if (gateway_.loop().may_have_waited(request.came_at)) return http::try_again(ano::Fault{"request_expired"});
    auto read = layouts_in(request.body);
    if (auto* refusal = std::get_if<http::Response>(&read)) return std::move(*refusal);
    before_change_();
    gateway_.layouts().set(std::get<Specs>(std::move(read)));
    if (path_.empty())
        return answer(gateway_, "without a configuration file or a state folder, they apply until the gateway stops");
    return http::later([this](const Respond& respond) { keep(respond); });
}

void FlexibleControl::keep(Respond respond) {
    waiting_.push_back(std::move(respond));
    if (!background_task_.is_running()) write();
}

// Requests received during a write are answered after the next one.
void FlexibleControl::write() {
    const std::string text = gateway_.layouts().is_of_client()
                                 ? KeptFlexible{gateway_.layouts().layouts(), gateway_.settings().flexible}.text()
                                 : std::string{};
    const auto fault = std::make_shared<std::string>();
    const auto work = [path = path_, text, fault] {
        *fault = text.empty() ? forget_file(path)
                              : write_atomically(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    };
    const auto done = [this, fault, callbacks = std::exchange(waiting_, {})](const std::string& thrown) {
        const std::string why = thrown.empty() ? *fault : thrown;
        if (!why.empty()) log_warning("layouts of flexible messages could not be stored: {}", why);
        for (const Respond& respond : callbacks)
            if (respond) respond(answer(gateway_, why));
        if (!waiting_.empty()) write();
    };
    if (!path_.empty() && !background_task_.run(work, done)) done(std::string{background_task_.why_not()});
}

}    // namespace anogate
