// The central object of the program: owns the links and the Forwarder, and connects them with the loop: timers, GPIO, log.
#pragma once
#include <config/difference.hpp>
#include <gateway/forwarder.hpp>
#include <gateway/settings.hpp>
#include <gpio/gpio.hpp>
#include <link/link_context.hpp>
#include <link/resolver.hpp>
#include <link/tunnel_link.hpp>
#include <link/udp/datagram_batch.hpp>
#include <link/udp/datagram_sender.hpp>
#include <record/decoding.hpp>
#include <runtime/config_state.hpp>
#include <runtime/peer_log.hpp>
#include <runtime/recording_figures.hpp>
#include <runtime/restart_state.hpp>
#include <runtime/stall_watch.hpp>
#include <sys/alarm.hpp>

#include <nlohmann/json_fwd.hpp>

#include <bitset>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

class ControlLink;

/// A link and its state.
struct LinkState {
    std::unique_ptr<Link> link;
    bool up = false;
    bool was_up = false;         // at any time since the start
    bool was_brief = false;      // the last time it was up for less than `brief`
    bool is_logged = false;      // that it is up
    bool is_required = false;    // `required`, and configured at the start
    TimePoint since{};           // the last change of `up`
    LinkError error;             // the reason why it is not up, or was not the last time
};

/// The interface of the loop to the gateway as a device.
class GatewayEvents {
public:
    /// Sends all waiting frames. Called after every received frame, and at the end of every batch.
    virtual void send_waiting() = 0;
    virtual void link_changed(const LinkState& link) = 0;
    virtual void conflict_began(const std::string& what) = 0;
    /// Adds its entries to the section `gateway` of the status.
    virtual void describe(nlohmann::ordered_json& gateway) const = 0;

protected:
    ~GatewayEvents() = default;
};

/// The interface of the loop and its reports to the recordings.
class RecordingService {
public:
    virtual void link_lost(const LinkState& link) = 0;
    /// Start and stop the configured recording, or one with its defaults. Return empty, or a clause with the reason for the
    /// failure.
    virtual std::string start_recording() = 0;
    virtual std::string stop_recording() = 0;
    /// The section `recording` of the status.
    virtual void describe(nlohmann::ordered_json& recording) = 0;
    virtual RecordingFigures figures() = 0;

protected:
    ~RecordingService() = default;
};

/// One thread, one loop: all functions are called from the io_context that was passed to the constructor.
class Gateway final : public LinkHost {
public:
    /// `settings` must have been checked: names are unique, routes name links.
    Gateway(asio::io_context& io, Settings settings);
    ~Gateway();

    /// Opens every link, in the order of the configuration. `on_required_missing` is called with its name when a required
    /// link is not up 10 s later.
    void start(std::function<void(const std::string&)> on_required_missing);
    /// Before start(): continues from the state that the previous run stored. Descriptors that no link uses are closed by the end
    /// of start().
    void go_on_from(RestartState stored);
    /// `call` is called in stop(), after reading has ended and before the links are closed: it may store the state for the next
    /// run.
    void before_closing(std::function<void()> call) { before_closing_ = std::move(call); }
    /// `call` is called at the beginning of stop(): parts that send on their own must stop.
    void before_stopping(std::function<void()> call) { before_stopping_ = std::move(call); }
    /// Stops reading, sends waiting frames for at most `patience`, closes everything and calls `on_stopped`; after that, no part
    /// of the gateway keeps the loop alive. A second call stops it at once.
    void stop(Duration patience, std::function<void()> on_stopped);

    /// Changes the settings. `settings` must have been checked; `difference` is the difference from settings(). Links that stay
    /// the same lose no frames. Frames that wait in links to be removed are sent for at most `patience`; then all changes are
    /// made in one turn of the loop, and `on_changed` is called. Not to be called from a callback of a link or an alarm of the
    /// gateway, nor while another change is in progress. If stop() was called before, nothing is changed.
    void change(Settings settings, Difference difference, Duration patience, std::function<void()> on_changed);

    Channel* open_channel(Link& link, std::string peer) override;
    void make_channel_free(PeerBook::Rank to) override;
    std::size_t free_channels() const override { return max_channels - forwarder_.channels().size(); }
    void leave_group(Channel& channel) override { forwarder_.leave_group(channel); }
    bool has_connected_mate(const Channel& channel) const override { return forwarder_.router().has_connected_mate(channel.id); }
    void close_channel(Channel& channel, std::string_view why) override;
    void receive(Channel& from, ano::FrameView frame) override;
    void flush() override;
    void link_up(Link& link) override;
    void link_down(Link& link, LinkError why) override;
    void report_unreachable(Link& link) override { forwarder_.report_unreachable(link.id()); }
    void report_trouble(Link& link, const LinkError& trouble) override;
    std::optional<StoredLink> claim_stored(const Link& link) override;
    bool is_own_port(std::uint16_t port) const override;
    ChannelSet busy_channels() const override;
    TimePoint now() override { return now_ = Clock::now(); }
    const StallDetector& turn() override;

