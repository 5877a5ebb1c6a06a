// Owns the links, the channels and the router; the only place that sees them all.
#pragma once
#include <daemon/gpio.hpp>
#include <daemon/peer_log.hpp>
#include <daemon/standstill_log.hpp>
#include <gateway/alias.hpp>
#include <gateway/filter.hpp>
#include <gateway/held.hpp>
#include <gateway/hello.hpp>
#include <gateway/loop_guard.hpp>
#include <gateway/present_as.hpp>
#include <gateway/router.hpp>
#include <gateway/same_device.hpp>
#include <gateway/settings.hpp>
#include <gateway/untaken.hpp>
#include <link/alarm.hpp>
#include <link/datagram_batch.hpp>
#include <link/datagram_sender.hpp>
#include <link/link_context.hpp>
#include <link/tunnel_link.hpp>

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

/// A link and what became of it.
struct LinkState {
    std::unique_ptr<Link> link;
    bool up = false;
    bool was_up = false;    // at any time since the start
    TimePoint since{};      // of `up` or not
    std::string error;      // why it is not up
    ChannelSet channels;
    ReceiveCounters gone_received;       // of channels that are no more
    SendCounters gone_sent;              // and of frames for a link that had no channel
    std::uint64_t came_stale = 0;        // of what is `stale`: was so when it was to be sent here
    Untaken untaken;                     // of what came for hosts
    std::uint8_t group = 0;              // 1 to 64: its number; 0: none
    std::unique_ptr<Rules> rules;        // nullptr: none
    std::unique_ptr<Aliases> aliases;    // nullptr: none
    PresentAs* present_as = nullptr;     // nullptr: hosts appear as they are; the links of a group have one in common
    std::optional<Hello> hello;          // nothing: it never speaks first
};

/// One thread, one loop: everything is called from the io_context it was made with.
class Gateway final : public LinkHost, public TunnelHost {
public:
    /// `settings` must have been checked: names are unique, routes name links.
    Gateway(asio::io_context& io, Settings settings);
    ~Gateway();

    /// Opens every link, in the order of the configuration. `on_required_missing` is called with its name when a required
    /// link is not up 10 s later.
    void start(std::function<void(const std::string&)> on_required_missing);
    /// Reads no more, lets what waits leave for at most `patience`, closes everything and calls `on_stopped`; nothing of the
    /// gateway keeps the loop alive after that. A second call makes an end at once.
    void stop(Duration patience, std::function<void()> on_stopped);

    Channel* open_channel(Link& link, std::string peer) override;
    void close_channel(Channel& channel) override;
    void receive(Channel& from, ano::FrameView frame) override;
    void flush() override;
    void link_up(Link& link) override;
    void link_down(Link& link, std::string why) override;
    void report_unreachable(Link& link) override { router_.report_unreachable(link.id()); }
    TimePoint now() override { return now_ = Clock::now(); }
    const LoopWatch& turn() override;

    bool admit(Channel& from, ano::FrameView frame) override;
    bool admit_unopened(Channel& from, ano::FrameView frame) override;
    bool passes_loop_guard(Channel& from, ano::FrameView frame, LinkId to) override;
    bool may_leave(LinkId to, ano::FrameView frame) override;
    void learn(Channel& from, ano::FrameView frame) override;
    /// What the gateway itself says to the other end of `to`: it came by no channel and teaches no address. Counted, ruled and
    /// queued like any other frame; it leaves with the next flush().
    void say(ChannelId to, ano::FrameView frame);
    void send(LinkId to, ano::FrameView frame) override;
    bool is_own_port(std::uint16_t port) const override;

    const Settings& settings() const noexcept { return settings_; }
    const Router& router() const noexcept { return router_; }
    const SameDevice& same_device() const noexcept { return same_device_; }
    /// Whether the loop stood still.
    const LoopWatch& loop() const noexcept { return loop_; }
    const RingWatch& rings() const noexcept { return loop_guard_.rings(); }

