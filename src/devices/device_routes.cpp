#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano_json/compact_json.hpp>
#include <ano_json/json_line.hpp>
#include <ano_json/lower_case.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/shown_text.hpp>
#include <ano_json/strict_json.hpp>
#include <ano_json/text.hpp>
#include <devices/device_json.hpp>
#include <devices/device_routes.hpp>
#include <devices/job_answers.hpp>
#include <devices/watch_routes.hpp>
#include <devices/works/calibration_work.hpp>
#include <devices/works/command_works.hpp>
#include <devices/works/firmware_work.hpp>
#include <devices/works/parameter_works.hpp>
#include <devices/works/scan_work.hpp>
#include <devices/works/waypoint_works.hpp>
#include <host/firmware_image.hpp>
#include <http/client_text.hpp>
#include <http/large_body.hpp>
#include <http/routes.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <span>
#include <utility>
#include <vector>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::host::Operation;
using http::Access;
using http::Request;
using http::Response;
using MakeWork = std::function<std::unique_ptr<Work>(const WorkPlace& place)>;

Response json_response(const Json& json) {
    Response response;
    response.body = ano::json_line(json);
    return response;
}

constexpr std::uint64_t max_firmware = ano::host::FirmwareImage::max_bytes;

Json devices_list(DeviceService& service) {
    const ano::TimePoint now = service.net().now();
    Json devices = Json::array();
    for (const DeviceReport& report : service.devices(now)) devices.push_back(device_json(report, now));
    Json all{{"devices", std::move(devices)}};
    if (Json lost = lost_json(service); !lost.empty()) all["lost"] = std::move(lost);
    return all;
}

/// A client's request to one device.
struct JobRequest {
    JobKind kind;
    Operation operation;
    MakeWork work;
    bool at_once = false;    // answered at once with the job, not later with its result
    std::string shared_as{};
    bool is_first_frame = false;
};

// "192.168.1.5", "logger at 192.168.1.5"; at the Unix socket "anoctl of pi, process 712", "logger (python3 of pi, process 712)".
std::string client_of(const Request& request) {
    const std::string_view name = request.query_value("client").value_or(std::string_view{});
    const std::string client = http::format_client(request);
    constexpr std::size_t max_bytes = 64;
    std::string clean;
    for (std::size_t i = 0; i < name.size() && clean.size() < max_bytes; ++i)
        if (const std::size_t size = ano::control_size(name, i); size > 0) i += size - 1;
        else clean += name[i];
    clean.resize(ano::without_cut_character(clean, ano::Encoding::utf8).size());
    if (clean.empty() || client.empty()) return clean + client;
    return request.connection_info.is_network ? clean + " at " + client : clean + " (" + client + ")";
}

Response begin(DeviceService& service, const Request& request, JobRequest job_request) {
    DeviceNet& net = service.net();
    if (job_request.operation != Operation::read && net.may_have_waited(request.came_at))
        return http::try_again(ano::Fault{"request_expired"});
    const Requester requester = requester_of(request, job_request.operation != Operation::read);
    if (!service.has_room_for(requester)) return http::try_again(ano::Fault{"clients_waiting"});
    const ano::TimePoint now = net.now();
    const auto address = service.address_of(request.parameter("device"), now);
    if (const auto* unknown = std::get_if<NotBegun>(&address)) return answer_of(*unknown);
    JobOrder order{
        job_request.kind,   job_request.operation,      std::get<std::uint8_t>(address), request.query_value("force").has_value(),
        client_of(request), std::move(job_request.work)};
    order.shared_as = std::move(job_request.shared_as);
    order.requester = requester;
    order.is_first_frame = job_request.is_first_frame;
    const auto begun = service.begin(std::move(order), now);
    if (const auto* refused = std::get_if<NotBegun>(&begun)) return answer_of(*refused);
    const auto& job = std::get<std::shared_ptr<Job>>(begun);
    return job_request.at_once ? job_answer(service, job, request, 202) : answer_of(service, job, request);
}

Response scan_answer(DeviceService& service, const Request& request) {
    DeviceNet& net = service.net();
    if (net.may_have_waited(request.came_at)) return http::try_again(ano::Fault{"request_expired"});
    JobOrder order{JobKind::scan, Operation::read, std::nullopt, false, client_of(request), scan};
    order.requester = requester_of(request, false);
    order.result = [&service] { return ano::compact_json(devices_list(service)); };
    const auto begun = service.begin(std::move(order), net.now());
    if (const auto* refused = std::get_if<NotBegun>(&begun)) return answer_of(*refused);
    return answer_of(service, std::get<std::shared_ptr<Job>>(begun), request);
}

