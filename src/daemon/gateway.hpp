// The program's middle: owns the links, the Forwarder and what they need of the loop: timers, GPIO, log.
#pragma once
#include <config/difference.hpp>
#include <daemon/config_state.hpp>
#include <daemon/gpio.hpp>
#include <daemon/loop_beat.hpp>
#include <daemon/peer_log.hpp>
#include <daemon/recording_figures.hpp>
#include <daemon/stored_state.hpp>
#include <gateway/forwarder.hpp>
#include <gateway/settings.hpp>
#include <link/alarm.hpp>
#include <link/datagram_batch.hpp>
#include <link/datagram_sender.hpp>
#include <link/link_context.hpp>
#include <link/tunnel_link.hpp>

#include <nlohmann/json_fwd.hpp>

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

class ControlLink;

/// A link and what became of it.
struct LinkState {
    std::unique_ptr<Link> link;
    bool up = false;
    bool was_up = false;       // at any time since the start
    bool must_come = false;    // it is `required`, and was there at the start
    TimePoint since{};         // of `up` or not
    LinkError error;           // why it is not up
};

/// The gateway as a device, as far as its loop has to know.
class GatewayVoice {
public:
    /// Whatever it has to say leaves now. Called behind every frame that came in, and at the end of every batch.
    virtual void speak() = 0;
    virtual void link_changed(const LinkState& link) = 0;
    virtual void conflict_began(const std::string& what) = 0;
    /// Adds what it has to the section `gateway` of the status.
    virtual void describe(nlohmann::ordered_json& gateway) const = 0;

protected:
    ~GatewayVoice() = default;
};

/// What records, as far as the loop and its reports have to know.
class RecordingService {
public:
    virtual void link_lost(const LinkState& link) = 0;
    /// What the configuration says to record, or would say by its defaults. Each says why not, in a clause; empty: it begins, or ends.
    virtual std::string start_recording() = 0;
    virtual std::string stop_recording() = 0;
    /// The section `recording` of the status.
    virtual void describe(nlohmann::ordered_json& recording) = 0;
    virtual RecordingFigures figures() = 0;

protected:
    ~RecordingService() = default;
};

/// One thread, one loop: everything is called from the io_context it was made with.
class Gateway final : public LinkHost {
public:
    /// `settings` must have been checked: names are unique, routes name links.
    Gateway(asio::io_context& io, Settings settings);
    ~Gateway();

    /// Opens every link, in the order of the configuration. `on_required_missing` is called with its name when a required
    /// link is not up 10 s later.
    void start(std::function<void(const std::string&)> on_required_missing);
    /// Before start(): what the program that ran before left. What no link has use for is closed by the end of start().
    void go_on_from(StoredState stored);
    /// What the program started next may go on from, when nothing is read any more: `call` is called before the links are closed.
    void before_closing(std::function<void()> call) { before_closing_ = std::move(call); }
    /// What speaks by itself is to end: `call` is called when stop() is, first of all.
    void before_stopping(std::function<void()> call) { before_stopping_ = std::move(call); }
    /// Reads no more, lets what waits leave for at most `patience`, closes everything and calls `on_stopped`; nothing of the
    /// gateway keeps the loop alive after that. A second call makes an end at once.
    void stop(Duration patience, std::function<void()> on_stopped);

    /// Has other settings from now on, without fault; `difference` is the way there from settings(). Links that stay the same lose
    /// nothing. What waits in those that go may leave for at most `patience`; then all is changed in one turn, and `on_changed` is
    /// called. To be called when no call of a link or an alarm of its own is under way, one after the other. Nothing comes of it
    /// when stop() is called before.
    void change(Settings settings, Difference difference, Duration patience, std::function<void()> on_changed);

    Channel* open_channel(Link& link, std::string peer) override;
    void close_channel(Channel& channel) override;
    void receive(Channel& from, ano::FrameView frame) override;
    void flush() override;
    void link_up(Link& link) override;
    void link_down(Link& link, LinkError why) override;
    void report_unreachable(Link& link) override { forwarder_.report_unreachable(link.id()); }
    std::optional<StoredLink> take_stored(const Link& link) override;
    bool is_own_port(std::uint16_t port) const override;
    ChannelSet busy_channels() const override;
    TimePoint now() override { return now_ = Clock::now(); }
    const LoopWatch& turn() override;

    /// Forgets where `address` was heard. False: it was nowhere.
    bool forget(std::uint8_t address) { return forwarder_.forget(address); }