    struct Claimant {
        LinkId link{};
        std::string peer;    // Channel::peer
    };
    /// Who claimed the address last, of a conflict of the router; nullptr: nobody did.
    const Claimant* claimant(const Conflict& conflict) const {
        return conflict.claimed ? &claimants_.at(conflict.address) : nullptr;
    }
    const std::vector<LinkState>& links() const noexcept { return links_; }
    /// Nothing when there is no tunnel.
    const TunnelLink* tunnel() const noexcept { return tunnel_; }
    Gpio& gpio() noexcept { return *gpio_; }
    const Channel& channel(ChannelId id) const { return *channels_[index(id)]; }
    TimePoint started_at() const noexcept { return started_at_; }

private:
    LinkState& state(const Link& link) { return links_[index(link.id())]; }
    LinkId link_named(const std::string& name) const;
    void add_links();
    void add_tunnel(const TunnelSettings& settings);
    void add_aliases();
    void add_presentations();
    void compare(const Channel& from, ano::FrameView frame, std::uint64_t key);
    bool came_before(Channel& from, ano::FrameView frame, ano::FrameView brought, QueuePolicy policy, const Said& said,
                     std::uint32_t& copies);
    void end_loop(Channel& from, ano::FrameView frame);
    void send_probe(ChannelId channel);
    void take_probe(Channel& from, ano::FrameView probe);
    bool hold(Channel& from, ano::FrameView brought, TimePoint due, Held::Repeats repeats = {});
    void receive_held(const Held::Frame& held);
    void release_held();
    void release_held_until(TimePoint due);
    void hurry(ChannelId from);
    void make_room_for(const Channel& from, ano::FrameView frame);
    void give_rules(LinkState& link, const RuleSettings& settings, bool sends_empty);
    void give_hello(LinkState& link, const LinkSettings& settings);
    void keep_from_tunnel(Route& route);
    void offer(ChannelId from, ChannelId to, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at);
    void ask(ChannelId from, Channel& channel, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at);
    bool is_stale(LinkId to, ano::FrameView frame) const;
    void beat();
    bool streams_speak() const;
    void hasten_beat();
    void stood_still(const LoopWatch::Turn& turn);
    void notice_standstill(LinkId from);
    void look_at_questions();
    void look_at_hellos();
    void await_hellos();
    void say_hello(ChannelId to);
    TimePoint heard_at(const LinkState& link) const;
    void refuse(LinkId to, std::uint64_t SendCounters::*cause);
    Said said_at(const Channel& from, ano::FrameView frame) const;
    void look_at_claims();
    void log_conflict();
    bool nothing_waits() const;
    void finish_stop();

    asio::io_context& io_;
    Settings settings_;
    AlarmClock alarms_;
    PeerLog peer_log_;
    DatagramBatch batch_;
    DatagramSender sender_;
    Router router_;
    LoopGuard loop_guard_;
    Held held_;    // for what the guard waits
    Alarm release_;
    bool releasing_ = false;
    bool hurrying_ = false;
    DuplicateGuard duplicates_;
    SameDevice same_device_;
    std::map<std::uint8_t, Claimant> claimants_;
    std::array<std::unique_ptr<Channel>, max_channels> channels_;
    ChannelSet used_;
    ChannelSet to_flush_;
    std::unique_ptr<Gpio> gpio_;
    std::vector<std::unique_ptr<PresentAs>> presentations_;
    std::vector<LinkState> links_;    // behind everything that a link refers to
    TunnelLink* tunnel_ = nullptr;    // one of links_
    LinkSet tunnelled_;               // whose tunnel frames it takes
    LinkSet ruled_;    // that have rules, aliases, another face of hosts, a hello, or devices that take few questions
    std::uint64_t frame_number_ = 0;
    TimePoint now_{};
    TimePoint arrived_at_{};    // what is being received had come then
    LoopWatch loop_;
    StandstillLog standstill_log_;
    Alarm beat_;
    bool noticed_ = false;    // a standstill, since the beat was due
    bool calm_ = true;        // no serial port or pty spoke lately: the beat is slow
    LinkSet streams_;         // serial ports and ptys
    TimePoint started_at_{};
    Alarm hello_due_;
    Alarm questions_due_;
    Alarm claims_due_;
    Alarm required_check_;
    Alarm stop_check_;
    std::function<void(const std::string&)> on_required_missing_;
    std::function<void()> on_stopped_;
    TimePoint stop_by_{};
};

}    // namespace anogate
