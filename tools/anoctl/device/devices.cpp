// anoctl devices: lists devices and their jobs, and cancels jobs.
#include "device_client.hpp"
#include "device_names.hpp"
#include "job_text.hpp"

#include <ano_json/escapes.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>

#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <variant>

namespace anoctl {
namespace {

using ano::Json;

std::string age_of(const Json& device) { return device.contains("age") ? time_text(number_at(device, "age")) : std::string{}; }

std::string percent_of(const Json& job) {
    if (!job.contains("progress")) return {};
    return ano::number_text(std::floor(std::clamp(number_at(job, "progress"), 0.0, 1.0) * 100)) + " %";
}

bool has_ended(const Json& job) { return text_at(job, "state") != "running" && text_at(job, "state") != "waiting"; }

// Marks those that are lost. One that no link leads to any more is added.
Json with_losses(const Json& list) {
    Json devices = at(list, "devices");
    for (const Json& lost : at(list, "lost")) {
        const auto of = std::find_if(devices.begin(), devices.end(),
                                     [&](const Json& one) { return text_at(one, "address") == text_at(lost, "address"); });
        Json& device = of == devices.end() ? devices.emplace_back(Json::object()) : *of;
        device["lost"] = true;
        device.update(lost);
    }
    return devices;
}

struct Devices {
    DeviceOptions options;
    bool scan = false, jobs = false;
    std::optional<unsigned> job;    // the job to cancel

    int run(Streams& streams) const {
        DeviceClient client{options, streams};
        if (job) return cancel(client, streams);
        return jobs ? list_jobs(client, streams) : list_devices(client, streams);
    }

private:
    int list_devices(DeviceClient& client, Streams& streams) const {
        const bool is_own_link = !options.link.empty();    // it has received nothing yet
        const Json found = with_losses(client.device_list(scan || is_own_link));
        if (options.json) {
            for (const Json& device : found) streams.out << ano::json_text(device) << '\n';
            return fine;
        }
        Table table{
            {"ADDRESS", "NAME", " HARDWARE", " SOFTWARE", " PROTOCOL", " PARAMETERS", "LINK", "PEER", " HEARD", " RATE", " JOB"}};
        bool have_names = true;
        for (const Json& device : found) {
            const std::string rate = text_at(device, "rate"), name = text_at(device, "name"), link = text_at(device, "link");
            std::string peer = text_at(device, "peer");
            if (peer == link) peer.clear();    // a link with only one peer: the name is that of the link
            have_names = have_names && !name.empty();
            table.row({text_at(device, "address"), name, text_at(device, "hw"), text_at(device, "sw"), text_at(device, "pt"),
                       text_at(device, "parameters"), link, peer, age_of(device), rate.empty() ? rate : rate + "/s",
                       text_at(device, "job")});
            if (text_at(device, "lost") == "true") table.note("    lost: " + lost_text(device));
            for (const std::string& words : left_behind(device)) table.note("    " + words);
        }
        if (table.empty())
            print_note(streams, std::string{"no devices found"} + (scan ? "" : "; to search for devices, add --scan"));
        else table.write(streams.out, "", streams.terminal ? streams.width : 0);
        if (!have_names && !scan) print(streams, "(some names are not known yet; to request them, add --scan)");
        return fine;
    }

    int list_jobs(DeviceClient& client, Streams& streams) const {
        constexpr std::size_t max_ended = 10;    // ended jobs in the table
        const Json answer = client.ask("GET", "/jobs");
        const Json& all = at(answer, "jobs");
        auto ended = static_cast<std::size_t>(std::count_if(all.begin(), all.end(), has_ended));
        Table table{{" JOB", "DEVICE", "WHAT", "STATE", " DONE", "BY", "MESSAGE"}};
        for (const Json& one : all) {
            const bool is_old = has_ended(one) && ended-- > max_ended;
            if (options.json) streams.out << ano::json_text(one) << '\n';
            else if (!is_old)
                table.row({text_at(one, "id"), text_at(one, "device"), command_of_job(text_at(one, "kind")),
                           text_at(one, "state"), percent_of(one), text_at(one, "client"), text_at(one, "message")});
        }
        if (options.json) return fine;
        if (table.empty()) print_note(streams, "no current or recent jobs");
        else table.write(streams.out, "", streams.terminal ? streams.width : 0);
        return fine;
    }

    // A question is asked only for upgrades: after other jobs the device stays usable or the result says what was done, but a
    // device left in its loader does not work.
    static std::string question_before_cancelling(const Json& job) {
        if (has_ended(job) || text_at(job, "kind") != "firmware") return {};
        const std::string by = text_at(job, "client");
        return "Job " + text_at(job, "id") + (by.empty() ? by : " of " + by) + " is writing the firmware of " +
               text_at(job, "device") + " (" + percent_of(job) +
               "). If you cancel, the device stays in its loader and does not work until it is flashed again. Cancel it?";
    }

    int cancel(DeviceClient& client, Streams& streams) const {
        const std::string target = "/jobs/" + std::to_string(*job);
        const Json now = client.ask("GET", target);
        const std::string before = text_at(now, "state");
        if (const std::string question = question_before_cancelling(now); !question.empty()) {
            client.must_be_able_to_ask("cancelling a firmware update");
            if (!client.may(question)) {
                print_note(streams, "nothing was cancelled");
                return failed;
            }
        }
        const Json ended = client.ask("DELETE", target);
        if (options.json) {
            streams.out << ano::json_text(ended) << '\n';
            return fine;
        }
        const std::string state = text_at(ended, "state"), error = text_at(ended, "error"), by = text_at(ended, "client");
        std::string words = "job " + text_at(ended, "id") + " (" + command_of_job(text_at(ended, "kind")) +
                            (by.empty() ? by : " of " + by) + "): ";
        const bool is_cancelled = error.starts_with("cancelled");
        words += state == "cancelled" && before != state ? "cancelled" : "already ended: " + state;
        if (is_cancelled) words += error.substr(std::string_view{"cancelled"}.size());
        else if (!error.empty()) words += "; " + error;
        print(streams, words);
        return fine;
    }
};

}    // namespace

Run add_devices(Options& options) {
    const auto self = std::make_shared<Devices>();
    const auto read_job = [self](const std::string& word) -> std::string {
        const auto number = ano::parse_number(word);
        const auto* id = number ? std::get_if<std::uint64_t>(&*number) : nullptr;
        if (id == nullptr || *id > std::numeric_limits<unsigned>::max()) return ano::in_quotes(word) + " is not a job number";
        self->job = static_cast<unsigned>(*id);
        return {};
    };
    options.push_back(
        {"--scan", &self->scan, "", "Query all devices for their information; without it, list only devices already seen"});
    options.push_back({"--jobs",
                       &self->jobs,
                       "",
                       "List current and recent jobs on devices, with their clients and results",
                       false,
                       {"--scan"}});
    options.push_back({"--cancel",
                       Option::Read{read_job},
                       "JOB",
                       "Cancel this job from --jobs, of any client; asks for confirmation if it writes firmware",
                       false,
                       {"--scan", "--jobs"}});
    DeviceOptions::add_place(options, self->options, "devices");
    DeviceOptions::add_yes(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
