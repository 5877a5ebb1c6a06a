#include "gateway_json.hpp"

#include <anoctl/anoctl.hpp>
#include "table.hpp"

#include <ano/messages.hpp>
#include <gateway/counters.hpp>
#include <gateway/v7_translation.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <initializer_list>
#include <iterator>
#include <string>

namespace anoctl {
namespace {

using ano::Json;

constexpr std::size_t line_width = 80;

template <class Rows, class Wanted>
std::vector<std::string> counter_names(const Rows& rows, Wanted is_wanted) {
    std::vector<std::string> names;
    for (const auto& row : rows)
        if (is_wanted(row)) names.emplace_back(row.name);
    return names;
}

}    // namespace

Json parse_answer(const std::string& body) {
    Json json = Json::parse(body, nullptr, false);
    if (json.is_discarded()) throw Failure{"the response of the gateway is not valid JSON"};
    return json;
}

std::string text_at(const Json& object, std::string_view key) {
    if (!object.is_object()) return {};
    const auto found = object.find(std::string{key});
    if (found == object.end() || found->is_null()) return {};
    return without_controls(found->is_string() ? found->get<std::string>() : found->dump());
}

double number_at(const Json& object, std::string_view key) {
    const std::string text = text_at(object, key);
    return std::strtod(text.c_str(), nullptr);
}

const Json& at(const Json& object, std::string_view key) {
    static const Json nothing = Json::array();
    if (!object.is_object()) return nothing;
    const auto found = object.find(std::string{key});
    return found == object.end() || !found->is_structured() ? nothing : *found;
}

std::string listening_place(const Json& link) {
    return link.contains("port") && !link.contains("peer") ? text_at(link, "address") : std::string{};
}

std::string PrintedHints::once(std::string_view key, const std::string& text) {
    return key == "hint" && !text.empty() && !hints_.insert(text).second ? std::string{} : text;
}

RecordingSum sum_of_recording(const Json& recording) {
    const std::string file = text_at(recording, "file"), files = text_at(recording, "files"),
                      count = text_at(recording, "frames");
    const std::string frames = count + (count == "1" ? " frame" : " frames");
    if (number_at(recording, "files") > 1) return {text_at(recording, "name"), frames + " in " + files + " files"};
    return {file.empty() ? text_at(recording, "name") : file, frames};
}

std::vector<std::string> recording_lines(const Json& recording) {
    std::vector<std::string> lines;
    for (const Json& one : at(recording, "running")) {
        const RecordingSum sum = sum_of_recording(one);
        const std::string error = text_at(one, "error");
        std::string line = "recording: " + sum.of + ": " + (error.empty() ? sum.frames : error);
        if (number_at(one, "not_written") > 0) line += "; not written: " + text_at(one, "not_written");
        lines.push_back(std::move(line));
    }
    if (const std::string error = text_at(at(recording, "keep_last"), "error"); !error.empty())
        lines.push_back("recording: cannot save the latest frames: " + error);
    return lines;
}

std::optional<double> length_of_recording(const Json& file) {
    if (file.contains("seconds"))
        return text_at(file, "seconds").empty() ? std::nullopt : std::optional{number_at(file, "seconds")};
    constexpr double year_2020 = 1'577'836'800, max_length = 366.0 * 24 * 3600;
    const double begun = number_at(file, "begun"), length = number_at(file, "time") - begun;
    if (begun < year_2020 || length < 0 || length > max_length) return std::nullopt;
    return length;
}

std::string names_at(const Json& object, std::string_view key) {
    std::string all;
    for (const Json& name : at(object, key))
        if (name.is_string()) all += (all.empty() ? "" : ", ") + without_controls(name.get<std::string>());
    return all;
}

std::vector<std::string> not_zero(const Json& object, const std::vector<std::string>& names) {
    std::vector<std::string> items;
    for (const std::string& name : names)
        if (const std::string value = text_at(object, name); !value.empty() && value != "0") items.push_back(name + " " + value);
    return items;
}

std::string lost_text(const Json& lost) {
    const std::string state = text_at(lost, "sflag"), elsewhere = text_at(lost, "elsewhere");
    const auto& states = ano::table::sflags;
    const auto known = std::find_if(std::begin(states), std::end(states),
                                    [&](const auto& one) { return std::to_string(one.value) == state; });
    const std::string age = time_text(number_at(lost, "age"));
    return (known == std::end(states) ? "silent for " + age : std::string{known->text} + " " + age + " ago") +
           (elsewhere.empty() ? "" : ", now received on " + elsewhere);
}

bool may_fly(const Json& lost) { return number_at(lost, "sflag") > 0; }

std::string list_text(const std::string& head, const std::vector<std::string>& items) {
    std::string text = head;
    std::size_t width = cells_of(head);
    for (std::size_t i = 0; i < items.size(); ++i) {
        const std::string item = items[i] + (i + 1 < items.size() ? "," : "");
        const bool begins = i == 0;
        if (!begins && width + 1 + cells_of(item) > line_width) {
            text += "\n" + std::string(cells_of(head), ' ');
            width = cells_of(head);
        } else if (!begins) {
            text += ' ';
            ++width;
        }
        text += item;
        width += cells_of(item);
    }
    return text;
}

const std::vector<std::string>& drop_causes(bool is_alone) {
    const auto names = [](bool without_no_route) {
        const auto is_drop = [&](const auto& row) {
            return row.counts != anogate::Counts::traffic && !(without_no_route && row.name == "no_route");
        };
        std::vector<std::string> all = counter_names(anogate::send_counters, is_drop);
        const std::vector<std::string> received = counter_names(anogate::receive_counters, is_drop);
        all.insert(all.end(), received.begin(), received.end());
        return all;
    };
    static const auto alone = names(true), beside_others = names(false);
    return is_alone ? alone : beside_others;
}
const std::vector<std::string>& counts_of_kinds() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all{"refused",          "kernel_drops",       "bad_reports",
                                     "failed_reports",   "transfer_errors",    "wrong_source",
                                     "error_frames",     "errors_tx_timeout",  "errors_lost_arbitration",
                                     "errors_protocol",  "errors_transceiver", "errors_no_ack",
                                     "errors_bus",       "kept_back_of_hosts", "kept_back_commands",
                                     "kept_back_tunnels"};
        const auto v7 = counter_names(anogate::v7_counters, [](const auto& row) { return row.is_drop; });
        all.insert(all.end(), v7.begin(), v7.end());
        return all;
    }();
    return names;
}
const std::vector<std::string>& causes_in() {
    static const auto names = counter_names(anogate::receive_counters, [](const auto& row) { return row.name != "frames_in"; });
    return names;
}
const std::vector<std::string>& causes_out() {
    static const auto names = counter_names(anogate::send_counters, [](const auto& row) { return row.name != "frames_out"; });
    return names;
}

}    // namespace anoctl
