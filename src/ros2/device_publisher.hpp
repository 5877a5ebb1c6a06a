// Publishes the messages of one device. No I/O but through Bus.
#pragma once
#include <ano/reading.hpp>
#include <ano/time.hpp>
#include <ano_json/text.hpp>
#include <gateway/frame_record.hpp>
#include <record/decoding.hpp>
#include <ros/cdr_encoder.hpp>
#include <ros/image_rows.hpp>
#include <ros/standard_messages.hpp>
#include <ros/value_list.hpp>
#include <ros2/arrival_envelope.hpp>
#include <ros2/bus.hpp>
#include <ros2/known_messages.hpp>
#include <ros2/settings.hpp>
#include <ros2/topic_table.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// Shared by all devices.
struct PublisherContext {
    Bus& bus;
    const Ros2Settings& settings;
    KnownMessages known{};
    ImageRows images{};
    CdrEncoder encoder{};
    ValueList values{};
    std::size_t topics = 0;    // of all devices
    std::optional<Bus::Topic> tf{};
    static constexpr std::size_t max_topics = 1024;    // a topic takes about 70 KB
};

/// A topic, and how often it was published on.
struct PublishedTopic {
    std::optional<Bus::Topic> topic{};    // std::nullopt: not created yet
    std::uint64_t count = 0;
};

class DevicePublisher {
public:
    /// `number` identifies the device among all. `publishes_joy`: joy is not an input.
    DevicePublisher(PublisherContext& context, std::string prefix, std::uint64_t number, bool publishes_joy);

    /// `encoding`: of its texts.
    void receive(const FrameRecord& record, const ano::Reading& reading, const Decoding& decoding, ano::EulerSigns signs,
                 ano::Encoding encoding);
    /// Before the layouts of flexible messages change.
    void forget_layouts();

    const std::string& prefix() const noexcept { return prefix_; }
    bool publishes_joy() const noexcept { return publishes_joy_; }
    /// Messages published on a topic of topic_table().
    std::uint64_t count(std::size_t topic) const noexcept { return topics_[topic].count; }
    /// Received messages by id.
    std::uint64_t received(std::uint8_t id) const noexcept { return received_[id]; }
    /// Topics under raw/, with their messages.
    void for_each_raw(
        const std::function<void(const std::string& name, const RosMessage& type, const PublishedTopic&)>& call) const;

private:
    struct Raw {
        const TableMessage* message = nullptr;
        std::string name{};
        PublishedTopic published{};
    };
    std::uint64_t stamp(const FrameRecord& record);
    void publish_standard(const ano::Reading& reading, std::uint64_t stamp_ns);
    void publish_raw(const ano::Reading& reading, const FrameRecord& record, const Decoding& decoding);
    void publish_joy(const ano::Reading& reading, std::uint64_t stamp_ns);
    void publish_log(const ano::Reading& reading, std::uint64_t stamp_ns, ano::Encoding encoding);
    void publish_transform();
    /// False: nobody receives it, or there are too many topics.
    bool prepare(PublishedTopic& topic, const std::string& name, const RosMessage& type);
    bool prepare(std::size_t topic);
    void publish(std::size_t topic);
    void append_stamp(std::uint64_t stamp_ns);

    PublisherContext& context_;
    std::string prefix_;
    StandardMessages standard_;
    bool publishes_joy_;
    std::array<PublishedTopic, device_topics> topics_{};
    std::array<std::uint64_t, 256> received_{};
    std::map<std::uint8_t, ArrivalEnvelope> envelopes_;    // by the id of the message
    std::map<std::uint8_t, Raw> raw_;
    std::map<const ano::FlexibleLayout*, Raw> flexible_;
};

}    // namespace anogate
