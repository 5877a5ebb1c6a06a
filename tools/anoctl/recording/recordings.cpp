// anoctl recordings: manages the recordings that the gateway makes itself.
#include <anoctl/anoctl.hpp>
#include <anoctl/counted.hpp>
#include <anoctl/gateway.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include "recording_output.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/lower_case.hpp>
#include <ano_json/text.hpp>
#include <http/client/client.hpp>
#include <record/recording_writer.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

namespace http = anogate::http;
using ano::Json;

constexpr std::size_t max_named = 3;                        // files of a recording, named in an error
constexpr std::uint64_t bytes_at_once = 8 * 1024 * 1024;    // bytes of a file per request

std::string size_of(double bytes) {
    constexpr const char* units[] = {"B", "kB", "MB", "GB", "TB"};
    std::size_t unit = 0;
    while (bytes >= 999.5 && unit + 1 < std::size(units)) {
        bytes /= 1000;
        ++unit;
    }
    const double shown = unit == 0 || bytes >= 100 ? std::round(bytes) : std::round(bytes * 10) / 10;
    std::string text = std::to_string(shown);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.ends_with('.')) text.pop_back();
    return text + " " + units[unit];
}

/// "flight.pcapng" and "flight-2.pcapng" belong to "flight".
bool is_file_of(std::string_view name, std::string_view file) {
    if (!file.starts_with(name)) return false;
    std::string_view rest = file.substr(name.size());
    rest = rest.substr(0, rest.rfind('.'));
    if (rest.empty()) return file.size() > name.size();
    return rest.size() > 1 && rest.front() == '-' && rest.find_first_not_of("0123456789", 1) == rest.npos;
}

struct Recordings {
    std::string what = "list", name, file, format, encoding;
    std::vector<std::string> ids, from, to, links, directions;
    double seconds = 0;
    bool force = false, json = false;
    GatewayOptions gateway;

    int run(Streams& streams) const {
        if (what == "list") return list(streams);
        if (what == "start") return start(streams);
        if (what == "save") return save(streams);
        if (name.empty()) throw UsageError{"missing NAME: anoctl recordings " + what + " NAME; to list them: anoctl recordings"};
        if (what == "end") return end(streams);
        return what == "get" ? get(streams) : remove(streams);
    }

private:
    static std::string path_of(const std::string& of) { return "/recordings/" + percent_encoded(of); }

    /// Sends a request and returns the response. Throws Failure with the text of an error response.
    Json ask(const std::string& method, const std::string& target, const Json& body = nullptr) const {
        http::Request request;
        request.method = method;
        request.target = target;
        if (!body.is_null()) {
            request.headers.push_back({"Content-Type", "application/json"});
            request.body = body.dump();
        }
        http::Outcome outcome = http::ask(gateway.socket(), std::move(request));
        if (!outcome.fault.empty()) throw Failure{outcome.fault};
        if (outcome.answer.status / 100 != 2) throw Failure{format_failure(outcome.answer)};
        return parse_answer(outcome.answer.body);
    }

    int list(Streams& streams) const {
        const Json all = ask("GET", "/recordings");
        if (json) return streams.out << ano::json_text(all) << '\n', fine;
        Table table{{"NAME", "STATE", " SIZE", " FRAMES", " LENGTH", "NOTE"}};
        for (const Json& one : at(all, "running")) table.row(cells_of_running(one));
        for (const Json& one : at(all, "recordings"))
            if (!is_written_here(all, one)) table.row(cells_of_file(one));
        if (table.empty()) streams.out << "no recordings yet\n";
        else table.write(streams.out, {}, streams.terminal ? streams.width : 0);
        const std::string folder = text_at(all, "folder"), error = text_at(all, "error"), free = text_at(all, "free_bytes");
        if (!error.empty()) print(streams, error);
        else if (!free.empty()) print(streams, folder + ": " + size_of(number_at(all, "free_bytes")) + " free");
        if (const Json& kept = at(all, "keep_last"); kept.is_object())
            print(streams, "in memory: " + counted(static_cast<std::uint64_t>(number_at(kept, "frames")), "frame") +
                               " of the last " + time_text(number_at(kept, "held_s")) + ", " + size_of(number_at(kept, "bytes")));
        return fine;
    }
    // A file in state "recording" is written by the asked gateway (then `running` has it), or by another one that shares the folder.
    static bool is_written_here(const Json& all, const Json& file) {
        if (text_at(file, "state") != "recording") return false;
        const Json& running = at(all, "running");
        return std::any_of(running.begin(), running.end(), [name = text_at(file, "name")](const Json& one) {
            const std::string current = text_at(one, "file");
            return current.empty() ? is_file_of(text_at(one, "name"), name) : current == name;
        });
    }
    static Table::Line cells_of_running(const Json& one) {
        std::string note = text_at(one, "error");
        if (const auto missing = static_cast<std::uint64_t>(number_at(one, "not_written")); missing > 0)
            note += (note.empty() ? "" : "; ") + counted(missing, "frame") + " not written";
        const char* const state = note.empty() ? "recording" : "failing";
        if (number_at(one, "files") > 1) {
            const RecordingSum sum = sum_of_recording(one);
            note += (note.empty() ? "" : "; ") + sum.of + ": " + sum.frames;
        }
        const std::string file = text_at(one, "file");
        const bool has_file_details = one.contains("file_seconds");    // false for older gateways
        return {file.empty() ? text_at(one, "name") : file,
                state,
                size_of(number_at(one, "file_bytes")),
                text_at(one, "file_frames"),
                time_text(number_at(one, has_file_details ? "file_seconds" : "seconds")),
                note};
    }
    static Table::Line cells_of_file(const Json& one) {
        const std::optional<double> length = length_of_recording(one);
        return {text_at(one, "name"),
                text_at(one, "state"),
                size_of(number_at(one, "bytes")),
                text_at(one, "frames"),
                length ? time_text(*length) : "",
                text_at(one, "state") == "recording" ? "by another gateway" : ""};
    }

