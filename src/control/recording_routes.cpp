#include <ano_json/nearest.hpp>
#include <ano_json/strict_json.hpp>
#include <ano_json/text.hpp>
#include <control/recording_routes.hpp>
#include <http/routes.hpp>
#include <recording/recordings.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using http::Access;
using http::Request;

constexpr std::string_view filters[] = {"from", "to", "id", "link", "direction"};
constexpr double max_seconds = 30.0 * 24 * 3600;
constexpr const char* only_in_mcap = "message_encoding is only for MCAP: use format mcap";

struct WantedRecording {
    AskedRecording recording;
    bool is_last = false;
    WantedForm form;
};
using Fault = std::string;

std::optional<RecordingFormat> format_called(std::string_view name) {
    for (const RecordingFormat format : {RecordingFormat::pcapng, RecordingFormat::mcap})
        if (name == text(format)) return format;
    return std::nullopt;
}

Fault is_no_format(std::string_view word) {
    constexpr std::string_view formats[] = {"pcapng", "mcap"};
    return "format " + ano::in_quotes(word) + " is neither pcapng nor mcap" + ano::did_you_mean(word, formats);
}

Fault is_no_encoding(std::string_view word) { return "message_encoding " + ano::in_quotes(word) + " is neither cdr nor json"; }

/// The value of a filter, from a text, a number, or a list of them.
std::optional<std::string> parse_words(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    if (value.is_number_unsigned()) return value.dump();
    if (!value.is_array()) return std::nullopt;
    std::string words;
    for (const Json& word : value) {
        if (!word.is_string() && !word.is_number_unsigned()) return std::nullopt;
        words += (words.empty() ? "" : ",") + (word.is_string() ? word.get<std::string>() : word.dump());
    }
    return words;
}

// The body of POST /recordings.
class BodyReader {
public:
    Fault read(const std::string& name, const Json& value) {
        if (name == "name") return read_name(value);
        if (name == "format") return read_format(value);
        if (name == "message_encoding") return read_encoding(value);
        if (name == "seconds") return read_seconds(value);
        if (name == "last") return read_last(value);
        if (name == "limit") return read_limit(value);
        if (std::find(std::begin(filters), std::end(filters), name) != std::end(filters)) return read_filter(name, value);
        constexpr std::string_view names[] = {"name", "format", "message_encoding", "seconds", "last", "limit", "from", "to",
                                              "id",   "link",   "direction"};
        return "unknown word " + ano::in_quotes(name) + ano::did_you_mean(name, names);
    }
    /// To be called when all members are read. `links`: the names of all links.
    Fault finish(std::span<const std::string_view> links) {
        if (wanted.is_last && (has_time_ || !fields_.empty()))
            return "keep_last is saved as it is: filters and seconds are not allowed";
        if (const auto end = recording_format_of(wanted.recording.name)) {    // "flight.pcapng"
            if (wanted.form.format && *wanted.form.format != *end)
                return "the file extension means " + std::string{text(*end)} + ", the format " +
                       std::string{text(*wanted.form.format)};
            wanted.form.format = *end;
            std::string& name = wanted.recording.name;
            name.resize(name.size() - text(*end).size() - 1);
            if (name.empty()) name = ".";    // no name is left: the check of names refuses "."
        }
        if (!has_direction_) fields_.push_back({"direction", "in"});
        auto parsed = parse_frame_query(fields_, links);
        if (auto* fault = std::get_if<std::string>(&parsed)) return *fault;
        wanted.recording.filter = std::move(std::get<FrameQuery>(parsed).filter);
        return {};
    }

    WantedRecording wanted;

private:
    Fault read_name(const Json& value) {
        if (!value.is_string()) return "\"name\" must be text";
        wanted.recording.name = value.get<std::string>();
        return wanted.recording.name.empty() ? "\"name\" is empty: omit it to use the time" : "";
    }
    Fault read_format(const Json& value) {
        if (!value.is_string()) return "\"format\" must be text";
        const auto& word = value.get_ref<const std::string&>();
        wanted.form.format = format_called(word);
        return wanted.form.format ? Fault{} : is_no_format(word);
    }
    Fault read_encoding(const Json& value) {
        if (!value.is_string()) return "\"message_encoding\" must be text";
        const auto& word = value.get_ref<const std::string&>();
        wanted.form.encoding = decoded_encoding_called(word);
        return wanted.form.encoding ? Fault{} : is_no_encoding(word);
    }
    Fault read_seconds(const Json& value) {
        const double seconds = value.is_number() ? value.get<double>() : 0;
        if (!(seconds > 0 && seconds <= max_seconds)) return "\"seconds\" must be a number above 0 and at most 30 days";
        wanted.recording.time = std::chrono::duration_cast<ano::Duration>(std::chrono::duration<double>{seconds});
        has_time_ = true;
        return {};
    }
    Fault read_last(const Json& value) {
        if (!value.is_boolean()) return "\"last\" must be true or false";
        wanted.is_last = value.get<bool>();
        return {};
    }
    Fault read_limit(const Json& value) {
        if (!value.is_object()) return "\"limit\" must be an object such as {\"euler\": 10}: frames per second";
        for (const auto& [message, rate] : value.items()) {
            if (!rate.is_number()) return "\"limit\" of " + ano::in_quotes(message) + " must be a number of frames per second";
            fields_.push_back({"limit." + message, rate.dump()});
        }
        return {};
    }
    Fault read_filter(const std::string& name, const Json& value) {
        const auto words = parse_words(value);
        if (!words) return "\"" + name + "\" must be text or a list of texts";
        has_direction_ = has_direction_ || name == "direction";
        fields_.push_back({name, *words});
        return {};
    }

