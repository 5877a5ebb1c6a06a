// anoctl convert FILE OUT: converts a recording to tables, JSON lines, or a recording with some of its messages.
#include <anoctl/anoctl.hpp>
#include <anoctl/counted.hpp>
#include <anoctl/message_encoding.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/frame_printer.hpp>
#include "recording_input.hpp"
#include "recording_output.hpp"

#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/lower_case.hpp>
#include <ano_json/text.hpp>
#include <config/config.hpp>
#include <link/kinds.hpp>
#include <record/csv.hpp>
#include <record/recording_writer.hpp>
#include <record/sender_encodings.hpp>

#include <algorithm>
#include <bitset>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using anogate::DecodingPtr;
using anogate::Recorded;
using anogate::RecordedFrame;
using anogate::RecordedLoss;
using anogate::RecordingHead;

constexpr std::size_t batch = 64 * 1024;

/// Buffers output and writes it in batches. Throws Failure if a write fails. On a terminal, control characters of texts are escaped.
class Collected {
public:
    Collected(const std::string& path, bool force, Streams& streams)
        : path_{path}, is_shown_{path == "-" && streams.terminal}, output_{path, force, streams} {}

    std::string bytes;    // whole lines or blocks
    const std::string& path() const noexcept { return path_; }
    void write_if(std::size_t enough) {
        if (bytes.size() < enough) return;
        output_.write(is_shown_ ? escaped_lines(bytes) : bytes);
        bytes.clear();
        if (!output_.fault().empty()) throw Failure{path_ + ": cannot write: " + output_.fault()};
    }

private:
    static std::string escaped_lines(std::string_view lines) {
        std::string all;
        for (std::size_t from = 0; from < lines.size();) {
            const std::size_t end = std::min(lines.find('\n', from), lines.size());
            all += ano::with_escapes(lines.substr(from, end - from)) + (end < lines.size() ? "\n" : "");
            from = end + 1;
        }
        return all;
    }

    std::string path_;
    bool is_shown_;
    RecordingOutput output_;
};

/// The output of a conversion.
class Target {
public:
    virtual ~Target() = default;
    /// The following items are decoded with `decoding`; called before the first one.
    virtual void use(const DecodingPtr& decoding) = 0;
    /// The encoding of the texts in the next item.
    virtual void read_as(ano::Encoding /*encoding*/) {}
    virtual void accept(const Recorded& item, const RecordingHead& head) = 0;
    virtual void end() = 0;
    /// The written files; valid after end().
    virtual std::vector<std::string> files() const = 0;
};

/// " into 19 tables: a.csv, b.csv, …"; names only the first five.
std::string places(const std::vector<std::string>& files) {
    constexpr std::size_t max_named = 5;
    if (files.size() == 1) return files[0] == "-" ? "" : " into " + files[0];
    std::string text = files.empty() ? ": no table was written" : " into " + counted(files.size(), "table") + ": ";
    for (std::size_t i = 0; i < std::min(files.size(), max_named); ++i) text += (i > 0 ? ", " : "") + files[i];
    return files.size() > max_named ? text + ", \u2026" : text;
}

/// Writes OUT-MESSAGE.csv for each message, or one file if only one message is wanted. If its layout changes, another table with
/// the columns of the new one follows: OUT-MESSAGE-2.csv.
class CsvTarget final : public Target {
public:
    CsvTarget(std::string out, bool one, bool force, const ano::JsonOptions& options, Streams& streams)
        : out_{std::move(out)}, one_{one}, force_{force}, options_{options}, streams_{streams} {}

    void use(const DecodingPtr& decoding) override {
        decodings_.push_back(decoding);    // all are kept: the tables refer to them
        options_.flexible = &decoding->layouts();
        for (const auto& [id, tables] : files_) tables.back()->use(decoding->layouts());
    }
    void read_as(ano::Encoding encoding) override { options_.encoding = encoding; }
    void accept(const Recorded& item, const RecordingHead&) override {
        const auto* frame = std::get_if<RecordedFrame>(&item);
        if (frame == nullptr) return;
        File& file = file_of(frame->frame.id());
        file.csv.read_as(options_.encoding);
        file.csv.write(*frame, file.to.bytes);
        file.to.write_if(batch);
    }
    void end() override {
        for (const auto& [id, tables] : files_) tables.back()->to.write_if(0);
    }
    std::vector<std::string> files() const override {
        std::vector<std::string> all;
        for (const auto& [id, tables] : files_)
            for (const auto& file : tables) all.push_back(file->to.path());
        return all;
    }

private:
    struct File {
        anogate::CsvWriter csv;
        Collected to;
        bool lacks_columns = false;    // for the next frame

