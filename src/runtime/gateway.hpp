// The central object of the program: owns the links and the Forwarder, and connects them with the loop: timers, GPIO, log.
#pragma once
#include <config/difference.hpp>
#include <gateway/forwarder.hpp>
#include <gateway/settings.hpp>
#include <gateway/v7_echo_watch.hpp>
#include <gpio/gpio.hpp>
#include <link/link_context.hpp>
#include <link/resolver.hpp>
#include <link/tunnel_link.hpp>
#include <link/udp/datagram_batch.hpp>
#include <link/udp/datagram_sender.hpp>
#include <record/decoding.hpp>
#include <runtime/config_state.hpp>
#include <runtime/decoding_in_use.hpp>
#include <runtime/gateway_parts.hpp>
#include <runtime/peer_log.hpp>
#include <runtime/restart_state.hpp>
#include <runtime/stall_watch.hpp>
#include <sys/alarm.hpp>

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

/// One thread, one loop: all functions are called from the io_context that was passed to the constructor.
class Gateway final : public LinkHost {
public:
    /// `settings` must have been checked: names are unique, routes name links.
    Gateway(asio::io_context& io, Settings settings);
    ~Gateway();

    /// Opens every link, in the order of the configuration, and continues from the state that the previous run stored; its
    /// descriptors that no link uses are closed. GatewayEvents::required_missing() is called when a required link is not up 10 s
    /// later.
    void start(RestartState stored = {});
    /// Stops reading, sends waiting frames for at most `patience`, closes everything and calls `on_stopped`; after that, no part
    /// of the gateway keeps the loop alive. A second call stops it at once.
    void stop(Duration patience, std::function<void()> on_stopped);

    /// Changes the settings. `settings` must have been checked; `difference` is the difference from settings(). Links that stay
    /// the same lose no frames. Frames that wait in links to be removed are sent for at most `patience`; then all changes are
    /// made in one turn of the loop, and `on_changed` is called. Not to be called from a callback of a link or an alarm of the
    /// gateway, nor while another change is in progress. If stop() was called before, nothing is changed.
    void change(Settings settings, Difference difference, Duration patience, std::function<void()> on_changed);

    const Settings& settings() const noexcept { return settings_; }
    DecodingInUse& layouts() noexcept { return layouts_; }
    const DecodingInUse& layouts() const noexcept { return layouts_; }
    /// The decoding of frames. Never nullptr; another object after a change.
    const DecodingPtr& decoding() const noexcept { return layouts_.decoding(); }
    Forwarder& forwarder() noexcept { return forwarder_; }
    const Forwarder& forwarder() const noexcept { return forwarder_; }
    GatewayParts& parts() noexcept { return parts_; }
    const GatewayParts& parts() const noexcept { return parts_; }
    const std::vector<LinkState>& links() const noexcept { return links_; }
    const Link& link(LinkId id) const { return *links_by_id_[index(id)]; }
    /// nullptr: none is configured.
    const TunnelLink* tunnel() const noexcept { return tunnel_; }
    /// The link `control`, created by the first call; nullptr: the maximum number of links is reached.
    ControlLink* control();
    Gpio& gpio() noexcept { return *gpio_; }
    asio::io_context& io() noexcept { return io_; }
    AlarmClock& alarms() noexcept { return alarms_; }
    /// Whether the running configuration is that of its file.
    const ConfigState& config_state() const noexcept { return config_state_; }
    void set_config_state(ConfigState state) { config_state_ = std::move(state); }
    TimePoint started_at() const noexcept { return started_at_; }

    /// The last reading of the clock.
    TimePoint time() const noexcept { return now_; }
    TimePoint now() override { return now_ = Clock::now(); }
    const StallDetector& turn() override;
    /// The detector of standstills of the loop.
    const StallDetector& loop() const noexcept { return beat_.loop(); }
    void flush() override;

private:
    Channel* open_channel(Link& link, std::string peer) override;
    void make_channel_free(PeerBook::Rank to) override;
    std::size_t free_channels() const override { return max_channels - forwarder_.channels().size(); }
    void leave_group(Channel& channel) override { forwarder_.leave_group(channel); }
    bool has_connected_mate(const Channel& channel) const override { return forwarder_.router().has_connected_mate(channel.id); }
    bool has_newer_command_of_mate(const Channel& channel, TimePoint since) const override {
        return forwarder_.router().has_newer_command_of_mate(channel.id, since);
    }
    void close_channel(Channel& channel, std::string_view why) override;
    void receive(Channel& from, ano::FrameView frame) override;
    void changed(Link& link, LinkEvent event, LinkError why) override;
    void came_up(Link& link);
    void went_down(Link& link, LinkError why);
    void log_trouble(Link& link, const LinkError& trouble);
    std::optional<StoredLink> claim_stored(const Link& link) override;
    bool is_own_port(std::uint16_t port) const override;
    ChannelSet busy_channels() const override;

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
    void forget_peer(const Channel& channel);

    std::vector<DecodingPtr> replayed() const;
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
    GatewayParts parts_;
    DecodingInUse layouts_{settings_, [this] { parts_.tell(&GatewayEvents::layouts_overruled); }};
    AlarmClock alarms_;
    PeerLog peer_log_;
    DatagramBatch batch_;
    DatagramSender sender_;
    Resolver names_{io_};
    V7Lines v7_lines_;
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
    std::function<void()> on_stopped_;
    RestartState stored_;    // until start() ends
    ClockReading unread_since_{};
    TimePoint stop_by_{};
    ConfigState config_state_;
    std::optional<Changing> changing_;
    Alarm change_check_;
    std::vector<std::unique_ptr<Link>> former_controls_;    // kept: a program that is connecting may still refer to one
    std::deque<Retired> retired_;    // removed objects, kept while the loop may still hold callbacks of them
    std::shared_ptr<bool> is_alive_ = std::make_shared<bool>(true);
};

}    // namespace anogate