    int start(Streams& streams) const {
        check_ending();
        Json body = Json::object();
        if (!name.empty()) body["name"] = name;
        if (!format.empty()) body["format"] = format;
        if (!encoding.empty()) body["message_encoding"] = encoding;
        if (seconds > 0) body["seconds"] = seconds;
        const std::pair<const char*, const std::vector<std::string>*> filters[] = {
            {"id", &ids}, {"from", &from}, {"to", &to}, {"link", &links}, {"direction", &directions}};
        for (const auto& [key, words] : filters)
            if (!words->empty()) body[key] = *words;
        return print_one(ask("POST", "/recordings", body), "started", streams);
    }
    // With --format, the name may have any extension.
    void check_ending() const {
        if (format.empty() && name.rfind('.') != name.npos && !anogate::recording_format_of(name))
            throw UsageError{ending_refused(name)};
    }
    int save(Streams& streams) const {
        check_ending();
        Json body{{"last", true}};
        if (!name.empty()) body["name"] = name;
        if (!format.empty()) body["format"] = format;
        if (!encoding.empty()) body["message_encoding"] = encoding;
        return print_one(ask("POST", "/recordings", body), "saved", streams);
    }
    int end(Streams& streams) const { return print_one(ask("POST", path_of(name) + "/end", Json::object()), "stopped", streams); }
    int remove(Streams& streams) const { return print_one(ask("DELETE", path_of(file_meant())), "deleted", streams); }

    /// NAME with the extension of its only file. Unchanged if there is none: the gateway then reports the error.
    std::string file_meant() const {
        if (anogate::recording_format_of(name)) return name;
        std::vector<std::string> files;
        const Json all = ask("GET", "/recordings");
        for (const Json& one : at(all, "recordings"))
            if (std::string of = text_at(one, "name"); is_file_of(name, of)) files.push_back(std::move(of));
        if (files.size() == 1) return files.front();
        if (files.empty()) return name;
        std::string some;
        for (std::size_t i = 0; i < std::min(files.size(), max_named); ++i) some += (i > 0 ? ", " : "") + files[i];
        throw UsageError{name + " has " + std::to_string(files.size()) + " files; give one of: " + some +
                         (files.size() > max_named ? ", …" : "")};
    }

    int print_one(const Json& answer, const char* became, Streams& streams) const {
        if (json) return streams.out << ano::json_text(answer) << '\n', fine;
        const RecordingSum sum = sum_of_recording(answer);
        const std::string error = text_at(answer, "error");
        std::string text = sum.of + " " + became;
        if (number_at(answer, "frames") > 0) text += ", " + sum.frames;
        print(streams, text + (error.empty() ? "" : "; " + error));
        return fine;
    }

