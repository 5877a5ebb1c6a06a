#include <record/mcap/mcap_format.hpp>

namespace anogate::mcap {

std::optional<Record> take_record(std::string_view& bytes) noexcept {
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

void put_message(std::string& out, const Message& message) {
    const std::size_t begun = begin_record(out, Opcode::message);
    put(out, message.channel);
    put(out, message.sequence);
    put(out, message.log_time);
    put(out, message.publish_time);
    out += message.data;
    end_record(out, begun);
}

void put_schema(std::string& out, const SchemaRecord& schema) {
    const std::size_t begun = begin_record(out, Opcode::schema);
    put(out, schema.id);
    put_text(out, schema.name);
    put_text(out, schema.encoding);
    put_text(out, schema.text);
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

void put_pairs(std::string& out, std::initializer_list<Pair> pairs) {
    std::uint32_t size = 0;
    for (const Pair& pair : pairs) size += static_cast<std::uint32_t>(8 + pair.key.size() + pair.value.size());
    put(out, size);
    for (const Pair& pair : pairs) {
        put_text(out, pair.key);
        put_text(out, pair.value);
    }
}

}    // namespace

void put_channel(std::string& out, const ChannelRecord& channel) {
    const std::size_t begun = begin_record(out, Opcode::channel);
    put(out, channel.id);
    put(out, channel.schema);
    put_text(out, channel.topic);
    put_text(out, channel.encoding);
    put_pairs(out, {{"offered_qos_profiles", ""}});
    end_record(out, begun);
}

void put_metadata(std::string& out, std::string_view name, std::initializer_list<Pair> pairs) {
    const std::size_t begun = begin_record(out, Opcode::metadata);
    put_text(out, name);
    put_pairs(out, pairs);
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
