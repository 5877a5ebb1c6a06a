#include <record/mcap/mcap_format.hpp>

namespace anogate::mcap {

std::optional<Record> next_record(std::string_view& bytes) noexcept {
    Fields fields{bytes};
    const auto opcode = static_cast<Opcode>(fields.number<std::uint8_t>());
    const auto size = fields.number<std::uint64_t>();
    const std::string_view body = fields.bytes(size);
    if (fields.is_bad()) return std::nullopt;
    const Record record{opcode, body, bytes.substr(0, record_head + body.size())};
    bytes.remove_prefix(record.whole.size());
    return record;
}

std::optional<Message> message_of(std::string_view body) noexcept {
    Fields fields{body};
    Message message;
    message.channel = fields.number<std::uint16_t>();
    message.sequence = fields.number<std::uint32_t>();
    message.log_time = fields.number<std::uint64_t>();
    message.publish_time = fields.number<std::uint64_t>();
    message.data = fields.rest();
    return fields.is_bad() ? std::nullopt : std::optional{message};
}

void append_message(std::string& out, const Message& message) {
    const std::size_t begun = begin_record(out, Opcode::message);
    append_le(out, message.channel);
    append_le(out, message.sequence);
    append_le(out, message.log_time);
    append_le(out, message.publish_time);
    out += message.data;
    end_record(out, begun);
}

void append_schema(std::string& out, const SchemaRecord& schema) {
    const std::size_t begun = begin_record(out, Opcode::schema);
    append_le(out, schema.id);
    append_string(out, schema.name);
    append_string(out, schema.encoding);
    append_string(out, schema.text);
    end_record(out, begun);
}

std::optional<ChannelRecord> channel_of(std::string_view body) noexcept {
    Fields fields{body};
    ChannelRecord channel;
    channel.id = fields.number<std::uint16_t>();
    channel.schema = fields.number<std::uint16_t>();
    channel.topic = fields.text();
    channel.encoding = fields.text();
    return fields.is_bad() ? std::nullopt : std::optional{channel};
}

namespace {

void append_pairs(std::string& out, std::initializer_list<Pair> pairs) {
    std::uint32_t size = 0;
    for (const Pair& pair : pairs) size += static_cast<std::uint32_t>(8 + pair.key.size() + pair.value.size());
    append_le(out, size);
    for (const Pair& pair : pairs) {
        append_string(out, pair.key);
        append_string(out, pair.value);
    }
}

}    // namespace

void append_channel(std::string& out, const ChannelRecord& channel) {
    const std::size_t begun = begin_record(out, Opcode::channel);
    append_le(out, channel.id);
    append_le(out, channel.schema);
    append_string(out, channel.topic);
    append_string(out, channel.encoding);
    append_pairs(out, {{"offered_qos_profiles", ""}});
    end_record(out, begun);
}

void append_metadata(std::string& out, std::string_view name, std::initializer_list<Pair> pairs) {
    const std::size_t begun = begin_record(out, Opcode::metadata);
    append_string(out, name);
    append_pairs(out, pairs);
    end_record(out, begun);
}

std::string_view name_of_metadata(std::string_view body) noexcept { return Fields{body}.text(); }

std::string_view metadata_at(std::string_view body, std::string_view key) noexcept {
    Fields fields{body};
    fields.text();
    Fields pairs{fields.text()};
    while (!pairs.rest().empty() && !pairs.is_bad()) {
        const std::string_view name = pairs.text(), value = pairs.text();
        if (name == key && !pairs.is_bad()) return value;
    }
    return {};
}

}    // namespace anogate::mcap