/// The body as a JSON object, or the error.
std::variant<Json, std::string> object_in(const Request& request) {
    auto body = request.body.empty() ? std::variant<Json, std::string>{Json::object()} : ano::json_body(request.body);
    if (auto* wrong = std::get_if<std::string>(&body)) return std::move(*wrong);
    Json& json = std::get<Json>(body);
    if (!json.is_object()) return std::string{"the body must be an object"};
    return std::move(json);
}

/// The error for a key that is not in `known`: a mistyped "rollback" must not be ignored.
std::string stranger_in(const Json& object, std::initializer_list<std::string_view> known) {
    for (const auto& [key, value] : object.items())
        if (std::find(known.begin(), known.end(), key) == known.end())
            return "unknown key " + ano::in_quotes(key) + ano::did_you_mean(key, {known.begin(), known.size()});
    return {};
}

/// False if it is missing; std::nullopt: not a boolean.
std::optional<bool> flag_in(const Json& object, const char* key) {
    if (!object.contains(key)) return false;
    return object[key].is_boolean() ? std::optional{object[key].get<bool>()} : std::nullopt;
}

bool is_number_or_text(const Json& json) { return json.is_number() || json.is_string(); }

Response put_parameter(DeviceService& service, const Request& request) {
    const auto body = object_in(request);
    if (const auto* wrong = std::get_if<std::string>(&body)) return http::error(400, *wrong);
    const Json& json = std::get<Json>(body);
    if (const std::string wrong = stranger_in(json, {"value", "longer", "force"}); !wrong.empty()) return http::error(400, wrong);
    const auto longer = flag_in(json, "longer"), force = flag_in(json, "force");
    if (!json.contains("value") || !is_number_or_text(json["value"])) return http::error(400, "'value' must be a number or text");
    if (!longer) return http::error(400, "'longer' must be true or false");
    if (!force) return http::error(400, "'force' must be true or false");
    return begin(service, request,
                 {JobKind::write, Operation::write,
                  [name = std::string{request.parameter("parameter")}, value = json["value"],
                   limits = ano::host::WriteLimits{.longer = *longer, .beyond_range = *force}](const WorkPlace& place) {
                      return write_parameter(place, name, value, limits);
                  }});
}

// The short form is {NAME: value, …}; the long form has an object "parameters".
Response apply(DeviceService& service, const Request& request) {
    const auto body = object_in(request);
    if (const auto* wrong = std::get_if<std::string>(&body)) return http::error(400, *wrong);
    const Json& json = std::get<Json>(body);
    const bool is_long = json.contains("parameters") && json["parameters"].is_object();
    ApplyOrder order;
    if (is_long) {
        if (const std::string wrong = stranger_in(
                json, {"parameters", "rollback", "dry_run", "longer", "force", "goes_on", "also_the_same"});
            !wrong.empty())
            return http::error(400, wrong);
        for (const auto& [key, flag] : {std::pair{"rollback", &order.rollback}, std::pair{"dry_run", &order.dry_run},
                                        std::pair{"longer", &order.longer}, std::pair{"force", &order.force},
                                        std::pair{"goes_on", &order.goes_on}, std::pair{"also_the_same", &order.also_the_same}}) {
            if (!json.contains(key)) continue;
            const auto flag_value = flag_in(json, key);
            if (!flag_value) return http::error(400, "'" + std::string{key} + "' must be true or false");
            *flag = *flag_value;
        }
    }
    const Json& values = is_long ? json["parameters"] : json;
    for (const auto& [name, value] : values.items())
        if (!is_number_or_text(value)) return http::error(422, ano::in_quotes(name) + " must be a number or text");
    return begin(service, request,
                 {JobKind::apply, order.dry_run ? Operation::read : Operation::write,
                  [values, order](const WorkPlace& place) { return apply_parameters(place, values, order); }});
}

std::optional<unsigned> number_in(std::string_view text) {
    unsigned number = 0;
    const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), number);
    return ec == std::errc{} && end == text.data() + text.size() ? std::optional{number} : std::nullopt;
}

/// Calls `function` with the job named in the path.
http::Routes::Function with_job(DeviceService& service,
                                std::function<Response(const Request& request, const std::shared_ptr<Job>& job)> function) {
    return [&service, function = std::move(function)](const Request& request) {
        const std::string_view word = request.parameter("job");
        const auto id = number_in(word);
        const auto job = id ? service.job(*id) : nullptr;
        if (!job) return http::error({"no_such_job", ano::in_quotes(word)});
        return function(request, job);
    };
}

