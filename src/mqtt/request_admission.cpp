#include <ano_json/compact_json.hpp>
#include <ano_json/strict_json.hpp>
#include <ano_json/text.hpp>
#include <mqtt/request_admission.hpp>

#include <nlohmann/json.hpp>

#include <cmath>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t second_ns = 1'000'000'000;
constexpr unsigned bad_request = 400, forbidden = 403, timed_out = 408, too_large = 413, too_many = 429, server_error = 500,
                   bad_gateway = 502;

std::string response_json(unsigned status, std::string_view key, const Json& body) {
    Json response{{"status", status}};
    if (!key.empty()) response["key"] = key;
    response[status < bad_request ? "body" : "error"] = body;
    return ano::compact_json(response);
}

bool has_text(const Json& object, const char* name) { return object.contains(name) && object[name].is_string(); }

}    // namespace

struct RequestAdmission::Draft {
    std::string method = "GET", target, body, key;
    std::optional<double> before;    // boot time in seconds

    /// Returns why `payload` is not a request, in a clause; empty: it is.
    std::string read(std::string_view payload);
    bool reads_only() const { return method == "GET"; }
};

std::string RequestAdmission::Draft::read(std::string_view payload) {
    const auto object = ano::strict_json<Json>(payload);
    if (!object || !object->is_object()) return "the request is not a JSON object";
    for (const auto& [name, value] : object->items())
        if (name != "method" && name != "target" && name != "body" && name != "key" && name != "before")
            return "unknown member " + ano::in_quotes(name);
    if (!has_text(*object, "target")) return "\"target\" is missing";
    target = (*object)["target"].get<std::string>();
    if (object->contains("method")) method = has_text(*object, "method") ? (*object)["method"].get<std::string>() : "";
    if (object->contains("body")) body = ano::compact_json((*object)["body"]);
    if (object->contains("key")) {
        if (!has_text(*object, "key")) return "\"key\" must be a text";
        key = (*object)["key"].get<std::string>();
    }
    if (object->contains("before")) {
        if (!(*object)["before"].is_number()) return "\"before\" must be a number, seconds of the gateway's boot time";
        before = (*object)["before"].get<double>();
    }
    return key.empty() || is_level(key) ? "" : "\"key\" must have 1 to 64 bytes, without '/', '+', '#' and control characters";
}

RequestAdmission::Decision RequestAdmission::admit(const RequestMessage& message, std::uint64_t now_ns) {
    const std::string_view client = topics_.client_of(message.topic);
    if (client.empty()) return std::monostate{};
    if (message.is_retained) return refuse(message, client, bad_request, "a retained request is never executed");
    Draft draft;
    if (const std::string fault = draft.read(message.payload); !fault.empty()) return refuse(message, client, bad_request, fault);
    if (!allowed_.allows(draft.method, draft.target))
        return refuse(message, client, forbidden, "not allowed by \"allow\" in the configuration of anogate-mqtt", draft.key);
    if (draft.reads_only()) draft.key.clear();    // repeating it changes nothing
    else if (draft.key.empty() && is_level(message.correlation)) draft.key = message.correlation;
    if (draft.key.empty() && !draft.reads_only())
        return refuse(message, client, bad_request, "a request that changes something needs a \"key\"");
    if (!draft.reads_only() && !draft.before && !message.expiry_s)
        return refuse(message, client, bad_request, "a request that changes something needs \"before\" or a message expiry",
                      draft.key);
    const std::string key = std::string{client} + '/' + (draft.key.empty() ? "/" + std::to_string(++unnamed_) : draft.key);
    if (const auto found = known_.find(key); found != known_.end()) return repeat(message, client, found->second);
    std::uint64_t until_ns = message.received_ns + (message.expiry_s ? *message.expiry_s * second_ns : default_expiry_ns);
    if (draft.before && std::isfinite(*draft.before))
        until_ns = std::min(until_ns,
                            static_cast<std::uint64_t>(std::clamp(*draft.before, 0.0, 1e9) * static_cast<double>(second_ns)));
    if (now_ns >= until_ns) return refuse(message, client, timed_out, "the request expired before it was started", draft.key);
    if (!make_room(now_ns)) return refuse(message, client, too_many, "too many requests within an hour", draft.key);
    known_[key] = {true, response_topic(message, client), message.correlation, {}, now_ns};
    order_.push_back(key);
    return AdmittedRequest{key, draft.method, draft.target, draft.body, until_ns};
}

void RequestAdmission::restore(const std::string& key, std::string response, std::uint64_t now_ns) {
    if (response.empty())
        response = response_json(server_error, key.substr(key.find('/') + 1),
                                 "anogate-mqtt was restarted while the request was executed; its outcome is not known");
    if (known_.try_emplace(key, Known{false, {}, {}, std::move(response), now_ns}).second) order_.push_back(key);
}

RequestAdmission::Decision RequestAdmission::refuse(const RequestMessage& message, std::string_view client, unsigned status,
                                                    std::string_view why, std::string_view key) const {
    return Response{response_topic(message, client), message.correlation, response_json(status, key, why)};
}

// A repeated request gets the response of the first one.
RequestAdmission::Decision RequestAdmission::repeat(const RequestMessage& message, std::string_view client, Known& known) {
    known.topic = response_topic(message, client);
    known.correlation = message.correlation;
    if (known.is_running) return std::monostate{};
    return Response{known.topic, known.correlation, known.payload};
}

// A response is published nowhere else, whatever the client asks for.
std::string RequestAdmission::response_topic(const RequestMessage& message, std::string_view client) const {
    std::string usual = topics_.response(client);
    const std::string_view wanted = message.response_topic;
    const bool is_below = wanted.starts_with(usual) && wanted.substr(usual.size()).starts_with('/') &&
                          is_level(wanted.substr(usual.size() + 1));
    return is_below ? std::string{wanted} : usual;
}

Response RequestAdmission::finish(const std::string& key, unsigned status, std::string_view body) {
    const auto found = known_.find(key);
    if (found == known_.end()) return {};
    Known& known = found->second;
    const std::string_view given = std::string_view{key}.substr(key.find('/') + 1);
    const std::string_view shown = given.starts_with('/') ? std::string_view{} : given;
    Json content = Json::parse(body, nullptr, false);
    if (content.is_discarded()) content = std::string{body};
    if (status >= bad_request && content.is_object() && content.contains("error")) content = Json(content["error"]);
    known.payload = response_json(status == 0 ? bad_gateway : status, shown, content);
    if (known.payload.size() > max_payload) known.payload = response_json(too_large, shown, "the response is larger than 64 KiB");
    known.is_running = false;
    Response response{known.topic, known.correlation, known.payload};
    if (shown.empty()) {    // no client can repeat it
        known_.erase(found);
        std::erase(order_, key);
    }
    return response;
}

Response RequestAdmission::expire(const std::string& key) {
    return finish(key, timed_out, R"({"error": "the request expired before it was started"})");
}

bool RequestAdmission::make_room(std::uint64_t now_ns) {
    while (!order_.empty()) {
        const auto oldest = known_.find(order_.front());
        if (oldest->second.is_running || now_ns - oldest->second.since_ns < kept_ns) break;
        known_.erase(oldest);
        order_.pop_front();
    }
    return known_.size() < max_keys;
}

}    // namespace anogate