        void use(const ano::FlexibleLayouts& layouts) {
            csv.use(layouts);
            lacks_columns = !csv.has_columns_for(layouts);
        }
    };

    File& file_of(std::uint8_t id) {
        auto& tables = files_[id];
        if (!tables.empty() && !may_be_followed(*tables.back())) return *tables.back();
        if (!tables.empty()) tables.back()->to.write_if(0);
        tables.push_back(std::unique_ptr<File>{
            new File{anogate::CsvWriter{id, options_}, {path_of(id, tables.size() + 1), force_, streams_}}});
        tables.back()->csv.write_heading(tables.back()->to.bytes);
        return *tables.back();
    }
    // Standard output is one table: values without a column are only in its frame_data.
    bool may_be_followed(File& table) {
        if (!table.lacks_columns || out_ != "-") return table.lacks_columns;
        table.lacks_columns = false;
        print_note(streams_,
                   "the layout changes in this recording: values without a column are only in frame_data; to get a table "
                   "for each layout, write into a file");
        return false;
    }
    std::string path_of(std::uint8_t id, std::size_t number) const {
        if (out_ == "-") return out_;
        const std::string end = (number > 1 ? "-" + std::to_string(number) : "") + ".csv";
        const std::string stem = out_.substr(0, out_.size() - std::string_view{".csv"}.size());
        if (one_) return number > 1 ? stem + end : out_;
        const ano::Message* message = ano::find_message(id);
        return stem + "-" + (message != nullptr ? std::string{message->name} : ano::hex_byte(id)) + end;
    }

    std::string out_;
    bool one_, force_;
    ano::JsonOptions options_;
    Streams& streams_;
    std::vector<DecodingPtr> decodings_;
    std::map<std::uint8_t, std::vector<std::unique_ptr<File>>> files_;    // the last one is written to
};

class JsonTarget final : public Target {
public:
    JsonTarget(const std::string& out, bool force, const ano::JsonOptions& options, Streams& streams)
        : to_{out, force, streams}, options_{options} {}

    void use(const DecodingPtr& decoding) override {
        decoding_ = decoding;
        options_.flexible = &decoding_->layouts();
    }
    void read_as(ano::Encoding encoding) override { options_.encoding = encoding; }
    void accept(const Recorded& item, const RecordingHead&) override {
        to_.bytes += ano::with_json_escapes(anogate::recorded_json(item, options_)) + '\n';
        to_.write_if(batch);
    }
    void end() override { to_.write_if(0); }
    std::vector<std::string> files() const override { return {to_.path()}; }

private:
    Collected to_;
    ano::JsonOptions options_;
    DecodingPtr decoding_;
};

/// Writes the wanted messages as a recording. If all are wanted, the bytes are the same as in the input.
class RecordingTarget final : public Target {
public:
    RecordingTarget(const std::string& out, bool force, anogate::RecordingFormat format, anogate::RecordingOptions options,
                    Streams& streams)
        : to_{out, force, streams}, format_{format}, options_{options} {}

    void use(const DecodingPtr& decoding) override {
        decoding_ = decoding;
        if (writer_) writer_->use(decoding_, to_.bytes);
    }
    void accept(const Recorded& item, const RecordingHead& head) override {
        if (!writer_) begin(head);
        if (const auto* loss = std::get_if<RecordedLoss>(&item)) writer_->write(*loss);
        else writer_->write(std::get<RecordedFrame>(item), to_.bytes);
        to_.write_if(batch);
    }
    void end() override {
        if (!writer_) begin(RecordingHead{"anoctl " ANOGATE_VERSION});
        writer_->end(to_.bytes);
        to_.write_if(0);
    }
    std::vector<std::string> files() const override { return {to_.path()}; }

private:
    void begin(RecordingHead head) {
        head.decoding = decoding_;
        writer_ = anogate::make_recording_writer(format_, head, to_.bytes, options_);
    }

    Collected to_;
    DecodingPtr decoding_;
    anogate::RecordingFormat format_;
    anogate::RecordingOptions options_;
    std::unique_ptr<anogate::RecordingWriter> writer_;
};

struct Convert {
    std::string file, out;
    std::vector<std::string> messages;
    std::optional<anogate::DecodedEncoding> encoding;
    FrameOptions frames;
    bool force = false;

