// Which frames are published, and as what. No I/O, no clock.
#pragma once
#include <ano/reading.hpp>
#include <ano/time.hpp>
#include <gateway/frame_record.hpp>
#include <mqtt/settings.hpp>
#include <mqtt/topics.hpp>
#include <record/decoding.hpp>
#include <record/sender_encodings.hpp>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// A message that was published or will be. `stream` and `seq` in its JSON identify it for ever.
struct Record {
    std::uint64_t seq = 0;
    Keep keep = Keep::normal;
    ano::TimePoint made{};
    std::uint64_t time_ns = 0;    // since 1970
    std::string topic, json;
};

/// The rate limit and the change threshold of one message of one device.
class MessageLimit {
public:
    static constexpr std::uint64_t repeated_after_ns = 60'000'000'000;    // a value that does not change

    /// Whether to publish `reading`, which arrived at `now_ns` by a clock that is never set.
    bool passes(const MessageRule& rule, const ano::Reading& reading, std::uint64_t now_ns);

private:
    bool has_changed(const ano::Reading& reading, double change);
    void keep(const ano::Reading& reading);

    std::uint64_t due_ns_ = 0, published_ns_ = 0;
    bool has_published_ = false;
    std::vector<double> numbers_;    // of the message published last
    std::string others_;             // and its other fields, as on the wire
};

/// A device that sent something.
struct HeardDevice {
    std::string link;
    std::uint8_t address = 0;

    auto operator<=>(const HeardDevice&) const = default;
};

class Telemetry {
public:
    static constexpr std::size_t max_limits = 16384, max_devices = 1024;    // further ones are not published

    /// `settings` must outlive it. `gateway`: a level; `stream` identifies this run of the program.
    Telemetry(const MqttSettings& settings, std::string gateway, std::string stream);

    /// Before the first frame, and whenever the layouts of the gateway change.
    void use(DecodingPtr decoding) { decoding_ = std::move(decoding); }
    /// The record of a frame that the gateway received on `link`; std::nullopt: it is not published.
    std::optional<Record> receive(std::string_view link, const FrameRecord& frame, ano::TimePoint now);

    const std::set<HeardDevice>& devices() const noexcept { return devices_; }
    std::uint64_t last_seq() const noexcept { return seq_; }

private:
    MessageLimit* limit_of(std::string_view link, std::uint8_t address, std::uint8_t id);
    std::string json(std::string_view link, const FrameRecord& frame, std::string_view device, ano::Encoding encoding) const;

    std::string gateway_, stream_;
    Topics topics_;
    std::array<MessageRule, 256> rules_;    // by the id of the message
    DecodingPtr decoding_;
    SenderEncodings encodings_;
    std::map<std::string, std::map<std::uint16_t, MessageLimit>, std::less<>> limits_;    // by link; then by address and id
    std::size_t limit_count_ = 0;
    std::set<HeardDevice> devices_;
    std::uint64_t seq_ = 0;
};

/// The rule of each message by its id.
std::array<MessageRule, 256> rules_by_id(const std::vector<MessageRule>& rules);

}    // namespace anogate