    // Downloads the file in pieces, because it may be larger than memory, and checks that it is not replaced meanwhile.
    int get(Streams& streams) const {
        const std::string which = file_meant(), into = place_for(which);
        if (into == "-" && streams.terminal) throw UsageError{"recordings are binary and not written to a terminal; give a file"};
        std::unique_ptr<RecordingOutput> output;
        std::string tag;
        for (std::uint64_t at = 0, size = 1; at < size;) {
            const http::Answer part = piece_at(which, at, tag);
            if (part.status == 416) break;    // the file is empty
            if (part.status / 100 != 2) throw Failure{format_failure(part)};
            if (part.status != 206 && at > 0) throw Failure{which + " changed meanwhile; get it again"};
            const std::string_view range = part.header("Content-Range");
            const auto whole = ano::parse_number(range.substr(range.rfind('/') + 1));
            size = whole && std::holds_alternative<std::uint64_t>(*whole) ? std::get<std::uint64_t>(*whole)
                                                                          : at + part.body.size();
            tag = part.header("ETag");
            if (!output) output = std::make_unique<RecordingOutput>(into, force, streams);
            output->write(part.body);
            at += part.body.size();
            if (!output->fault().empty()) throw Failure{into + ": cannot write: " + output->fault()};
            if (part.body.empty()) break;
        }
        if (!output) output = std::make_unique<RecordingOutput>(into, force, streams);
        output->sync();
        if (into != "-") print_note(streams, into + ": " + counted(output->size(), "byte"));
        return fine;
    }
    /// The path of the output; FILE may be a folder, such as ".".
    std::string place_for(const std::string& which) const {
        std::string plain = which.substr(which.rfind('/') + 1);
        std::error_code none;
        if (file.empty()) return plain;
        if (std::filesystem::is_directory(file, none)) return std::filesystem::path{file} / plain;
        const std::string ending = ano::lower_case(std::filesystem::path{file}.extension().string());
        const bool is_other = ending == ".csv" || ending == ".ndjson" ||
                              (anogate::recording_format_of(file) &&
                               anogate::recording_format_of(file) != anogate::recording_format_of(which));
        if (is_other)
            throw UsageError{file + ": get copies " + plain + " unchanged; to get " + ending + ", use anoctl convert afterwards"};
        return file;
    }
    http::Answer piece_at(const std::string& which, std::uint64_t at, const std::string& tag) const {
        http::Request request;
        request.method = "GET";
        request.target = path_of(which);
        request.headers.push_back({"Range", "bytes=" + std::to_string(at) + "-" + std::to_string(at + bytes_at_once - 1)});
        if (!tag.empty()) request.headers.push_back({"If-Range", tag});
        http::Outcome outcome = http::ask(gateway.socket(), std::move(request));
        if (!outcome.fault.empty()) throw Failure{outcome.fault};
        return std::move(outcome.answer);
    }
};

}    // namespace

Run add_recordings(Options& options) {
    const auto self = std::make_shared<Recordings>();
    const auto read_what = [self](const std::string& word) -> std::string {
        constexpr std::string_view all[] = {"list", "start", "end", "get", "delete", "save"};
        if (std::find(std::begin(all), std::end(all), word) == std::end(all))
            return ano::in_quotes(word) + " is not list, start, end, get, delete or save";
        self->what = word;
        return {};
    };
    const auto read_seconds = [self](const std::string& word) -> std::string {
        const auto number = ano::parse_number(word);
        self->seconds = number ? std::visit([](auto n) { return static_cast<double>(n); }, *number) : 0;
        return self->seconds > 0 ? std::string{} : ano::in_quotes(word) + " is not a number of seconds";
    };
    options.push_back({"what", Option::Read{read_what}, "list|start|end|get|delete|save",
                       "list (default): running and stored recordings; start [NAME]; end NAME; get NAME [FILE]: download one; "
                       "delete NAME; save [NAME]: save the frames kept by keep_last"});
    options.push_back(
        {"name", &self->name, "NAME", "Name, of A-Z, a-z, 0-9, '.', '_' and '-' (default of a new recording: the time)"});
    options.push_back(
        {"file", &self->file, "FILE", "Output file or folder (get; default: NAME, in this folder); - writes standard output"});
    options.push_back({"--format", &self->format, "pcapng|mcap", "File format (start, save; default: as configured)"});
    options.push_back({"--message-encoding", &self->encoding, "cdr|json",
                       "Encoding of decoded messages in MCAP (start, save; default: as configured), cdr as in ROS 2, or json"});
    options.push_back({"--id", &self->ids, "ID...", "Record only these messages, by name or id (start)"});
    options.push_back({"--from", &self->from, "ADDRESS...", "Select only frames from these addresses"});
    options.push_back({"--to", &self->to, "ADDRESS...", "Select only frames to these addresses"});
    options.push_back({"--link", &self->links, "LINK...", "Record only frames on these links, by name (start)"});
    options.push_back(
        {"--direction", &self->directions, "in|out|dropped...", "Record received, sent or dropped frames (start; default: in)"});
    options.push_back({"--seconds", Option::Read{read_seconds}, "N", "Stop after this time (start)"});
    options.push_back({"--force", &self->force, "", "Overwrite an existing file (get)"});
    options.push_back({"--json", &self->json, "", "Print the response of the gateway as one JSON object"});
    GatewayOptions::add(options, self->gateway);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