    int run(Streams& streams) const {
        const std::bitset<256> wanted = wanted_messages();
        const std::optional<Given> given = frames.config.empty() ? std::nullopt : std::optional{read_config()};
        const ano::FlexibleLayouts none;
        const ano::JsonOptions options = frames.json_options(none);    // `none` until use()
        if (out == file && out != "-") throw UsageError{out + " is what is read"};
        const std::unique_ptr<Target> target = make_target(options, wanted.count() == 1, streams);
        std::uint64_t taken = 0;
        DecodingPtr recorded, used;    // from the recording; the one in use
        anogate::SenderEncodings encodings;
        const RecordingFacts facts = read_recording(file, streams, [&](const Recorded& item, const RecordingHead& head) {
            const auto* frame = std::get_if<RecordedFrame>(&item);
            if (!used || recorded != head.decoding) {
                recorded = head.decoding;
                target->use(used = with(given, recorded));
            }
            if (frame != nullptr && !frames.encoding)
                target->read_as(encodings.of(frame->frame, frame->link, frame->direction == anogate::Direction::in, used.get()));
            if (frame != nullptr && !wanted[frame->frame.id()]) return;
            taken += frame != nullptr;
            target->accept(item, head);
        });
        target->end();
        for (const std::string& note : facts.notes()) print_note(streams, file + ": " + note);
        print_note(streams, counted(taken, "frame") + " of " + file + " written" + places(target->files()));
        return facts.is_damaged() ? failed : fine;
    }

private:
    /// The configuration given by --config.
    struct Given {
        std::vector<std::string> links;    // names
        DecodingPtr decoding;
    };
    Given read_config() const {
        std::vector<ano::FlexibleSpec> flexible = frames.specs();
        const anogate::Settings settings = anogate::parse_config(frames.config_text(), anogate::link_kinds()).settings;
        Given given;
        for (const anogate::LinkSettings& link : settings.links) given.links.push_back(link.name);
        given.decoding = anogate::decoding_of(settings, std::move(flexible));
        return given;
    }
    /// `recorded`, with what is `given` instead of its own: all layouts, and what belongs to the links.
    static DecodingPtr with(const std::optional<Given>& given, const DecodingPtr& recorded) {
        if (!given) return recorded ? recorded : std::make_shared<const anogate::Decoding>();
        auto lx = given->decoding->lx();
        auto texts = given->decoding->texts();
        const auto is_given = [&](const std::string& link) {
            return std::find(given->links.begin(), given->links.end(), link) != given->links.end();
        };
        if (recorded) {
            for (const std::string& link : recorded->lx())
                if (!is_given(link)) lx.insert(link);
            for (const auto& [link, encoding] : recorded->texts())
                if (!is_given(link)) texts.emplace(link, encoding);
        }
        return std::make_shared<const anogate::Decoding>(given->decoding->flexible(), std::move(lx), std::move(texts));
    }
    std::bitset<256> wanted_messages() const {
        std::bitset<256> wanted;
        for (const std::string& word : messages) wanted.set(message_id_of(word, "--id: "));
        return messages.empty() ? wanted.set() : wanted;
    }
    std::unique_ptr<Target> make_target(const ano::JsonOptions& options, bool one, Streams& streams) const {
        const auto format = anogate::recording_format_of(out);
        const std::string lower = ano::lower_case(out);
        if (encoding && format != anogate::RecordingFormat::mcap)
            throw UsageError{"--message-encoding applies only to MCAP; name OUT_FILE with .mcap"};
        if (lower.ends_with(".csv") || (out == "-" && one && !frames.json))
            return std::make_unique<CsvTarget>(out, one, force, options, streams);
        if (lower.ends_with(".ndjson") || lower.ends_with(".jsonl") || out == "-")
            return std::make_unique<JsonTarget>(out, force, options, streams);
        if (format)
            return std::make_unique<RecordingTarget>(
                out, force, *format,
                anogate::RecordingOptions{.encoding = encoding.value_or(anogate::DecodedEncoding::cdr), .packed = true}, streams);
        throw UsageError{ano::in_quotes(out) + " does not end in .csv, .ndjson, .pcapng or .mcap"};
    }
};

}    // namespace

Run add_convert(Options& options) {
    const auto self = std::make_shared<Convert>();
    options.push_back({"file", &self->file, "FILE", "Recording; - reads standard input", true});
    options.push_back({"out", &self->out, "OUT_FILE",
                       "NAME.csv: one table per message, such as NAME-euler.csv; NAME.ndjson: one JSON object per line; "
                       "NAME.pcapng or NAME.mcap: a selected part of the recording; -: standard output, as JSON, or as a table "
                       "if only one message is selected",
                       true});
    options.push_back({"--id", &self->messages, "ID...",
                       "Select only these messages, by name or id; a single message is written to OUT_FILE itself"});
    options.push_back({"--message-encoding",
                       Option::Read{[self](const std::string& word) { return read_message_encoding(word, self->encoding); }},
                       "cdr|json", "Encoding of decoded messages in MCAP: cdr as in ROS 2 (default), or json"});
    options.push_back({"--force", &self->force, "", "Overwrite existing files"});
    FrameOptions::add(options, self->frames);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
