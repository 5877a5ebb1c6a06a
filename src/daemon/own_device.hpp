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
    /// `kept_path`: kept_parameters_path(). Gateway and reload outlive it.
    OwnDevice(Gateway& gateway, Reload& reload, std::string kept_path);
    ~OwnDevice();
    OwnDevice(const OwnDevice&) = delete;
    OwnDevice& operator=(const OwnDevice&) = delete;

    /// The gateway ends: it says nothing more.
    void stop();

    void speak() override;
    void link_changed(const LinkState& link) override;
    void conflict_began(const std::string& what) override;
    void describe(nlohmann::ordered_json& gateway) const override;

private:
    void take(const Channel& from, ano::FrameView frame, TimePoint now) override;
    void apply(const WrittenValues& written) override;
    std::string save(const std::string& text) override;
    std::string reload() override;
    std::string restart(const std::string& link) override;
    std::string scan() override;
    std::string pulse(std::size_t line) override;
    std::vector<LinkSummary> summaries() override;
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

    /// A channel that something came by; its number among links is used once.
    struct Place {
        TimePoint opened_at{};
        Link link = 0;
    };

    Gateway& gateway_;
    Reload& reload_;
    std::string kept_path_;
    GatewayDevice device_{*this};
    std::array<Place, max_channels> places_{};
    Link places_used_ = 0;
    Alarm alarm_;
    Errand errand_;
    std::deque<std::string> saves_;    // the first is being written
    std::shared_ptr<bool> is_alive_ = std::make_shared<bool>(true);
};

}    // namespace anogate
