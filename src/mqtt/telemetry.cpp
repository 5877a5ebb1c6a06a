#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano/typed.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/json_writer.hpp>
#include <mqtt/telemetry.hpp>
#include <record/recording.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace anogate {
namespace {

constexpr std::uint64_t second_ns = 1'000'000'000;
constexpr double per_unit = 1000;

bool is_one_number(const ano::Field& field) { return ano::is_number(field.type) && field.count == 1; }

// "no data" differs from every number.
bool differ(double a, double b, double change) {
    if (std::isnan(a) || std::isnan(b)) return std::isnan(a) != std::isnan(b);
    return std::abs(a - b) >= change;
}

std::string other_bytes(const ano::Reading& reading) {
    std::string bytes;
    for (const ano::Field& field : reading.fields()) {
        if (is_one_number(field)) continue;
        const ano::Bytes of_field = reading.bytes_of(field);
        bytes.append(reinterpret_cast<const char*>(of_field.data()), of_field.size());
    }
    return bytes;
}

// The first published frame is followed by the next at this time. Half a period of jitter does not cost a message.
std::uint64_t next_due(std::uint64_t due_ns, std::uint64_t now_ns, std::uint64_t period_ns) {
    return std::max(due_ns + period_ns, now_ns + period_ns / 2);
}

}    // namespace

bool MessageLimit::passes(const MessageRule& rule, const ano::Reading& reading, std::uint64_t now_ns) {
    if (!rule.publish) return false;
    const std::uint64_t period_ns = rule.rate == 0 ? 0 : second_ns * 1000 / rule.rate;
    if (has_published_ && now_ns + period_ns / 2 < due_ns_) return false;
    const bool is_old = !has_published_ || now_ns - published_ns_ >= repeated_after_ns;
    if (rule.change != 0 && reading) {
        if (!is_old && !has_changed(reading, rule.change / per_unit)) return false;
        keep(reading);
    }
    due_ns_ = has_published_ ? next_due(due_ns_, now_ns, period_ns) : now_ns + period_ns;
    published_ns_ = now_ns;
    has_published_ = true;
    return true;
}

bool MessageLimit::has_changed(const ano::Reading& reading, double change) {
    std::size_t i = 0;
    for (const ano::Field& field : reading.fields()) {
        if (!is_one_number(field)) continue;
        if (i == numbers_.size() || differ(reading.number(field), numbers_[i], change)) return true;
        ++i;
    }
    return i != numbers_.size() || other_bytes(reading) != others_;
}

void MessageLimit::keep(const ano::Reading& reading) {
    numbers_.clear();
    for (const ano::Field& field : reading.fields())
        if (is_one_number(field)) numbers_.push_back(reading.number(field));
    others_ = other_bytes(reading);
}

std::array<MessageRule, 256> rules_by_id(const std::vector<MessageRule>& rules) {
    std::array<MessageRule, 256> by_id;
    for (const std::uint8_t id : {ano::id_of<"log">, ano::id_of<"log_value">}) by_id[id].rate = 0, by_id[id].keep = Keep::high;
    for (const MessageRule& rule : rules) {
        if (rule.message == "*") {
            by_id.fill(rule);
            continue;
        }
        const auto id = ano::message_id(rule.message);
        if (const auto* number = std::get_if<std::uint8_t>(&id)) by_id[*number] = rule;
    }
    return by_id;
}

Telemetry::Telemetry(const MqttSettings& settings, std::string gateway, std::string stream)
    : gateway_{std::move(gateway)},
      stream_{std::move(stream)},
      topics_{gateway_},
      rules_{rules_by_id(settings.messages)},
      decoding_{std::make_shared<const Decoding>()} {}

std::optional<Record> Telemetry::receive(std::string_view link, const FrameRecord& frame, ano::TimePoint now) {
    const std::uint8_t address = frame.frame.source(), id = frame.frame.id();
    if (frame.direction != Direction::in || frame.is_elsewhere) return std::nullopt;
    if (ano::address::is_host(address) || ano::address::is_nobody(address)) return std::nullopt;
    const ano::Encoding encoding = encodings_.of(frame.frame, link, true, decoding_.get());
    if (devices_.size() < max_devices) devices_.insert({std::string{link}, address});
    MessageLimit* const limit = limit_of(link, address, id);
    const ano::Reading reading = ano::read(frame.frame, &decoding_->layouts());
    if (limit == nullptr || !limit->passes(rules_[id], reading, frame.boottime_ns)) return std::nullopt;
    const std::string device = device_level(link, address);
    const std::string message = reading.message() == nullptr ? ano::hex_byte(id) : std::string{reading.message()->name};
    Record record{seq_ + 1, rules_[id].keep, now, frame.time_ns, topics_.up(device, level_of(message)), {}};
    ++seq_;
    record.json = json(link, frame, device, encoding);
    return record;
}

std::string Telemetry::json(std::string_view link, const FrameRecord& frame, std::string_view device,
                            ano::Encoding encoding) const {
    std::string text;
    ano::JsonWriter out{text};
    out.begin_object();
    out.text("gateway", gateway_);
    out.text("stream", stream_);
    out.key("seq");
    out.number(seq_);
    out.key("time");
    out.number(json_seconds(frame.time_ns));
    out.key("boottime");
    out.number(json_seconds(frame.boottime_ns));
    out.text("link", link);
    out.text("device", device);
    ano::write_frame(frame.frame, {.flexible = &decoding_->layouts(), .encoding = encoding}, out);
    out.end_object();
    return text;
}

MessageLimit* Telemetry::limit_of(std::string_view link, std::uint8_t address, std::uint8_t id) {
    auto of_link = limits_.find(link);
    if (of_link == limits_.end()) {
        if (limits_.size() == max_devices) return nullptr;
        of_link = limits_.try_emplace(std::string{link}).first;
    }
    const auto key = static_cast<std::uint16_t>(address << 8 | id);
    if (const auto found = of_link->second.find(key); found != of_link->second.end()) return &found->second;
    if (limit_count_ == max_limits) return nullptr;
    ++limit_count_;
    return &of_link->second[key];
}

}    // namespace anogate
