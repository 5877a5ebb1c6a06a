#include <record/mcap/mcap_items.hpp>
#include <record/mcap/mcap_writer.hpp>

#include <utility>

namespace anogate {
namespace {

constexpr std::uint16_t frames_channel = 1, losses_channel = 2, first_decoded_channel = 3;
constexpr std::uint16_t frame_schema = 1, loss_schema = 2, first_decoded_schema = 3;

}    // namespace

McapWriter::McapWriter(const RecordingHead& head, std::string& out, RecordingOptions options)
    : encoding_{options.encoding}, decoded_{options.encoding, head.decoding}, chunk_{options.packed}, last_ns_{head.time_ns} {
    const std::string_view program = text_that_fits(head.program);
    record_ = mcap::magic;
    const std::size_t begun = mcap::begin_record(record_, mcap::Opcode::header);
    mcap::append_string(record_,
                        encoding_ == DecodedEncoding::cdr ? "ros2" : "");    // the profile requires CDR in the whole file
    mcap::append_string(record_, program);
    mcap::end_record(record_, begun);
    append(out, record_);

    record_.clear();
    mcap::append_metadata(
        record_, mcap::head_name,
        {{"program", program}, {"time_ns", std::to_string(head.time_ns)}, {"boottime_ns", std::to_string(head.boottime_ns)}});
    summary_.add_metadata(record_, position_);
    append(out, record_);
    if (head.decoding && !head.decoding->is_usual()) write_decoding(*head.decoding, out);
}

void McapWriter::write_decoding(const Decoding& decoding, std::string& out) {
    record_.clear();
    mcap::append_metadata(record_, mcap::decoding_name, {{"json", decoding.text()}, {"after_ns", std::to_string(last_ns_)}});
    summary_.add_metadata(record_, position_);
    append(out, record_);
}

// Ends the chunk, because its frames were decoded with the previous decoding.
void McapWriter::use(const DecodingPtr& decoding, std::string& out) {
    flush(out);
    static const Decoding usual;
    write_decoding(decoding ? *decoding : usual, out);
    decoded_.use(decoding);
}

void McapWriter::append(std::string& out, std::string_view bytes) {
    crc_.add(bytes);
    position_ += bytes.size();
    out += bytes;
}

void McapWriter::define(std::uint16_t channel, std::string_view topic, const mcap::SchemaRecord& schema,
                        std::string_view encoding) {
    if (channel >= sequences_.size()) sequences_.resize(std::size_t{channel} + 1);
    if (sequences_[channel] > 0) return;
    sequences_[channel] = 1;
    if (schema.id >= schemas_.size()) schemas_.resize(std::size_t{schema.id} + 1);
    if (!schemas_[schema.id]) {
        schemas_[schema.id] = true;
        record_.clear();
        mcap::append_schema(record_, schema);
        summary_.add_schema(record_);
        chunk_.add_record(record_);
    }
    record_.clear();
    mcap::append_channel(record_, {channel, schema.id, topic, encoding});
    summary_.add_channel(record_);
    chunk_.add_record(record_);
}

void McapWriter::put(std::uint16_t channel, std::uint64_t time_ns, std::string_view data) {
    summary_.add_message(channel, time_ns);
    chunk_.add_message({channel, sequences_[channel]++, time_ns, time_ns, data});
}

void McapWriter::write(const RecordedFrame& frame, std::string& out) {
    if (lost_ > 0) write_loss(frame.time_ns);
    define(frames_channel, mcap::frames_topic, {frame_schema, mcap::frame_schema_name, "ros2msg", mcap::frame_schema_text},
           "cdr");
    mcap::encode(frame, message_);
    put(frames_channel, frame.time_ns, message_);
    counts_.add(frame);
    last_ns_ = frame.time_ns;
    write_decoded(frame);
    if (chunk_.size() >= enough) flush(out);
}

void McapWriter::write_decoded(const RecordedFrame& frame) {
    for (const DecodedMessage& message : decoded_.decode(frame)) {
        const DecodedChannel& channel = decoded_.channels()[message.channel];
        const DecodedSchema& schema = decoded_.schemas()[channel.schema];
        const auto id = static_cast<std::uint16_t>(first_decoded_channel + message.channel);
        const auto schema_id = static_cast<std::uint16_t>(first_decoded_schema + channel.schema);
        define(id, channel.topic, {schema_id, schema.name, schema.encoding, schema.text}, text(encoding_));
        put(id, frame.time_ns, message.data);
    }
}

void McapWriter::write(const RecordedLoss& loss) {
    if (loss.count == 0) return;
    lost_ += loss.count;
    const std::string_view names = text_that_fits(loss.names);
    if (!lost_names_.empty() && !names.empty()) lost_names_ += ", ";
    lost_names_ += names;
    lost_names_.resize(text_that_fits(lost_names_).size());
}

void McapWriter::write_loss(std::uint64_t time_ns) {
    const RecordedLoss loss{std::exchange(lost_, 0), lost_names_};
    define(losses_channel, mcap::losses_topic, {loss_schema, mcap::loss_schema_name, "ros2msg", mcap::loss_schema_text}, "cdr");
    mcap::encode(loss, message_);
    put(losses_channel, time_ns, message_);
    counts_.add(loss);
    lost_names_.clear();
}

// A loss without a following frame gets the time of the last frame, so that a file that ends here contains it.
void McapWriter::flush(std::string& out) {
    if (lost_ > 0) write_loss(last_ns_);
    const std::size_t before = out.size();
    chunk_.end(out, position_, summary_);
    const auto chunk = std::string_view{out}.substr(before);
    crc_.add(chunk);
    position_ += chunk.size();
}

void McapWriter::end(std::string& out) {
    flush(out);
    record_.clear();
    mcap::append_metadata(record_, mcap::counts_name, {{"json", counts_.json()}});
    summary_.add_metadata(record_, position_);
    append(out, record_);
    summary_.append(out, position_, crc_.value());
}

}    // namespace anogate
