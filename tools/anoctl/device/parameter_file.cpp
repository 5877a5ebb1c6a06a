#include "parameter_file.hpp"
#include "job_text.hpp"

#include <ano_json/syntax_fault.hpp>
#include <ano_json/text.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/json_file.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>

namespace anoctl {

using ano::Json;

namespace {

void add_name(std::string& names, const std::string& name) { names += (names.empty() ? "" : ", ") + name; }

// In files of older versions, U+FFFD replaces bytes that were not UTF-8.
bool is_lost(const Json& value) {
    return value.is_null() ||
           (value.is_string() && value.get_ref<const std::string&>().find("\xEF\xBF\xBD") != std::string::npos);
}

// "NAME#3" with the number if the name alone is ambiguous: it is empty, or several parameters have it.
std::string name_in_file(const Json& row, const Json& rows) {
    const std::string name = row.value("name", std::string{});
    const auto is_alike = [&](const Json& other) { return other.value("name", std::string{}) == name; };
    const bool is_clear = !name.empty() && std::count_if(rows.begin(), rows.end(), is_alike) == 1;
    return is_clear ? name : name + '#' + text_at(row, "id");
}

bool is_real(const Json& row) { return text_at(row, "type") == "f32" || text_at(row, "type") == "f64"; }

}    // namespace

std::string value_text(const Json& value) {
    if (value.is_null()) return "-";
    if (value == "inf" || value == "-inf" || value == "nan") return value.get<std::string>();
    if (value.is_string()) return ano::in_quotes(value.get<std::string>(), '"');
    if (value.is_number_float()) return ano::number_text(value.get<double>());
    return value.dump();
}

std::string plain_at(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end()) return {};
    return found->is_string() ? without_controls(found->get<std::string>()) : value_text(*found);
}

Json parameter_file(const Json& answer) {
    const Json& device = at(answer, "device");
    Json file{{"device", text_at(device, "address")}};
    for (const char* key : {"name", "dev_id", "hw", "sw"})
        if (device.contains(key)) file[key] = device[key];
    Json values = Json::object();
    std::string missing, twice;
    const Json& rows = at(answer, "parameters");
    for (const Json& row : rows) {
        const std::string name = name_in_file(row, rows);
        if (row.contains("unreadable")) continue;
        if (!row.contains("value") || row.contains("missing")) add_name(missing, name);
        else if (values.contains(name)) add_name(twice, name);
        else values[name] = is_real(row) && row["value"].is_string() ? Json(nullptr) : row["value"];
    }
    if (!missing.empty()) throw Failure{"nothing was exported; these parameters were not received: " + missing};
    if (!twice.empty()) throw Failure{"nothing was exported; several parameters are named " + twice};
    file["parameters"] = std::move(values);
    return file;
}

Json parsed_parameter_file(const std::string& text, const std::string& path) {
    Json file = json_in_text(text, path);
    if (file.is_object() && !file.contains("parameters")) file = Json{{"parameters", file}};
    if (!file.is_object() || !file["parameters"].is_object())
        throw UsageError{path + ": not a parameter file; expected {\"parameters\": {NAME: value}}"};
    if (file["parameters"].empty()) throw UsageError{path + ": the file contains no parameters"};
    if (const Json whose = file.value("device", Json{}); whose.is_object())
        for (const auto& [key, value] : whose.items()) file[key == "address" ? "device" : key] = value;
    for (const auto& [name, value] : file["parameters"].items())
        if (value.is_structured())
            throw UsageError{path + ": the value of " + ano::in_quotes(name) + " is neither a number nor a text"};
    return file;
}

std::string of_another_device(const Json& file, const Json& device) {
    std::string words;
    for (const char* key : {"name", "dev_id"}) {
        const std::string here = text_at(device, key), there = text_at(file, key);
        if (there.empty() || here.empty() || there == here) continue;
        words += words.empty() ? "the file is for " : ", ";
        words += std::string{key} == "name" ? there : "device type " + there;
    }
    return words.empty()
               ? words
               : words + ", but the device is " + text_at(device, "name") + ", device type " + text_at(device, "dev_id");
}

bool is_calibration(std::string_view name) noexcept { return name.starts_with("CAL_"); }

Json wanted_values(const Json& file, bool with_calibration, std::size_t& left_out) {
    Json wanted = Json::object();
    left_out = 0;
    for (const auto& [name, value] : file["parameters"].items()) {
        if (!with_calibration && is_calibration(name)) ++left_out;
        else if (!is_lost(value)) wanted[name] = value;
    }
    return wanted;
}

std::string names_not_readable(const Json& rows) {
    std::string names;
    for (const Json& row : rows)
        if (row.contains("unreadable")) add_name(names, name_in_file(row, rows) + " (" + text_at(row, "unreadable") + ")");
    return names;
}

std::string names_without_value(const Json& file) {
    std::string names;
    for (const auto& [name, value] : file["parameters"].items())
        if (is_lost(value)) add_name(names, name);
    return names;
}

bool is_kept_by_calibration(const std::string& path) {
    const std::string name = path.substr(path.find_last_of('/') + 1);
    return name.starts_with("calibration-0x") && (name.ends_with("-accelerometer.json") || name.ends_with("-compass.json"));
}

std::string misfit_line(const Json& row) {
    const std::string name = text_at(row, "name"), what = text_at(row, "what");
    const std::string words = what.find(name) == std::string::npos ? name + ": " + what : what;
    return without_controls(with_options_named(words, "param"));
}

std::vector<std::string> difference_lines(const Json& answer) {
    std::vector<std::string> lines;
    for (const Json& row : at(answer, "parameters")) {
        const std::string state = text_at(row, "state"), what = text_at(row, "what");
        if (state == "unchanged") continue;
        const bool is_stored = row.contains("stored") && (state == "written" || state == "clamped" || state == "not_undone");
        std::string line = text_at(row, "name") + ": ";
        if (row.contains("was")) line += value_text(row["was"]) + " -> ";
        line += value_text(row[is_stored ? "stored" : "written"]);
        if (state == "clamped") line += ", limited by the device: " + value_text(row["written"]) + " was requested";
        else if (state == "not_undone") line += ", not restored";
        else if (state == "waiting") line += ", not attempted";
        else if (state != "differs" && state != "written") line += ", " + state;
        if (!what.empty()) line += ": " + with_options_named(what, "param");
        lines.push_back(without_controls(line));
    }
    return lines;
}

std::size_t rows_with(const Json& answer, std::string_view state) {
    const Json& rows = at(answer, "parameters");
    return static_cast<std::size_t>(
        std::count_if(rows.begin(), rows.end(), [&](const Json& row) { return text_at(row, "state") == state; }));
}

}    // namespace anoctl