    const Settings& settings() const noexcept { return settings_; }
    const Forwarder& forwarder() const noexcept { return forwarder_; }
    const Channel& channel(ChannelId id) const { return forwarder_.channel(id); }
    /// Whether the loop stood still.
    const LoopWatch& loop() const noexcept { return beat_.loop(); }
    const std::vector<LinkState>& links() const noexcept { return links_; }
    /// When it stopped to read, by stop().
    const ClockReading& unread_since() const noexcept { return unread_since_; }
    const LinkSettings& settings(LinkId link) const { return links_by_id_[index(link)]->settings(); }
    const std::string& name(LinkId link) const { return links_by_id_[index(link)]->name(); }
    /// nullptr when there is none.
    const TunnelLink* tunnel() const noexcept { return tunnel_; }
    asio::io_context& io() noexcept { return io_; }
    Gpio& gpio() noexcept { return *gpio_; }
    /// The link `control`, made when it is first asked for; nullptr: there is no place for one more link.
    ControlLink* control();
    AlarmClock& alarms() noexcept { return alarms_; }
    /// As of the Forwarder.
    void add_observer(Forwarder::Observer& observer, Forwarder::Observer::Wants wants = {}) {
        forwarder_.add_observer(observer, wants);
    }
    void remove_observer(Forwarder::Observer& observer) { forwarder_.remove_observer(observer); }
    /// nullptr: it is no device, as at first. `voice` outlives the gateway's last call, or is taken back.
    void set_voice(GatewayVoice* voice) noexcept { voice_ = voice; }
    const GatewayVoice* voice() const noexcept { return voice_; }
    /// nullptr: nothing records, as at first. As the voice.
    void set_recording(RecordingService* service) noexcept { recording_ = service; }
    RecordingService* recording() const noexcept { return recording_; }
    void set_own(Forwarder::Own* own) noexcept { forwarder_.set_own(own); }
    /// What the gateway itself says to who asked by the channel, and to hosts that were heard: as of the Forwarder.
    void answer(ChannelId to, ano::FrameView frame) { forwarder_.answer(to, frame, now()); }
    void say_to_heard(ano::FrameView frame) { forwarder_.say_to_heard(frame, now()); }
    /// Who asks devices in the name of the gateway, and may ask the gateway itself; empty: nobody.
    void on_answer_to_ourselves(std::function<void(ano::FrameView)> call) { hears_own_ = std::move(call); }
    void answer_ourselves(ano::FrameView frame) {
        if (hears_own_) hears_own_(frame);
    }
    /// And hears while it asks, in a clause, why the gateway does not do that.
    void on_refusal_to_ourselves(std::function<void(const std::string&)> call) { hears_refusal_ = std::move(call); }
    void refuse_ourselves(const std::string& why) {
        if (hears_refusal_) hears_refusal_(why);
    }
    /// Asks everybody who is there; `tell` gets a line for each that was heard. Why not, in a clause; empty: it begins.
    using Scan = std::function<std::string(const std::function<void(const std::string&)>& tell)>;
    void on_scan(Scan call) { scan_ = std::move(call); }
    std::string scan(const std::function<void(const std::string&)>& tell) {
        return scan_ ? scan_(tell) : "nothing here asks devices";
    }
    /// When the clock was looked at last.
    TimePoint time() const noexcept { return now_; }
    TimePoint started_at() const noexcept { return started_at_; }
    /// Whether what runs is what its file says.
    const ConfigState& config_state() const noexcept { return config_state_; }
    void set_config_state(ConfigState state) { config_state_ = std::move(state); }

private:
    // gateway_change.cpp
    struct Changing {    // waits for links that go
        Settings settings;
        Difference difference;
        std::function<void()> on_changed;
        TimePoint by{};
    };
    struct Retired {
        Gpio::Lines lines{};
        std::vector<std::unique_ptr<Link>> links{};    // end first: they may call lines
    };
    bool goes(const LinkState& state) const;
    void start(LinkState& state);
    void check_change();
    void finish_change();
    void unpin_routes();
    void remove_links(Retired& retired);
    void remove(LinkState& state, Retired& retired);
    void make_room_for_links(Retired& retired);
    void add_links(const Difference& difference, LinkSet& fresh);
    void put_links_in_order();
    void start_links(LinkSet fresh);
    void retire(Retired retired);
    void make_channel_free();

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
    bool streams_speak() const;
    void await_forwarder();
    void restore_addresses();
    void restore_addresses(const Link& link, const StoredState::OfLink& stored);
    void restore_brought();
    void check_required();
    bool nothing_waits(const LinkState& state) const;
    void check_stop();
    void finish_stop();

    asio::io_context& io_;
    Settings settings_;
    AlarmClock alarms_;
    PeerLog peer_log_;
    DatagramBatch batch_;
    DatagramSender sender_;
    Forwarder forwarder_;
    std::unique_ptr<Gpio> gpio_;
    std::vector<LinkState> links_;    // behind everything that a link refers to; in the order of the configuration
    std::array<Link*, max_links> links_by_id_{};
    std::vector<std::string> groups_{""};    // by number
    TunnelLink* tunnel_ = nullptr;           // one of links_
    ControlLink* control_ = nullptr;         // as well; nullptr: nobody used it yet
    LinkSet streams_;                        // serial ports and ptys
    TimePoint now_{};
    TimePoint started_at_{};
    LoopBeat beat_;
    Alarm forwarder_due_;
    Alarm hello_due_;
    Alarm required_check_;
    Alarm stop_check_;
    std::function<void(const std::string&)> on_required_missing_;
    std::function<void()> before_stopping_ = [] {};
    std::function<void()> before_closing_ = [] {};
    std::function<void()> on_stopped_;
    StoredState stored_;    // until start() ends
    ClockReading unread_since_{};
    TimePoint stop_by_{};
    ConfigState config_state_;
    GatewayVoice* voice_ = nullptr;
    RecordingService* recording_ = nullptr;
    std::function<void(ano::FrameView)> hears_own_;
    std::function<void(const std::string&)> hears_refusal_;
    Scan scan_;
    std::optional<Changing> changing_;
    Alarm change_check_;
    std::vector<std::unique_ptr<Link>> former_controls_;    // a program that joins now may still know of one
    std::deque<Retired> retired_;                           // what was removed, as long as the loop may hold calls of it
    std::shared_ptr<bool> is_alive_ = std::make_shared<bool>(true);
};

}    // namespace anogate
