#include <ano/messages.hpp>
#include <ano/typed.hpp>
#include <ros/standard_types.hpp>
#include <ros2/device_publisher.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace anogate {
namespace {

constexpr std::uint64_t second_ns = 1'000'000'000;

}    // namespace

DevicePublisher::DevicePublisher(PublisherContext& context, std::string prefix, std::uint64_t number, bool publishes_joy)
    : context_{context}, prefix_{std::move(prefix)}, standard_{prefix_, &context.images, number}, publishes_joy_{publishes_joy} {
    standard_.set_variances(context.settings.variances);
}

void DevicePublisher::receive(const FrameRecord& record, const ano::Reading& reading, const Decoding& decoding,
                              ano::EulerSigns signs, ano::Encoding encoding) {
    const std::uint8_t id = record.frame.id();
    ++received_[id];
    const std::uint64_t stamp_ns = stamp(record);
    standard_.set_attitude(signs);
    publish_standard(reading, stamp_ns);
    if (id == ano::id_of<"remote_control"> && publishes_joy_) publish_joy(reading, stamp_ns);
    if (id == ano::id_of<"log"> || id == ano::id_of<"log_value">) publish_log(reading, record.time_ns, encoding);
    if (context_.settings.raw) publish_raw(reading, record, decoding);
}

// The envelope needs a clock that is never set; its correction is applied to the time.
std::uint64_t DevicePublisher::stamp(const FrameRecord& record) {
    const std::uint64_t early = record.boottime_ns - envelopes_[record.frame.id()].stamp(record.boottime_ns);
    return record.time_ns - std::min(early, record.time_ns);
}

bool DevicePublisher::prepare(PublishedTopic& topic, const std::string& name, const RosMessage& type) {
    if (!topic.topic) {
        if (context_.topics == PublisherContext::max_topics) return false;
        ++context_.topics;
        const auto qos = context_.settings.qos.find(name.starts_with("raw/") ? "raw" : name);
        const Reliability reliability = qos == context_.settings.qos.end() ? Reliability::reliable : qos->second;
        topic.topic = context_.bus.advertise({'/' + prefix_ + '/' + name, &type, reliability});
    }
    ++topic.count;
    return context_.bus.has_subscribers(*topic.topic);
}

bool DevicePublisher::prepare(std::size_t topic) {
    const TopicRow& row = topic_table()[topic];
    context_.values.clear();
    return prepare(topics_[topic], std::string{row.name}, *row.type);
}

void DevicePublisher::publish(std::size_t topic) {
    context_.bus.publish(*topics_[topic].topic, context_.encoder.encode(*topic_table()[topic].type, context_.values.values()));
}

void DevicePublisher::publish_standard(const ano::Reading& reading, std::uint64_t stamp_ns) {
    for (const StandardTopic standard : standard_.receive(reading, stamp_ns)) {
        const auto topic = static_cast<std::size_t>(standard);
        const bool is_wanted = prepare(topic);
        const bool is_transform = standard == StandardTopic::odometry && context_.tf &&
                                  context_.bus.has_subscribers(*context_.tf);
        if (!is_wanted && !is_transform) continue;
        standard_.append_values(standard, context_.values);
        if (is_wanted) publish(topic);
        if (is_transform) publish_transform();
    }
}

// From the values of an Odometry, which begin with both frames, the position and the orientation.
void DevicePublisher::publish_transform() {
    const auto odometry = context_.values.values();
    constexpr std::size_t used = 11;    // stamp (2), frame_id, child_frame_id, position (3), orientation (4)
    std::vector<ano::Value> values{std::uint64_t{1}};
    values.insert(values.end(), odometry.begin(), odometry.begin() + used);
    context_.bus.publish(*context_.tf, context_.encoder.encode(*standard_types().tf_message, values));
}

void DevicePublisher::append_stamp(std::uint64_t stamp_ns) {
    const std::uint64_t seconds = std::min<std::uint64_t>(stamp_ns / second_ns, std::numeric_limits<std::int32_t>::max());
    context_.values.push(ano::Value{static_cast<std::int64_t>(seconds)});
    context_.values.push(ano::Value{static_cast<std::int64_t>(stamp_ns % second_ns)});
}

// 1000 to 2000 as -1 to 1; a channel without a link has no value.
void DevicePublisher::publish_joy(const ano::Reading& reading, std::uint64_t stamp_ns) {
    if (!prepare(joy_topic)) return;
    append_stamp(stamp_ns);
    context_.values.push(ano::Value{std::string_view{prefix_}});
    context_.values.push_count(reading.fields().size());
    for (const ano::Field& channel : reading.fields()) {
        constexpr double middle = 1500, half = 500;
        const double value = reading.number(channel);
        context_.values.push(value == 0 ? std::nan("") : (value - middle) / half);
    }
    context_.values.push_count(0);
    publish(joy_topic);
}

void DevicePublisher::publish_log(const ano::Reading& reading, std::uint64_t stamp_ns, ano::Encoding encoding) {
    constexpr std::int64_t info = 20, error = 40;    // rcl_interfaces/Log
    constexpr double red = 1;
    const ano::Field* const text = reading.field("str");
    if (text == nullptr || !prepare(log_topic)) return;
    const ano::Field *const color = reading.field("color"), *const value = reading.field("val");
    const auto shown = std::get<std::string_view>(reading.value(*text));
    std::string line = ano::to_utf8({reinterpret_cast<const std::uint8_t*>(shown.data()), shown.size()}, encoding);
    if (value != nullptr) line += ' ' + ano::number_text(ano::widened(static_cast<float>(reading.number(*value))));
    append_stamp(stamp_ns);
    context_.values.push(ano::Value{color != nullptr && reading.number(*color) == red ? error : info});
    context_.values.push(ano::Value{std::string_view{prefix_}});
    context_.values.push_copy(std::move(line));
    for (int empty = 0; empty < 2; ++empty) context_.values.push(ano::Value{std::string_view{}});
    context_.values.push(ano::Value{std::int64_t{0}});
    publish(log_topic);
}

void DevicePublisher::publish_raw(const ano::Reading& reading, const FrameRecord& record, const Decoding& decoding) {
    const std::uint8_t id = record.frame.id();
    const ano::FlexibleLayout* const layout = ano::is_flexible(id)
                                                  ? decoding.layouts().find(id, record.frame.source(), record.frame.data())
                                                  : nullptr;
    Raw& raw = layout != nullptr ? flexible_[layout] : raw_[id];
    if (raw.message == nullptr) {
        raw.message = &context_.known.of(id, layout);
        raw.name = "raw/" + std::string{reading.message()->name};
        if (layout != nullptr && layout->when()) raw.name += "_when_" + std::to_string(*layout->when());
    }
    if (!prepare(raw.published, raw.name, raw.message->type())) return;
    context_.values.clear();
    raw.message->append_values(reading, context_.values);
    context_.bus.publish(*raw.published.topic, context_.encoder.encode(raw.message->type(), context_.values.values()));
}

void DevicePublisher::forget_layouts() {
    for (const auto& [layout, raw] : flexible_) {
        if (!raw.published.topic) continue;
        context_.bus.withdraw(*raw.published.topic);
        --context_.topics;
    }
    flexible_.clear();
}

void DevicePublisher::for_each_raw(
    const std::function<void(const std::string& name, const RosMessage& type, const PublishedTopic&)>& call) const {
    for (const auto& [id, raw] : raw_) call(raw.name, raw.message->type(), raw.published);
    for (const auto& [layout, raw] : flexible_) call(raw.name, raw.message->type(), raw.published);
}

}    // namespace anogate
