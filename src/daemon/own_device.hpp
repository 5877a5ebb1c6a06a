// The gateway as a device in the loop: what comes for it reaches the GatewayDevice, what that decides is done.
#pragma once
#include <daemon/errand.hpp>
#include <daemon/gateway.hpp>
#include <link/alarm.hpp>
#include <managed/gateway_device.hpp>

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace anogate {

class Reload;
struct ReloadOutcome;

/// What it says teaches no address, and passes the rules of the links that it leaves by.
class OwnDevice final : public GatewayVoice, private Forwarder::Own, private GatewayDeeds {
public:
    /// `kept_path`: kept_parameters_path(), where `kept` stands. Gateway and reload outlive it.
    OwnDevice(Gateway& gateway, Reload& reload, std::string kept_path, WrittenValues kept);
    ~OwnDevice();
    OwnDevice(const OwnDevice&) = delete;
    OwnDevice& operator=(const OwnDevice&) = delete;

    /// What runs is known: of what is kept, that goes which the configuration file has overruled, or it would be back when the file
    /// says again what it said.
    void keep_in_step();
    /// The gateway ends: it says nothing more.
    void stop();

    void speak() override;
    void link_changed(const LinkState& link) override;
    void conflict_began(const std::string& what) override;
    void describe(nlohmann::ordered_json& gateway) const override;

private:
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
    void refuse_ourselves(const std::string& why) override { gateway_.refuse_ourselves(why); }
    void warn(const std::string& line) override;

    using Link = GatewayDevice::Link;
    Link link_of(const Channel& channel);
    const Channel* channel_of(Link link) const;
    void configure();
    void tell(const std::string& line, GatewayDevice::LogColor color);
    void tell(const ReloadOutcome& outcome);
    void await();
    void answer_ourselves(ano::FrameView frame);
    void next_save();

    struct Save {
        WrittenValues values;
        bool is_asked_for = false;    // by a host, which waits
    };
    /// A channel that something came by; its number among links is used once.
    struct Place {
        TimePoint opened_at{};
        Link link = 0;
    };

    Gateway& gateway_;
    Reload& reload_;
    std::string kept_path_;
    WrittenValues kept_;    // on the disk
    GatewayDevice device_{*this};
    std::array<Place, max_channels> places_{};
    Link places_used_ = 0;
    Alarm alarm_;
    Errand errand_;
    std::deque<Save> saves_;    // the first is being written
    bool reloads_ = false;      // a host asked for it, and it is not over
    std::shared_ptr<bool> is_alive_ = std::make_shared<bool>(true);
};

}    // namespace anogate
