// The host engine of the gateway: sends its frames through the link `control`, and receives frames as an observer of the
// Forwarder.
#pragma once
#include <devices/device_net.hpp>
#include <devices/device_service.hpp>
#include <gateway/drain_watch.hpp>
#include <gateway/forwarder.hpp>
#include <runtime/gateway_parts.hpp>
#include <sys/alarm.hpp>
#include <sys/background_task.hpp>

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class Gateway;

/// No cost while no request to a device is in progress, except during DeviceService::idle_after following the last one. Its
/// source address is not learned.
class GatewayDevices final : public DeviceNet, private Forwarder::Observer, private GatewayEvents, private ScanService {
public:
    /// `gateway` outlives it.
    explicit GatewayDevices(Gateway& gateway);
    ~GatewayDevices() override;

    DeviceService& service() noexcept { return service_; }
    /// To be called when the gateway stops.
    void stop();

    ano::TimePoint now() override;
    Unsent send(ano::FrameView frame) override;
    ano::Flush flush_parser(ano::FrameView next) override;
    bool is_waiting(std::uint8_t address) override;
    ano::Fault accepts_nothing(std::uint8_t address) override;
    void listen(bool wants) override;
    void wake(ano::TimePoint at) override { alarm_.set_no_later(at); }
    std::vector<HeardAddress> heard(ano::TimePoint now) override;
    ano::host::RouteInfo route_info(std::uint8_t address, ano::TimePoint now) override;
    std::vector<std::string> links_in_conflict(std::uint8_t address, ano::TimePoint now) override;
    bool is_same_device(std::uint8_t one, std::uint8_t other) override;
    bool may_answer_for(std::uint8_t source, std::uint8_t port) override;
    UnitPlace unit_place(std::uint8_t address, ano::TimePoint now) override;
    std::string date_text() override;
    void report(const std::string& text, bool is_warning) override;
    bool came_from(std::uint8_t address) override;
    DeviceLimits device_limits(std::uint8_t address) override;
    const ano::FlexibleLayouts& layouts() const override;
    bool may_have_waited(ano::TimePoint came_at) override;
    void keep(std::string name, std::string text, std::function<void(std::string fault)> done) override;
    std::string kept_path(const std::string& name) override;
    void aside(std::function<void()> work, std::function<void(std::string fault)> done) override;

private:
    void received(const Channel&, ano::FrameView, TimePoint) override {}
    bool passes(const Channel& from, ano::FrameView frame) override;
    void offered(const Channel& to, ano::FrameView frame, ChannelId from) override;
    void dropped(const Channel& from, ano::FrameView frame, ReceiveCause cause) override;
    void refused(LinkId to, ano::FrameView frame, SendCause cause) override;
    void left(const Channel& to, ano::FrameView frame) noexcept override;
    void discarded(const Channel& to, ano::FrameView frame, SendCause cause) noexcept override;

    /// A copy of a frame of send() that waits to be sent on one channel.
    struct Waiting {
        std::uint64_t number;    // of the frame
        std::vector<std::uint8_t> frame;
        ChannelId channel;
        std::vector<std::uint8_t> copy;    // with the address of an alias
    };
    /// A frame of send() of which all copies were dropped.
    struct Lost {
        std::uint64_t number;
        std::vector<std::uint8_t> frame;
        LinkId link;
        SendCause cause;
        std::string_view refusal;    // V7Notes::refusal
    };
    static constexpr std::size_t max_waiting = 64, max_lost = 16;
    std::vector<Waiting>::iterator find_waiting(const Channel& to, ano::FrameView frame) noexcept;
    Unsent unsent(const Lost& lost) const;
    /// Of the frame that was just passed to the links.
    Unsent lost_at_once();
    void report_lost();

    /// Stores the log lines of devices and checks values that have limits, also while the service does not listen.
    struct AlwaysListener final : Forwarder::Observer {
        explicit AlwaysListener(GatewayDevices& of) : of_{of} {}
        void received(const Channel&, ano::FrameView, TimePoint) override {}
        bool passes(const Channel& from, ano::FrameView frame) override;
        void offered(const Channel&, ano::FrameView, ChannelId) override {}
        void dropped(const Channel&, ano::FrameView, ReceiveCause) override {}
        void refused(LinkId, ano::FrameView, SendCause) override {}

    private:
        GatewayDevices& of_;
    };
    struct QueuedTask {
        std::function<void()> work;
        std::function<void(std::string)> done;
    };
    std::string scan(const std::function<void(const std::string&)>& on_found) override;
    void channel_lost(ChannelId lost) override;
    void own_answer(ano::FrameView frame) override;
    void own_refusal(const std::string& why) override;
    void stopping() override { stop(); }
    void start_next_task();
    void remember_notes();
    void remember_file(const std::string& folder, const std::string& name);
    void remember_note(const std::string& folder, const std::string& name, std::string text);
    LinkSet links_to(std::uint8_t address, ano::TimePoint now) const;
    /// The location of a device, as far as it distinguishes the device from others with its address.
    struct Place {
        std::string link, group;
        std::string peer;    // without its port
        bool has(const Gateway& gateway, const Channel& channel) const;
    };
    enum class Sender : std::uint8_t { itself, another, unknown };
    Sender sender(const Channel& from, std::uint8_t source);
    void log_unknown_sender(const Channel& from, std::uint8_t source);

    Gateway& gateway_;
    Alarm alarm_;
    BackgroundTask background_task_;
    std::deque<QueuedTask> queued_tasks_;    // waiting for background_task_
    bool listens_ = false;
    bool sends_ = false;
    LinkId heard_by_{};                   // link of the frame that the service is processing
    ChannelId heard_from_ = ourselves;    // its channel
    bool was_accepted_ = false;
    std::vector<std::uint8_t> sends_frame_;
    std::array<ChannelSet, 256> left_by_{};    // by destination: the channels of the last frame to it
    std::array<DrainWatch, max_channels> drains_{};
    Unsent refusal_;
    std::uint64_t sends_number_ = 0;
    std::vector<Waiting> waiting_;    // oldest first
    std::vector<Lost> lost_;
    DeviceService service_;    // its destructor calls this object, so only members that need it follow
    AlwaysListener always_;
    std::array<Place, 256> places_;    // by device: where it was last identified; no link: nowhere
};

}    // namespace anogate
