#include <ano/messages.hpp>
#include <record/decoded_channels.hpp>
#include <ros/cdr_encoder.hpp>
#include <ros/json_message.hpp>
#include <ros/ros_json.hpp>
#include <ros/ros_names.hpp>
#include <ros/standard_messages.hpp>
#include <ros/table_message.hpp>

#include <array>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace anogate {
/// A message, and the index of its schema once it has one.
struct KnownMessage {
    TableMessage message;
    std::size_t schema;
};

using ChannelNumber = std::optional<std::uint16_t>;    // std::nullopt: none yet

struct DecodedDevice {
    DecodedDevice(const std::string& name, ImageRows& images, std::uint64_t number)
        : topic{'/' + name + '/'}, standard{name, &images, number} {}

    std::string topic;    // "/fc/device_5/"
    StandardMessages standard;
    std::array<ChannelNumber, 256> channels{};    // by the id of the message; not for flexible messages
    std::map<const ano::FlexibleLayout*, ChannelNumber> flexible_channels;
    std::array<ChannelNumber, standard_topics> standard_channels{};
};

constexpr std::size_t max_standard = 2;    // standard messages from one frame

struct DecodedLink {
    std::string name;    // in topics
    ano::EulerSigns attitude{};
    std::array<std::unique_ptr<DecodedDevice>, 256> devices{};
};

struct DecodedChannels::State {
    DecodedEncoding encoding;
    DecodingPtr decoding;    // never nullptr
    std::deque<DecodedSchema> schemas;
    std::deque<DecodedChannel> channels;
    std::vector<DecodedMessage> messages;    // of the last frame

    std::array<std::unique_ptr<KnownMessage>, 256> known;
    std::map<const ano::FlexibleLayout*, KnownMessage> known_flexible;
    ImageRows images;
    std::uint64_t devices = 0;
    std::map<std::string, DecodedLink, std::less<>> links;
    std::set<std::string> link_names;
    std::map<const RosMessage*, std::size_t> standard_schemas;
    ValueList values;
    CdrEncoder encoder;
    std::array<CdrEncoder, max_standard> standard_encoders;
    std::string json;
    std::array<std::string, max_standard> standard_json;

    void use(DecodingPtr now);
    void decode(const RecordedFrame& frame);
    void decode(const ano::Reading& reading, const RecordedFrame& frame, DecodedDevice& device);
    void decode_standard(const ano::Reading& reading, std::uint64_t time_ns, DecodedDevice& device);
    bool is_full() const noexcept { return channels.size() == max_channels; }
    DecodedDevice* device_of(const RecordedFrame& frame);
    const KnownMessage& message_of(std::uint8_t id, const ano::FlexibleLayout* layout);
    std::uint16_t add_channel(std::string topic, std::size_t schema);
    std::size_t add_schema(const RosMessage& type, std::string json_schema);
    std::string_view encode(const TableMessage& message, const ano::Reading& reading);
    std::string_view encode_standard(const RosMessage& type, std::size_t number);
};

void DecodedChannels::State::decode(const RecordedFrame& frame) {
    messages.clear();
    if (frame.direction != Direction::in) return;
    const ano::Reading reading = ano::read(frame.frame, &decoding->layouts());
    DecodedDevice* const device = reading ? device_of(frame) : nullptr;
    if (device == nullptr) return;
    decode(reading, frame, *device);
    decode_standard(reading, frame.time_ns, *device);
}

void DecodedChannels::State::decode(const ano::Reading& reading, const RecordedFrame& frame, DecodedDevice& device) {
    const std::uint8_t id = frame.frame.id();
    const ano::FlexibleLayout* const layout = ano::is_flexible(id)
                                                  ? decoding->layouts().find(id, frame.frame.source(), frame.frame.data())
                                                  : nullptr;
    ChannelNumber& channel = layout != nullptr ? device.flexible_channels[layout] : device.channels[id];
    if (!channel && is_full()) return;
    const KnownMessage& known_message = message_of(id, layout);
    if (!channel) {
        std::string topic = device.topic + std::string{reading.message()->name};
        if (layout != nullptr && layout->when()) topic += "_when_" + std::to_string(*layout->when());
        channel = add_channel(std::move(topic), known_message.schema);
    }
    messages.push_back({*channel, encode(known_message.message, reading)});
}

void DecodedChannels::State::decode_standard(const ano::Reading& reading, std::uint64_t time_ns, DecodedDevice& device) {
    std::size_t number = 0;
    for (const StandardTopic topic : device.standard.receive(reading, time_ns)) {
        ChannelNumber& channel = device.standard_channels[static_cast<std::size_t>(topic)];
        const auto& [name, type] = standard_row(topic);
        if (!channel) {
            if (is_full()) return;
            const auto [schema, is_new] = standard_schemas.try_emplace(type, schemas.size());
            if (is_new) add_schema(*type, ros_json_schema(*type));
            channel = add_channel(device.topic + std::string{name}, schema->second);
        }
        values.clear();
        device.standard.append_values(topic, values);
        messages.push_back({*channel, encode_standard(*type, number++)});
    }
}

