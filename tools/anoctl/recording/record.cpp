// anoctl record FILE: records the frames of the running gateway into a file.
#include <anoctl/anoctl.hpp>
#include <anoctl/counted.hpp>
#include <anoctl/gateway_layouts.hpp>
#include <anoctl/message_encoding.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include <anoctl/watch.hpp>
#include "recording_output.hpp"

#include <ano_json/escapes.hpp>
#include <ano_json/text.hpp>
#include <link/clocks.hpp>
#include <record/recording_writer.hpp>

#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using ano::Clock;

constexpr auto sync_time = std::chrono::seconds{1};    // a loss of power loses at most this
constexpr Clock::duration chunk_time = std::chrono::milliseconds{
    500};    // a kill loses at most this (MCAP); shorter chunks compress badly

anogate::RecordingHead head_now(anogate::DecodingPtr decoding) {
    const anogate::ClockReading clocks = anogate::read_clocks();
    return {"anoctl " ANOGATE_VERSION, static_cast<std::uint64_t>(std::chrono::nanoseconds{clocks.real}.count()),
            static_cast<std::uint64_t>(std::chrono::nanoseconds{clocks.boot}.count()), std::move(decoding)};
}

class Recorder final : public FrameReceiver {
public:
    using Descriptions = std::map<std::string, std::string>;

    /// `descriptions`: of each link, by name.
    Recorder(RecordingOutput& output, Descriptions descriptions, anogate::DecodingPtr decoding, anogate::RecordingFormat format,
             anogate::RecordingOptions options)
        : output_{output},
          descriptions_{std::move(descriptions)},
          decoding_{std::move(decoding)},
          writer_{anogate::make_recording_writer(format, head_now(decoding_), waiting_, options)},
          flush_time_{format == anogate::RecordingFormat::mcap ? chunk_time : Clock::duration{}} {}

    bool accept(ano::FrameView frame, const Passage& passage) override {
        const auto described = descriptions_.find(passage.link);
        const std::string_view description = described != descriptions_.end() ? std::string_view{described->second} : "";
        writer_->write({.time_ns = passage.time_ns,
                        .boottime_ns = passage.boottime_ns,
                        .link = passage.link,
                        .link_description = description,
                        .direction = passage.direction == "in"    ? anogate::Direction::in
                                     : passage.direction == "out" ? anogate::Direction::out
                                                                  : anogate::Direction::dropped,
                        .cause = passage.cause,
                        .channel = passage.channel,
                        .peer = passage.peer,
                        .frame = frame},
                       waiting_);
        ++taken_;
        return true;
    }
    void use(const anogate::DecodingPtr& decoding) override {
        if (anogate::decode_alike(decoding_, decoding)) return;
        decoding_ = decoding;
        writer_->use(decoding, waiting_);
    }
    bool flush() override {
        const auto now = Clock::now();
        if (now - flushed_ >= flush_time_) {
            writer_->flush(waiting_);
            flushed_ = now;
            flushed_frames_ = taken_;
        }
        write();
        if (now - synced_ >= sync_time) {
            output_.sync();
            synced_ = now;
        }
        return output_.fault().empty();
    }
    void miss(std::uint64_t count, const std::string& names, std::string_view) override {
        writer_->write(anogate::RecordedLoss{count, names});
        lost += count;
    }
    void end() {
        writer_->end(waiting_);
        flushed_frames_ = taken_;
        write();
        output_.sync();
    }
    double seconds() const { return std::chrono::duration<double>(Clock::now() - began_).count(); }

    std::uint64_t frames = 0, lost = 0;

private:
    void write() {
        if (waiting_.empty()) return;
        output_.write(waiting_);
        waiting_.clear();
        if (output_.fault().empty()) frames = flushed_frames_;
    }

    RecordingOutput& output_;
    Descriptions descriptions_;
    std::string waiting_;
    anogate::DecodingPtr decoding_;    // layouts of the frames
    std::unique_ptr<anogate::RecordingWriter> writer_;
    std::uint64_t taken_ = 0, flushed_frames_ = 0;
    const ano::TimePoint began_ = Clock::now();
    ano::TimePoint synced_ = began_, flushed_ = began_;
    const Clock::duration flush_time_;
};

struct Record {
    std::string file;
    std::vector<std::string> ids, from, to, links, directions;
    std::optional<anogate::DecodedEncoding> encoding;
    std::optional<ano::Duration> time;
    bool force = false, json = false, last = false;
    GatewayOptions gateway;