    /// Removes the learned route of `address`. False: there was none.
    bool forget(std::uint8_t address) { return forwarder_.forget(address); }

    const Settings& settings() const noexcept { return settings_; }
    /// The decoding of frames: the layouts of flexible messages, and the links with attitude=lx. Never nullptr; another object
    /// after a change.
    const DecodingPtr& decoding() const noexcept { return decoding_; }
    /// The number of changes of decoding().
    std::uint64_t decoding_changes() const noexcept { return decoding_changes_; }
    /// The layouts of set_flexible(), else those of the configuration. decoding() also has the layouts of replayed recordings for
    /// ids that have none here.
    const std::vector<ano::FlexibleSpec>& own_flexible() const noexcept { return flexible_ ? *flexible_ : settings_.flexible; }
    /// Uses these layouts until those of the configuration change.
    void set_flexible(std::vector<ano::FlexibleSpec> flexible);
    /// Whether layouts of set_flexible() are in use, which differ from the configuration.
    bool has_flexible_of_its_own() const noexcept { return flexible_.has_value(); }
    /// A configuration with other layouts is confirmed: drops the layouts that change() has set aside.
    void settle_flexible();
    /// The previous configuration is restored: restores the layouts that change() has set aside.
    void restore_flexible();
    /// `call` is called when layouts of set_flexible() are dropped because the configuration has changed.
    void on_flexible_overruled(std::function<void()> call) { on_flexible_overruled_ = std::move(call); }
    const Forwarder& forwarder() const noexcept { return forwarder_; }
    const Channel& channel(ChannelId id) const { return forwarder_.channel(id); }
    /// The detector of standstills of the loop.
    const StallDetector& loop() const noexcept { return beat_.loop(); }
    const std::vector<LinkState>& links() const noexcept { return links_; }
    /// The time at which stop() ended reading.
    const ClockReading& unread_since() const noexcept { return unread_since_; }
    const LinkSettings& settings(LinkId link) const { return links_by_id_[index(link)]->settings(); }
    const std::string& name(LinkId link) const { return links_by_id_[index(link)]->name(); }
    /// nullptr: none is configured.
    const TunnelLink* tunnel() const noexcept { return tunnel_; }
    asio::io_context& io() noexcept { return io_; }
    Gpio& gpio() noexcept { return *gpio_; }
    /// The link `control`, created by the first call; nullptr: the maximum number of links is reached.
    ControlLink* control();
    AlarmClock& alarms() noexcept { return alarms_; }
    /// As Forwarder::add_observer().
    void add_observer(Forwarder::Observer& observer, Forwarder::Observer::Wants wants = {}) {
        forwarder_.add_observer(observer, wants);
    }
    void remove_observer(Forwarder::Observer& observer) { forwarder_.remove_observer(observer); }
    /// As in the Forwarder.
    void set_exclusive(LinkId link, bool exclusive) { forwarder_.set_exclusive(link, exclusive); }
    /// nullptr (the default): the gateway is not a device. `events` must outlive the gateway, or be reset to nullptr.
    void set_events(GatewayEvents* events) noexcept { events_ = events; }
    const GatewayEvents* events() const noexcept { return events_; }
    /// nullptr (the default): no recordings. Lifetime as for set_events().
    void set_recording(RecordingService* service) noexcept { recording_ = service; }
    RecordingService* recording() const noexcept { return recording_; }
    void set_own(Forwarder::Own* own) noexcept { forwarder_.set_own(own); }
    /// Send frames of the gateway itself: to the sender of a request on that channel, and to all known hosts. As in the
    /// Forwarder.
    void answer(ChannelId to, ano::FrameView frame) { forwarder_.answer(to, frame, now()); }
    void send_to_active_channels(ano::FrameView frame) { forwarder_.send_to_active_channels(frame, now()); }
    /// `call` receives the gateway's own answers to requests that were sent in its own name. Empty: the answers are not needed.
    void on_answer_to_ourselves(std::function<void(ano::FrameView)> call) { on_own_answer_ = std::move(call); }
    void answer_ourselves(ano::FrameView frame) {
        if (on_own_answer_) on_own_answer_(frame);
    }
    /// `call` receives the reason, as a clause, when the gateway refuses a request that was sent in its own name.
    void on_refusal_to_ourselves(std::function<void(const std::string&)> call) { on_refusal_ = std::move(call); }
    void refuse_ourselves(const std::string& why) {
        if (on_refusal_) on_refusal_(why);
    }
    /// Sends a query to all devices; `on_found` receives one line for each answer. Returns empty, or a clause with the reason why the
    /// scan can't begin.
    using Scan = std::function<std::string(const std::function<void(const std::string&)>& on_found)>;
    void on_scan(Scan call) { scan_ = std::move(call); }
    /// `call` receives each channel whose connection is lost, or which is about to be closed.
    void on_loss(std::function<void(ChannelId)> call) { on_loss_ = std::move(call); }
    std::string scan(const std::function<void(const std::string&)>& on_found) {
        return scan_ ? scan_(on_found) : "requests to devices are not available here";
    }
    /// The last reading of the clock.
    TimePoint time() const noexcept { return now_; }
    TimePoint started_at() const noexcept { return started_at_; }
    /// Whether the running configuration is that of its file.
    const ConfigState& config_state() const noexcept { return config_state_; }
    void set_config_state(ConfigState state) { config_state_ = std::move(state); }

private:
    // gateway_change.cpp
    struct Changing {    // a change in progress, until links can be removed
        Settings settings;
        Difference difference;
        std::function<void()> on_changed;
        TimePoint by{};
    };
    struct LastHomes {
        LinkSettings link;
        std::bitset<256> addresses;
    };
    struct Retired {
        std::vector<LastHomes> homes{};
        Gpio::Lines lines{};
        std::vector<std::unique_ptr<Link>> links{};    // destroyed before the lines, which they may call
    };
    bool goes(const LinkState& state) const;
    void start(LinkState& state);
    void check_change();
    void finish_change();
    void unpin_routes();
    void remove_links(Retired& retired);
    void remove(LinkState& state, Retired& retired);
    void lose_channels_of(LinkId link);
    void restore_homes(const std::vector<LastHomes>& homes, LinkSet fresh);
    void make_room_for_links(Retired& retired);
    void add_links(const Difference& difference, LinkSet& fresh);
    void sort_links();
    void start_links(LinkSet fresh);
    void retire(Retired retired);
    void make_channel_free_for_link();

