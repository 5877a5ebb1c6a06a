// What anogate-ros2 decides: which frame is published on which topic, and which message of a ROS 2 node becomes a frame. No I/O but
// through Bus and BridgeOutput, no clock.
#pragma once
#include <ano/time.hpp>
#include <gateway/frame_record.hpp>
#include <http/answer.hpp>
#include <record/decoding.hpp>
#include <record/sender_encodings.hpp>
#include <ros2/command_text.hpp>
#include <ros2/device_publisher.hpp>
#include <ros2/input_guard.hpp>
#include <ros2/line_limit.hpp>
#include <ros2/prefixes.hpp>
#include <ros2/velocity_control.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

class BridgeOutput {
public:
    virtual ~BridgeOutput() = default;
    /// Sends a frame to the gateway. False: it is not connected.
    virtual bool send(ano::Bytes frame) = 0;
    /// Starts a command of a device; `done` gets the response later. False: too many commands are running.
    virtual bool call(std::uint8_t address, const CommandText& command, std::function<void(const http::Outcome&)> done) = 0;
    virtual void log(std::string_view line) = 0;
    virtual void warn(std::string_view line) = 0;
};

/// What is known of a device from GET /devices.
struct DeviceNote {
    std::uint8_t address = 0;
    std::string name{};
};

class Bridge {
public:
    /// Both must outlive it; `settings`, too.
    Bridge(const Ros2Settings& settings, Bus& bus, BridgeOutput& output);
    ~Bridge();

    /// Before the first frame, and whenever the layouts of the gateway change.
    void use(DecodingPtr decoding);
    /// A frame that the gateway received on `link`.
    void receive(std::string_view link, const FrameRecord& record, ano::TimePoint now);
    void on_lost(std::uint64_t frames) noexcept { lost_ += frames; }
    /// A message of a ROS 2 node.
    void on_sample(const Sample& sample, ano::TimePoint now);
    /// At least every 100 ms.
    void on_time(ano::TimePoint now);
    void use(const std::vector<DeviceNote>& devices);
    /// Whether names of devices are needed that are not known.
    bool needs_names() const noexcept { return needs_names_; }

    /// `gateway`: empty while it is connected, else the reason. Publishes /diagnostics.
    void publish_diagnostics(const std::string& gateway, std::uint64_t time_ns, ano::TimePoint now);

    /// For --list: each topic with its type, its sources, its rate, and why it is silent.
    std::string list(ano::Duration watched) const;

private:
    struct InputState;
    struct Device;
    Device* device_of(std::string_view link, std::uint8_t address);
    void add_inputs(Device& device, const Ros2Device& entry);
    void subscribe(Device& device, Input input);
    InputFault on_velocity(Device& device, const Sample& sample, ano::TimePoint now);
    InputFault on_joy(Device& device, const Sample& sample);
    InputFault on_command(Device& device, const Sample& sample);
    void answer(const Device& device, const std::string& text);
    InputFault send(const Device& device, const VelocityFrame& frame);
    void log_publisher(InputState& input, const Device& device, ano::TimePoint now);
    void log_change(const InputState& input, const Device& device, const std::string& what, ano::TimePoint now);
    void append_status(const Device& device, ano::TimePoint now);
    void append_pair(std::string key, std::string value);

    BridgeOutput& output_;
    PublisherContext context_;
    Prefixes prefixes_;
    DecodingPtr decoding_;
    SenderEncodings encodings_;
    std::array<std::string, 256> names_{};    // of devices
    bool needs_names_ = false;
    std::map<std::string, std::unique_ptr<Device>> devices_;                 // by prefix
    std::map<std::pair<std::string, std::uint8_t>, Device*> ways_;           // by link and address
    std::map<std::pair<std::string, std::uint8_t>, std::string> refused_;    // why, by link and address
    std::map<std::size_t, std::pair<Device*, Input>> subscriptions_;
    std::uint64_t lost_ = 0;
    std::optional<Bus::Topic> diagnostics_;
    bool told_full_ = false;
    LineLimit changes_;    // of the publishers that control devices
};

}    // namespace anogate