    std::vector<http::Field> fields_;
    bool has_direction_ = false, has_time_ = false;
};

std::variant<WantedRecording, Fault> read_body(const Request& request, const Gateway& gateway) {
    BodyReader reader;
    Json body = Json::object();
    if (!request.body.empty()) {
        auto parsed = ano::json_body(request.body);
        if (const auto* wrong = std::get_if<std::string>(&parsed)) return *wrong;
        body = std::get<Json>(std::move(parsed));
    }
    if (!body.is_object()) return Fault{"the body must be a JSON object such as {\"name\": \"flight\"}"};
    for (const auto& [name, value] : body.items())
        if (Fault fault = reader.read(name, value); !fault.empty()) return fault;
    std::vector<std::string_view> links{"control"};    // it may be created later
    for (const LinkState& state : gateway.links()) links.push_back(state.link->name());
    if (Fault fault = reader.finish(links); !fault.empty()) return fault;
    return std::move(reader.wanted);
}

http::Response begin(Recordings& recordings, const Request& request) {
    auto read = read_body(request, recordings.gateway());
    if (const auto* fault = std::get_if<Fault>(&read)) return http::error(422, *fault);
    WantedRecording& wanted = std::get<WantedRecording>(read);
    wanted.recording.format = recordings.format_for(wanted.form);
    wanted.recording.options = recordings.options_for(wanted.form);
    if (wanted.form.encoding && wanted.recording.format != RecordingFormat::mcap) return http::error(422, only_in_mcap);
    if (wanted.is_last) return recordings.save_last(std::move(wanted.recording.name), wanted.form);
    return recordings.begin(std::move(wanted.recording));
}

http::Response last(Recordings& recordings, const Request& request) {
    WantedForm wanted;
    for (const http::Field& field : request.query) {
        if (field.name == "format") {
            wanted.format = format_called(field.value);
            if (!wanted.format) return http::error(400, is_no_format(field.value));
        } else if (field.name == "message_encoding") {
            wanted.encoding = decoded_encoding_called(field.value);
            if (!wanted.encoding) return http::error(400, is_no_encoding(field.value));
        } else {
            return http::error(
                400, "unknown word " + ano::in_quotes(field.name) + " in the query: there are format and message_encoding");
        }
    }
    if (wanted.encoding && recordings.format_for(wanted) != RecordingFormat::mcap) return http::error(400, only_in_mcap);
    return recordings.last(wanted);
}

}    // namespace

void add_recording_routes(http::Routes& routes, Recordings& recordings) {
    const auto name_in = [](const Request& request) { return std::string{request.parameter("name")}; };
    routes.add({"GET", "/recordings", Access::view,
                "the recordings: those in progress, those in the folder, the free disk space, and the frames in keep_last",
                [&recordings](const Request&) { return recordings.list(); }});
    routes.add({"POST", "/recordings", Access::control,
                "starts a recording {\"name\", \"format\", \"message_encoding\", \"seconds\", and the filters of GET /frames}, "
                "of received frames unless "
                "\"direction\" "
                "says otherwise; at most four at once besides that of the configuration; {\"last\": true, \"name\"} saves "
                "the frames in keep_last",
                [&recordings](const Request& request) { return begin(recordings, request); }});
    routes.add(
        {"GET", "/recordings/last", Access::view,
         "the frames in keep_last, as a file, for two clients at once; format=pcapng or mcap, message_encoding=cdr or json",
         [&recordings](const Request& request) { return last(recordings, request); }});
    routes.add({"GET", "/recordings/{name}", Access::view, "a recording, complete or a range of it",
                [&recordings, name_in](const Request& request) { return recordings.file(request, name_in(request)); }});
    routes.add_without_body({"POST", "/recordings/{name}/end", Access::control,
                             "stops a recording in progress and returns its result",
                             [&recordings, name_in](const Request& request) { return recordings.end(name_in(request)); }});
    routes.add_without_body({"DELETE", "/recordings/{name}", Access::control,
                             "deletes a finished recording that the gateway wrote; other files are left alone",
                             [&recordings, name_in](const Request& request) { return recordings.remove(name_in(request)); }});
}

}    // namespace anogate