    void renew_decoding();
    std::uint8_t group_number(const std::string& group);
    LinkId add_link(const LinkSettings& settings);
    LinkId add_tunnel();
    LinkId add_control();
    void connect_tunnel();
    std::vector<TunnelLink::Target> wrap_targets() const;
    void pin_routes();
    void add(std::unique_ptr<Link> link);
    LinkState& state(const Link& link);
    Link& link_named(const std::string& name) const;
    void beat();
    bool streams_are_active() const;
    void await_forwarder();
    void restore_addresses();
    void restore_addresses(const Link& link, const RestartState::OfLink& stored);
    void restore_brought();
    void check_required();
    void log_up();
    static void log_up(LinkState& link);
    bool nothing_waits(const LinkState& state) const;
    void check_stop();
    void finish_stop();

    asio::io_context& io_;
    Settings settings_;
    std::optional<std::vector<ano::FlexibleSpec>> flexible_;    // instead of those in settings_
    struct SetAside {
        std::vector<ano::FlexibleSpec> flexible, of_file;
    };
    std::optional<SetAside> set_aside_;    // layouts of set_flexible(), and the configured ones at that time
    DecodingPtr decoding_ = decoding_of(settings_, settings_.flexible);
    std::uint64_t decoding_changes_ = 0;
    std::function<void()> on_flexible_overruled_;
    AlarmClock alarms_;
    PeerLog peer_log_;
    DatagramBatch batch_;
    DatagramSender sender_;
    Resolver names_{io_};
    Forwarder forwarder_;
    std::unique_ptr<Gpio> gpio_;
    std::vector<LinkState> links_;    // after all members that links refer to; in configuration order
    std::array<Link*, max_links> links_by_id_{};
    std::vector<std::string> groups_{""};    // by number
    TunnelLink* tunnel_ = nullptr;           // one of links_
    ControlLink* control_ = nullptr;         // one of links_; nullptr: not used yet
    LinkSet streams_;                        // serial ports and ptys
    TimePoint now_{};
    TimePoint started_at_{};
    StallWatch beat_;
    Alarm forwarder_due_;
    Alarm hello_due_;
    Alarm required_check_;
    Alarm log_up_later_;
    Alarm stop_check_;
    std::function<void(const std::string&)> on_required_missing_;
    std::function<void()> before_stopping_ = [] {};
    std::function<void()> before_closing_ = [] {};
    std::function<void()> on_stopped_;
    RestartState stored_;    // until start() ends
    ClockReading unread_since_{};
    TimePoint stop_by_{};
    ConfigState config_state_;
    GatewayEvents* events_ = nullptr;
    RecordingService* recording_ = nullptr;
    std::function<void(ano::FrameView)> on_own_answer_;
    std::function<void(const std::string&)> on_refusal_;
    Scan scan_;
    std::function<void(ChannelId)> on_loss_;
    std::optional<Changing> changing_;
    Alarm change_check_;
    std::vector<std::unique_ptr<Link>> former_controls_;    // kept: a program that is connecting may still refer to one
    std::deque<Retired> retired_;    // removed objects, kept while the loop may still hold callbacks of them
    std::shared_ptr<bool> is_alive_ = std::make_shared<bool>(true);
};

}    // namespace anogate