void add_job_routes(http::Routes& routes, DeviceService& service) {
    routes.add({"GET", "/jobs", Access::view, "current and recent jobs of devices", [&service](const Request&) {
                    Json jobs = Json::array();
                    for (const auto& job : service.jobs()) jobs.push_back(job_json(*job));
                    return json_response({{"jobs", std::move(jobs)}});
                }});
    routes.add({"GET", "/jobs/{job}", Access::view,
                "one job; with Accept: application/x-ndjson a line, as a WebSocket a message for each change",
                with_job(service, [&service](const Request& request, const std::shared_ptr<Job>& job) {
                    return job_answer(service, job, request, 200);
                })});
    routes.add_without_body({"DELETE", "/jobs/{job}", Access::control, "cancels the job and returns how it ended",
                             with_job(service, [&service](const Request&, const std::shared_ptr<Job>& job) {
                                 service.cancel(*job, service.net().now());
                                 return job_at_its_end(job);
                             })});
    routes.add_without_body({"POST", "/jobs/{job}/next", Access::control, "continues a waiting job",
                             with_job(service, [&service](const Request&, const std::shared_ptr<Job>& job) {
                                 if (const auto refused = service.go_on(*job, service.net().now())) return answer_of(*refused);
                                 return json_response(job_json(*job));    // it is running, so it has no result yet
                             })});
}

Response get_parameters(DeviceService& service, const Request& request) {
    ParameterOrder order{request.query_value("values").value_or("1") != "0", request.query_value("known").has_value(), {}};
    for (const auto& [key, value] : request.query)
        if (key == "name") {
            if (!order.words) order.words.emplace();
            order.words->push_back(value);
        }
    const bool is_shared = !order.words && !order.known;
    const char* const shared_as = order.values ? "all with values" : "all without values";
    return begin(service, request,
                 {JobKind::parameters, Operation::read, [order](const WorkPlace& place) { return read_parameters(place, order); },
                  false, is_shared ? shared_as : ""});
}

void add_parameter_routes(http::Routes& routes, DeviceService& service) {
    routes.add({"GET", "/devices/{device}/parameters", Access::view,
                "the parameters of a device with their values (values=0: without values; with known: as last read; name=P, "
                "repeatable: only these)",
                [&service](const Request& request) { return get_parameters(service, request); }, 0, true});
    routes.add({"GET", "/devices/{device}/parameters/{parameter}", Access::view, "one parameter, by its name or number",
                [&service](const Request& request) {
                    return begin(service, request,
                                 {JobKind::parameters, Operation::read,
                                  [name = std::string{request.parameter("parameter")}](const WorkPlace& place) {
                                      return read_parameter(place, name);
                                  }});
                },
                0, true});
    routes.add({"PUT", "/devices/{device}/parameters/{parameter}", Access::control,
                "writes a parameter, {\"value\": v}, and returns the value that the device stored",
                [&service](const Request& request) { return put_parameter(service, request); }});
    routes.add({"POST", "/devices/{device}/apply", Access::control,
                "writes those of {NAME: value} that differ, continues after refused ones, and returns the result of each (in "
                "\"parameters\" next to rollback or dry_run)",
                [&service](const Request& request) { return apply(service, request); }});
}

Response act(DeviceService& service, const Request& request) {
    using ano::host::Action;
    const auto body = object_in(request);
    if (const auto* wrong = std::get_if<std::string>(&body)) return http::error(400, *wrong);
    const Json& json = std::get<Json>(body);
    const std::string name = json.contains("action") && json["action"].is_string() ? json["action"].get<std::string>() : "";
    const bool restores = name == "restore_defaults";
    if (json.size() != 1 || (!restores && name != "save"))
        return http::error(400, R"(the body must be {"action": "save"} or {"action": "restore_defaults"})");
    return begin(service, request,
                 {JobKind::action, restores ? Operation::ground : Operation::write, [restores, name](const WorkPlace& place) {
                      return anogate::act(place, restores ? Action::restore_defaults : Action::save, name);
                  }});
}

/// The common members of all calls.
struct CallBody {
    Json json, values;
    CommandOrder order;
};
std::variant<CallBody, Response> call_body_in(const Request& request, std::initializer_list<std::string_view> keys) {
    auto body = object_in(request);
    if (const auto* wrong = std::get_if<std::string>(&body)) return http::error(400, *wrong);
    CallBody call{std::get<Json>(std::move(body)), {}, {}};
    if (const std::string wrong = stranger_in(call.json, keys); !wrong.empty()) return http::error(400, wrong);
    const auto repeat = flag_in(call.json, "repeat");
    call.values = call.json.value("values", Json::array());
    if (!call.values.is_array()) return http::error(400, "'values' must be an array");
    if (!repeat) return http::error(400, "'repeat' must be true or false");
    call.order.repeat = *repeat;
    call.order.seven = value_type_7_in(call.json.value("type7", Json{}));
    if (call.json.contains("type7") && !call.order.seven) return http::error(400, "'type7' must be f32 or u64");
    return call;
}

