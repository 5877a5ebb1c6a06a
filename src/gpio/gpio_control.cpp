#include <ano_json/answer_json.hpp>
#include <ano_json/fault_json.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/strict_json.hpp>
#include <config/key_facts.hpp>
#include <config/values.hpp>
#include <gpio/gpio_control.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

Json line_number(const std::string& line) {
    if (const auto number = parse_number(line)) return *number;
    return line;
}

Json line_json(const Gpio::Line& line, TimePoint now) {
    const GpioSettings& s = line.settings();
    const GpioLine* held = line.pin.line();
    Json json{{"use", text(s.use)}, {"chip", held ? held->chip() : s.chip}};
    json["line"] = held ? Json(held->offset()) : line_number(s.line);
    if (held && !held->name().empty()) json["name"] = held->name();
    if (!s.link.empty()) json["link"] = s.link;
    if (!s.links.empty()) json["links"] = s.links;
    json["state"] = held ? "held" : "waiting";
    json["error"] = line.pin.error();
    json["value"] = held ? Json(line.pin.active()) : Json(nullptr);
    if (s.use == GpioUse::inhibit) json["inhibiting"] = !held || line.pin.active();
    json["edges"] = line.pin.edges();
    json["edge_s"] = line.pin.edges() == 0 ? Json(nullptr)
                                           : Json(in_seconds(std::max(now - line.pin.edge_at(), Duration::zero())));
    if (s.use == GpioUse::reset || s.use == GpioUse::power) json["pulses"] = line.pulses;
    return json;
}

http::Response reply(unsigned status, const Json& json) {
    http::Response response;
    response.status = status;
    response.body = line_of(json);
    return response;
}

http::Response refuse(unsigned status, const std::string& why, std::optional<Duration> wait = {}) {
    Json json;
    ano::add_fault(json, {"other", why});
    json["what"] = http::what_of(status);
    if (wait) json["wait_s"] = in_seconds(*wait);
    return reply(status, json);
}

bool can_act(GpioUse use) { return use == GpioUse::reset || use == GpioUse::power; }

// The properties by which a request selects a line; an empty one matches every line.
struct Wanted {
    std::string line, chip, link, use, action;

    bool fits(const Gpio::Line& candidate) const {
        const GpioSettings& s = candidate.settings();
        const GpioLine* held = candidate.pin.line();
        const auto is = [](const std::string& wanted, const std::string& name) { return wanted.empty() || wanted == name; };
        return (is(line, s.line) || (held && (is(line, held->name()) || is(line, std::to_string(held->offset()))))) &&
               (is(chip, s.chip) || (held && is(chip, held->chip()))) && is(link, s.link) && is(use, text(s.use));
    }
    bool fits_action(GpioUse of) const {
        return action.empty() || (of == GpioUse::reset && action == "pulse") || (of == GpioUse::power && action == "cycle");
    }
};

// Fills `wanted`; returns the error, or empty.
std::string read(const std::string& body, Wanted& wanted) {
    const auto parsed = ano::json_body(body);
    if (const auto* wrong = std::get_if<std::string>(&parsed)) return *wrong;
    const auto* const json = std::get_if<nlohmann::ordered_json>(&parsed);
    if (!json->is_object()) return "the body must be a JSON object such as {\"link\": \"fc\", \"use\": \"reset\"}";
    constexpr std::string_view names[] = {"line", "chip", "link", "use", "action"};
    std::string* const fields[] = {&wanted.line, &wanted.chip, &wanted.link, &wanted.use, &wanted.action};
    for (const auto& [name, value] : json->items()) {
        const auto found = std::find(std::begin(names), std::end(names), name);
        if (found == std::end(names)) return "unknown key " + in_quotes(name) + ano::did_you_mean(name, names);
        std::string& field = *fields[found - std::begin(names)];
        if (value.is_string() && value != "") field = value.get<std::string>();
        else if (name == "line" && value.is_number_unsigned()) field = value.dump();
        else return in_quotes(name) + " must be text" + (name == "line" ? " or a number" : "");
    }
    return {};
}

}    // namespace

Json gpio_json(const Gpio& gpio, TimePoint now) {
    Json json = Json::array();
    for (const auto& line : gpio.lines()) json.push_back(line_json(*line, now));
    return json;
}

http::Response gpio_request(Gpio& gpio, const std::string& body, TimePoint now) {
    Wanted wanted;
    if (const std::string wrong = read(body, wanted); !wrong.empty()) return refuse(400, wrong);
    std::vector<Gpio::Line*> fitting;
    for (const auto& line : gpio.lines()) {
        const bool named = !wanted.line.empty() || !wanted.use.empty();    // then a line without actions is a 400
        if (wanted.fits(*line) && (named || can_act(line->settings().use))) fitting.push_back(line.get());
    }
    if (fitting.empty()) return refuse(404, "no GPIO line matches; GET /status lists them under gpio");
    if (fitting.size() > 1)
        return refuse(400, std::to_string(fitting.size()) + " GPIO lines match; select one by line, chip, link or use");
    Gpio::Line& line = *fitting.front();
    if (!can_act(line.settings().use)) return refuse(400, "only reset and power lines support actions");
    if (!wanted.fits_action(line.settings().use))
        return refuse(400,
                      "the action must be pulse for a reset line or cycle for a power line, not " + in_quotes(wanted.action));
    if (const auto refusal = gpio.act(line, now)) {
        if (refusal->wait <= Duration::zero()) return refuse(409, refusal->why);
        return refuse(429, refusal->why, refusal->wait);
    }
    return reply(200, line_json(line, now));
}

}    // namespace anogate