std::string_view DecodedChannels::State::encode(const TableMessage& message, const ano::Reading& reading) {
    if (encoding == DecodedEncoding::json) {
        json.clear();
        write_json_message(reading, {.flexible = &decoding->layouts(), .encoding = ano::Encoding::automatic}, json);
        return json;
    }
    values.clear();
    message.append_values(reading, values);
    return encoder.encode(message.type(), values.values());
}

std::string_view DecodedChannels::State::encode_standard(const RosMessage& type, std::size_t number) {
    if (encoding == DecodedEncoding::cdr) return standard_encoders[number].encode(type, values.values());
    std::string& text = standard_json[number];
    text.clear();
    write_ros_json(type, values.values(), text);
    return text;
}

// nullptr if a further device would exceed the limit.
DecodedDevice* DecodedChannels::State::device_of(const RecordedFrame& frame) {
    auto link = links.find(frame.link);
    if (link == links.end()) {
        if (is_full()) return nullptr;
        link = links.try_emplace(std::string{frame.link}).first;
        link->second.name = unique_name(ros_name(frame.link, "link"), link_names);
        link->second.attitude = decoding->attitude(frame.link);
    }
    auto& device = link->second.devices[frame.frame.source()];
    if (device == nullptr) {
        if (is_full()) return nullptr;
        const std::string name = link->second.name + "/device_" + std::to_string(frame.frame.source());
        device = std::make_unique<DecodedDevice>(name, images, ++devices);
        device->standard.set_attitude(link->second.attitude);
    }
    return device.get();
}

const KnownMessage& DecodedChannels::State::message_of(std::uint8_t id, const ano::FlexibleLayout* layout) {
    if (layout != nullptr) {
        const auto found = known_flexible.find(layout);
        if (found != known_flexible.end()) return found->second;
        TableMessage message{*layout};
        const std::size_t schema = add_schema(message.type(), json_schema_of(*layout));
        return known_flexible.emplace(layout, KnownMessage{std::move(message), schema}).first->second;
    }
    if (known[id] == nullptr) {
        TableMessage message{id};
        const std::size_t schema = add_schema(message.type(), json_schema_of(ano::layouts_of(id)));
        known[id] = std::make_unique<KnownMessage>(KnownMessage{std::move(message), schema});
    }
    return *known[id];
}

// Forgets the known flexible layouts: they are keyed by address, and a new layout may have the address of an old one.
void DecodedChannels::State::use(DecodingPtr now) {
    if (!now) now = std::make_shared<const Decoding>();
    if (decoding && *decoding == *now) return;
    decoding = std::move(now);
    known_flexible.clear();
    for (auto& [name, link] : links) {
        link.attitude = decoding->attitude(name);
        for (const auto& device : link.devices) {
            if (!device) continue;
            device->flexible_channels.clear();
            device->standard.set_attitude(link.attitude);
        }
    }
}

std::uint16_t DecodedChannels::State::add_channel(std::string topic, std::size_t schema) {
    channels.push_back({std::move(topic), schema});
    return static_cast<std::uint16_t>(channels.size() - 1);
}

std::size_t DecodedChannels::State::add_schema(const RosMessage& type, std::string json_schema) {
    const bool is_json = encoding == DecodedEncoding::json;
    schemas.push_back(
        {full_name(type), is_json ? "jsonschema" : "ros2msg", is_json ? std::move(json_schema) : definition_of(type)});
    return schemas.size() - 1;
}

std::string_view text(DecodedEncoding encoding) noexcept { return encoding == DecodedEncoding::cdr ? "cdr" : "json"; }

std::optional<DecodedEncoding> decoded_encoding_called(std::string_view name) noexcept {
    for (const DecodedEncoding encoding : {DecodedEncoding::cdr, DecodedEncoding::json})
        if (name == text(encoding)) return encoding;
    return std::nullopt;
}

DecodedChannels::DecodedChannels(DecodedEncoding encoding, DecodingPtr decoding) : state_{std::make_unique<State>()} {
    state_->encoding = encoding;
    state_->use(std::move(decoding));
}

DecodedChannels::~DecodedChannels() = default;

void DecodedChannels::use(DecodingPtr decoding) { state_->use(std::move(decoding)); }

std::span<const DecodedMessage> DecodedChannels::decode(const RecordedFrame& frame) {
    state_->decode(frame);
    return state_->messages;
}

const std::deque<DecodedSchema>& DecodedChannels::schemas() const noexcept { return state_->schemas; }
const std::deque<DecodedChannel>& DecodedChannels::channels() const noexcept { return state_->channels; }

}    // namespace anogate