Response call(DeviceService& service, const Request& request) {
    auto body = call_body_in(request, {"values", "repeat", "name", "type7"});
    if (auto* wrong = std::get_if<Response>(&body)) return std::move(*wrong);
    auto& [json, values, order] = std::get<CallBody>(body);
    if (json.contains("name") && !json["name"].is_string()) return http::error(400, "'name' must be text");
    order.command = request.parameter("command");
    if (json.contains("name")) order.called = json["name"].get<std::string>();
    return begin(service, request, {JobKind::command, Operation::write, [order = order, values = values](const WorkPlace& place) {
                                        return call_command(place, order, values);
                                    }});
}

std::optional<Cid> cid_in(const Json& json) {
    const auto is_byte = [](const Json& one) { return one.is_number_unsigned() && one.get<std::uint64_t>() <= 0xFF; };
    if (!json.is_array() || json.size() != 3 || !std::all_of(json.begin(), json.end(), is_byte)) return std::nullopt;
    return Cid{json[0].get<std::uint8_t>(), json[1].get<std::uint8_t>(), json[2].get<std::uint8_t>()};
}

Response call_the_cid(DeviceService& service, const Request& request) {
    auto body = call_body_in(request, {"cid", "values", "repeat", "type7"});
    if (auto* wrong = std::get_if<Response>(&body)) return std::move(*wrong);
    const auto& [json, values, order] = std::get<CallBody>(body);
    const auto cid = cid_in(json.value("cid", Json{}));
    if (!cid) return http::error(400, "'cid' must be an array of three bytes, as in [16, 0, 5]");
    if (constexpr std::size_t max_values = 8; values.size() > max_values)
        return http::error(422, "a command has at most 8 values");
    JobRequest job{JobKind::command, Operation::write, [cid = *cid, values = values, order = order](const WorkPlace& place) {
                       return call_by_cid(place, cid, order, values);
                   }};
    job.is_first_frame = true;
    return begin(service, request, std::move(job));
}

void add_command_routes(http::Routes& routes, DeviceService& service) {
    routes.add({"POST", "/devices/{device}/actions", Access::control,
                "{\"action\": \"save\"} or \"restore_defaults\" (not in flight, except with ?force)",
                [&service](const Request& request) { return act(service, request); }});
    routes.add({"GET", "/devices/{device}/commands", Access::view,
                "the commands of a device; with ?known as last read; with ?to_act, before "
                "a call, read-only clients do not take its place",
                [&service](const Request& request) {
                    const bool known = request.query_value("known").has_value();
                    return begin(service, request, {JobKind::commands, Operation::read, [known](const WorkPlace& place) {
                                                        return read_commands(place, known);
                                                    }});
                },
                0, true});
    routes.add({"POST", "/devices/{device}/commands/by-cid", Access::control,
                "calls a command by its three bytes, {\"cid\": [16, 0, 5], \"values\": [{\"u16\": 150}]}; nothing is read "
                "from the device first",
                [&service](const Request& request) { return call_the_cid(service, request); }});
    routes.add(
        {"POST", "/devices/{device}/commands/{command}", Access::control,
         "calls a command, {\"values\": [...]}, once; with \"repeat\": true until acknowledged; with \"name\" only if "
         "it has this name; \"type7\": \"f32\" or \"u64\" states once what value type 7 means for a device that does not show it",
         [&service](const Request& request) { return call(service, request); }});
}

std::variant<WaypointForm, Response> form_of(const Request& request) {
    const std::string_view name = request.query_value("format").value_or("");
    if (const auto form = waypoint_form(name)) return *form;
    return http::error(400, "'format' must be json, geojson or qgc, not " + ano::in_quotes(name));
}

Response get_waypoints(DeviceService& service, const Request& request) {
    auto form = form_of(request);
    if (auto* wrong = std::get_if<Response>(&form)) return std::move(*wrong);
    return begin(service, request,
                 {JobKind::waypoints, Operation::read,
                  [form = std::get<WaypointForm>(form)](const WorkPlace& place) { return read_waypoints(place, form); }});
}

