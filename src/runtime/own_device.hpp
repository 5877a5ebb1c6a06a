// Connects the GatewayDevice (the gateway as an ANO device) with the loop: passes frames to it, and executes its operations.
#pragma once
#include <managed/gateway_device.hpp>
#include <runtime/gateway.hpp>
#include <sys/alarm.hpp>
#include <sys/background_task.hpp>

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace anogate {

class Reload;
struct ReloadOutcome;

/// The source address of its frames is not learned. The rules of the sending links apply to the frames.
class OwnDevice final : private GatewayEvents, private OwnFrames, private GatewayOperations {
public:
    /// `kept_path`: kept_parameters_path(), the file with `kept`. `gateway` and `reload` must outlive this object.
    OwnDevice(Gateway& gateway, Reload& reload, std::string kept_path, WrittenValues kept);
    ~OwnDevice();
    OwnDevice(const OwnDevice&) = delete;
    OwnDevice& operator=(const OwnDevice&) = delete;

    /// To be called when the running configuration is known. Removes kept values that the configuration file has overruled;
    /// otherwise they would take effect again when the file returns to its old value.
    void keep_in_step();

private:
    /// Nothing more is sent.
    void stopping() override;
    void send_waiting() override;
    void link_changed(const LinkState& link) override;
    void conflict_began(const std::string& what) override;
    void describe_gateway(nlohmann::ordered_json& gateway) const override;
    void take(const Channel& from, ano::FrameView frame, TimePoint now) override;
    void apply(const WrittenValues& written) override;
    std::string save(const WrittenValues& written) override;
    std::string reload() override;
    std::string restart(const std::string& link) override;
    std::string scan() override;
    std::string pulse(std::size_t line) override;
    std::string start_recording() override;
    std::string stop_recording() override;
    std::vector<LinkSummary> summaries() override;
    void refuse_ourselves(const std::string& why) override { gateway_.parts().tell(&GatewayEvents::own_refusal, why); }
    void warn(const std::string& line) override;

    using Link = GatewayDevice::Link;
    Link link_of(const Channel& channel);
    const Channel* channel_of(Link link) const;
    void configure();
    void take_frames(bool wants);
    void send_log(const std::string& line, GatewayDevice::LogColor color);
    void send_log(const ReloadOutcome& outcome);
    void await();
    void answer_ourselves(ano::FrameView frame);
    void next_save();

    struct Save {
        WrittenValues values;
        bool is_asked_for = false;    // a host is waiting for the answer
    };
    /// A channel that received frames for the gateway; its number as a `Link` is never reused.
    struct Place {
        TimePoint opened_at{};
        Link link = 0;
    };

    Gateway& gateway_;
    Reload& reload_;
    std::string kept_path_;
    WrittenValues kept_;    // as stored on the disk
    GatewayDevice device_{*this};
    std::array<Place, max_channels> places_{};
    Link places_used_ = 0;
    Alarm alarm_;
    BackgroundTask background_task_;
    std::deque<Save> saves_;    // the first one is being written
    bool reloads_ = false;      // a reload requested by a host is in progress
    std::shared_ptr<bool> is_alive_ = std::make_shared<bool>(true);
};

}    // namespace anogate