    int run(Streams& streams) const {
        if (encoding && format() != anogate::RecordingFormat::mcap)
            throw UsageError{"--message-encoding applies only to MCAP; name the file with .mcap"};
        check_ending(streams);
        if (last) return save_last(streams);
        const anogate::RecordingOptions options{.encoding = encoding.value_or(anogate::DecodedEncoding::cdr), .packed = true};
        if (file == "-" && streams.terminal)
            throw UsageError{
                "recordings are binary and not written to a terminal; give a file, or pipe the output: | wireshark -k -i -"};
        const ano::Json links_now = parse_answer(
            gateway.ask("GET", "/links"));    // before the file is created: there may be no gateway
        auto decoding = std::make_shared<const anogate::Decoding>(layouts_of_gateway(gateway), lx_links(links_now));
        RecordingOutput output{file, force, streams};
        Recorder recorder{output, described(links_now), std::move(decoding), format(), options};
        std::string why;
        try {
            why = watch_frames(gateway.socket(), query(), recorder, time);
        } catch (...) {
            output.remove_if_empty();
            throw;
        }
        recorder.end();
        sum_up(recorder, output, streams);
        if (!output.fault().empty())
            throw Failure{file + ": cannot continue writing: " + output.fault() + "; the frames written so far are intact"};
        if (!why.empty()) throw Failure{why};
        return fine;
    }

private:
    void check_ending(Streams& streams) const {
        for (const std::string_view word : {"status", "start", "stop", "list", "end", "get", "delete", "save"})
            if (file == word)
                throw UsageError{"record writes a FILE on this computer; for recordings made by the gateway: anoctl recordings " +
                                 std::string{word == "status" ? "list"
                                             : word == "stop" ? "end NAME"
                                                              : word} +
                                 " (for a file with this name: ./" + file + ")"};
        const std::string name = file.substr(file.rfind('/') + 1);
        if (name.empty() || name == "-" || anogate::recording_format_of(name)) return;
        if (name.rfind('.') != name.npos) throw UsageError{ending_refused(file)};
        print_note(streams, file + ": writing pcapng; for MCAP, end the name with .mcap");
    }
    anogate::RecordingFormat format() const {
        return anogate::recording_format_of(file).value_or(anogate::RecordingFormat::pcapng);
    }
    /// Saves the latest frames, which the gateway stores in memory (keep_last).
    int save_last(Streams& streams) const {
        if (file == "-" && streams.terminal) throw UsageError{"recordings are binary and not written to a terminal; give a file"};
        std::string path = "/recordings/last?format=";
        path += text(format());
        if (encoding) path.append("&message_encoding=").append(text(*encoding));
        const std::string recording = gateway.ask("GET", path);
        RecordingOutput output{file, force, streams};
        output.write(recording);
        output.sync();
        if (!output.fault().empty()) throw Failure{file + ": cannot write: " + output.fault()};
        if (json)
            (file == "-" ? streams.err : streams.out)
                << ano::json_text(ano::Json{{"file", file}, {"bytes", output.size()}}) << '\n';
        else print_note(streams, file + ": " + counted(output.size(), "byte") + ", the latest frames kept by the gateway");
        return fine;
    }
    std::string query() const {
        const std::vector<std::string> in{"in"};
        return filter_words("id", ids) + filter_words("from", from) + filter_words("to", to) + filter_words("link", links) +
               filter_words("direction", directions.empty() ? in : directions);
    }
    static Recorder::Descriptions described(const ano::Json& all_links) {
        Recorder::Descriptions all;
        for (const ano::Json& link : all_links)
            if (link.is_object()) all.emplace(text_at(link, "name"), text_at(link, "kind"));
        return all;
    }
    static std::set<std::string, std::less<>> lx_links(const ano::Json& all_links) {
        std::set<std::string, std::less<>> all;
        for (const ano::Json& link : all_links)
            if (link.is_object() && text_at(link, "attitude") == "lx") all.insert(text_at(link, "name"));
        return all;
    }
    void sum_up(const Recorder& recorder, const RecordingOutput& output, Streams& streams) const {
        const double seconds = recorder.seconds();
        if (json) {
            std::ostream& out = file == "-" ? streams.err : streams.out;
            out << ano::json_text(ano::Json{{"file", file},
                                            {"frames", recorder.frames},
                                            {"bytes", output.size()},
                                            {"seconds", std::round(seconds * 1000) / 1000},
                                            {"lost", recorder.lost}})
                << '\n';
            return;
        }
        std::string text = file + ": " + counted(recorder.frames, "frame") + " in " + time_text(seconds) + ", " +
                           counted(output.size(), "byte");
        if (recorder.lost > 0)
            text += "; " + counted(recorder.lost, "frame") + (recorder.lost == 1 ? " is" : " are") +
                    " missing: the buffer of the gateway was full";
        print_note(streams, text);
    }
};

}    // namespace

Run add_record(Options& options) {
    const auto self = std::make_shared<Record>();
    const auto read_seconds = [self](const std::string& word) -> std::string {
        const auto number = ano::parse_number(word);
        const double seconds = number ? std::visit([](auto n) { return static_cast<double>(n); }, *number) : 0;
        if (!(seconds > 0 && seconds < 1e9)) return ano::in_quotes(word) + " is not a number of seconds";
        self->time = std::chrono::duration_cast<ano::Duration>(std::chrono::duration<double>{seconds});
        return {};
    };
    options.push_back({"file", &self->file, "FILE",
                       "Output file: NAME.mcap is MCAP, for Foxglove, PlotJuggler and ROS 2; otherwise pcapng, for Wireshark "
                       "with the dissector from anoctl messages --lua; - writes standard output",
                       true});
    options.push_back({"--id", &self->ids, "ID...", "Select only these messages, by name or id"});
    options.push_back({"--from", &self->from, "ADDRESS...", "Select only frames from these addresses"});
    options.push_back({"--to", &self->to, "ADDRESS...", "Select only frames to these addresses"});
    options.push_back({"--link", &self->links, "LINK...", "Record only frames on these links, by name"});
    options.push_back(
        {"--direction", &self->directions, "in|out|dropped...", "Record received, sent or dropped frames (default: in)"});
    options.push_back({"--seconds", Option::Read{read_seconds}, "N", "Stop after this time (default: on Ctrl-C)"});
    options.push_back({"--last",
                       &self->last,
                       "",
                       "Save only the latest frames that the gateway keeps in memory (keep_last in its configuration)",
                       false,
                       {"--id", "--from", "--to", "--link", "--direction", "--seconds"}});
    options.push_back({"--message-encoding",
                       Option::Read{[self](const std::string& word) { return read_message_encoding(word, self->encoding); }},
                       "cdr|json", "Encoding of decoded messages in MCAP: cdr as in ROS 2 (default), or json"});
    options.push_back({"--force", &self->force, "", "Overwrite an existing file"});
    options.push_back({"--json", &self->json, "", "Print the summary as one JSON object"});
    GatewayOptions::add(options, self->gateway);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