Response put_waypoints(DeviceService& service, const Request& request) {
    auto form = form_of(request);
    if (auto* wrong = std::get_if<Response>(&form)) return std::move(*wrong);
    const auto body = object_in(request);
    if (const auto* wrong = std::get_if<std::string>(&body)) return http::error(400, *wrong);
    auto waypoints = waypoints_in(std::get<Json>(body), std::get<WaypointForm>(form));
    if (const auto* wrong = std::get_if<std::string>(&waypoints)) return http::error(422, *wrong);
    return begin(service, request,
                 {JobKind::put_waypoints, Operation::write,
                  [all = std::get<std::vector<ano::host::Waypoint>>(std::move(waypoints))](const WorkPlace& place) {
                      return write_waypoints(place, all);
                  }});
}

void add_waypoint_routes(http::Routes& routes, DeviceService& service) {
    routes.add({"GET", "/devices/{device}/waypoints", Access::view,
                "the waypoints of a device (format=geojson, or qgc: a QGroundControl plan)",
                [&service](const Request& request) { return get_waypoints(service, request); }, 0, true});
    routes.add({"PUT", "/devices/{device}/waypoints", Access::control, "writes waypoints in the same formats and reads each back",
                [&service](const Request& request) { return put_waypoints(service, request); }});
}

// The bytes of the body, which may be in memory or on disk.
ano::host::FirmwareBytes bytes_of(const Request& request) {
    if (request.stored)
        return {request.stored->size(),
                [stored = request.stored](std::size_t at, std::span<std::uint8_t> into) { return stored->read(at, into); }};
    return std::vector<std::uint8_t>{request.body.begin(), request.body.end()};
}

bool has_plain_bytes(const Request& request) {
    std::string_view type = request.header("Content-Type");
    type = type.substr(0, type.find(';'));
    while (type.ends_with(' ') || type.ends_with('\t')) type.remove_suffix(1);
    return ano::lower_case(type) == "application/octet-stream";
}

Response flash(DeviceService& service, const Request& request) {
    if (!has_plain_bytes(request))    // the boundaries of a form would be flashed too
        return http::error(415, "send firmware with Content-Type: application/octet-stream (curl --data-binary @FILE, not -F)");
    const std::string_view name = request.query_value("crc").value_or(ano::usual_crc16.name);
    const auto crc = ano::find_crc16(name);
    if (!crc) return http::error(400, "unknown CRC " + ano::in_quotes(name));
    const bool force = request.query_value("force").has_value();
    const auto work = [&service, file = bytes_of(request), crc, force](const WorkPlace& place) {
        return upgrade(place, {file, *crc, force, service.info(place.device.address())});
    };
    return begin(service, request, {JobKind::firmware, Operation::ground, work, true});
}

Response calibration(DeviceService& service, const Request& request) {
    const auto body = object_in(request);
    if (const auto* wrong = std::get_if<std::string>(&body)) return http::error(400, *wrong);
    const Json& json = std::get<Json>(body);
    const Json what = json.value("what", Json{});
    const bool is_compass = what == "compass";
    if (json.size() != 1 || (!is_compass && what != "accelerometer"))
        return http::error(400, R"(the body must be {"what": "accelerometer"} or {"what": "compass"})");
    const auto sensor = is_compass ? ano::host::Sensor::compass : ano::host::Sensor::accelerometer;
    const auto work = [sensor](const WorkPlace& place) { return calibrate(place, sensor); };
    return begin(service, request, {JobKind::calibration, Operation::ground, work, true});
}

void add_long_routes(http::Routes& routes, DeviceService& service) {
    routes.add({"POST", "/devices/{device}/firmware", Access::control,
                "upgrades the firmware, a .bin or .bia as a body of application/octet-stream: a job (force: even in flight, or "
                "if the file is for "
                "other hardware or does not look like firmware; crc=NAME)",
                [&service](const Request& request) { return flash(service, request); }, max_firmware});
    routes.add({"POST", "/devices/{device}/calibration", Access::control,
                "calibrates the \"accelerometer\" or the \"compass\", {\"what\": ...}: a job that waits once to be continued",
                [&service](const Request& request) { return calibration(service, request); }});
}

}    // namespace

void add_device_routes(http::Routes& routes, DeviceService& service) {
    routes.add({"GET", "/devices", Access::view, "the known devices and their device information",
                [&service](const Request&) { return json_response(devices_list(service)); }});
    routes.add_without_body({"POST", "/devices/scan", Access::control, "scans for devices and lists the known ones",
                             [&service](const Request& request) { return scan_answer(service, request); }});
    add_watch_routes(routes, service);
    add_parameter_routes(routes, service);
    add_command_routes(routes, service);
    add_waypoint_routes(routes, service);
    add_long_routes(routes, service);
    add_job_routes(routes, service);
}

}    // namespace anogate
