// Processes received frames: alias, guards, rules, tunnel, route, offer, in this order. It does no I/O and reads no clock.
//
// Flow:    const LinkId link = forwarder.add_link({...});
//          Channel* channel = forwarder.open_channel(link, peer, now);
//          forwarder.link_up(link, now);                         // its wire is connected
//          forwarder.receive(*channel, frame, now);              // each valid frame
//          while (Channel* to = forwarder.next_to_flush()) ...   // at the end of a batch: frames wait in its outbox
//          forwarder.tick(now);                                  // at due(), and send_hellos(now) at hello_due(); then flush
#pragma once
#include <ano/flush.hpp>
#include <ano/frame.hpp>
#include <ano/messages.hpp>
#include <ano/time.hpp>
#include <gateway/channel.hpp>
#include <gateway/duplicate_guard.hpp>
#include <gateway/forwarder_link.hpp>
#include <gateway/frame_key.hpp>
#include <gateway/hello.hpp>
#include <gateway/ids.hpp>
#include <gateway/inhibit.hpp>
#include <gateway/loop_guard.hpp>
#include <gateway/outbox_watch.hpp>
#include <gateway/present_as.hpp>
#include <gateway/router.hpp>
#include <gateway/same_device.hpp>
#include <gateway/settings.hpp>
#include <gateway/tunnel/tunnel_port.hpp>

#include <array>
#include <bitset>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

/// Neither throws nor allocates while the links and channels stay the same. Links and channels may be added and removed at any
/// time, except in a call to an observer or to the tunnel.
class Forwarder final : private OutboxWatch {
public:
    /// Called for each frame, as long as it is registered. It must not add or remove observers in a call.
    class Observer {
    public:
        /// Which functions are called. A function that no observer wants costs no time.
        struct Wants {
            bool arrivals = true;      // received()
            bool fates = true;         // passes(), offered(), dropped(), refused()
            bool departures = true;    // left(), discarded()
            bool always = false;       // runs as long as the gateway: not counted by is_observed()
            bool operator==(const Wants&) const = default;
        };

        /// A valid frame was received; `frame` is unchanged.
        virtual void received(const Channel& from, ano::FrameView frame, TimePoint arrived_at) = 0;
        /// The frame passed all checks and is routed; `frame` is as its receivers get it. True: it is an answer to the gateway
        /// itself, so it does not count as `no_route` when it has no other receiver.
        virtual bool passes(const Channel& /*from*/, ano::FrameView /*frame*/) { return false; }
        /// The frame waits in the outbox of `to`, or in the queue of questions before it; `frame` is as its receiver gets it.
        /// left() or discarded() follows. `from` may be `ourselves`.
        virtual void offered(const Channel& to, ano::FrameView frame, ChannelId from) = 0;
        /// A received frame was dropped.
        virtual void dropped(const Channel& from, ano::FrameView frame, ReceiveCause cause) = 0;
        /// The frame was to be sent on `to` and was refused.
        virtual void refused(LinkId to, ano::FrameView frame, SendCause cause) = 0;
        /// An offered frame was sent on `to`, or was dropped while it waited. Called by outboxes, so they must not throw.
        virtual void left(const Channel& /*to*/, ano::FrameView /*frame*/) noexcept {}
        virtual void discarded(const Channel& /*to*/, ano::FrameView /*frame*/, SendCause /*cause*/) noexcept {}
        /// The link was removed, with its channels.
        virtual void removed(LinkId /*link*/) {}

    protected:
        ~Observer() = default;
    };

    /// Receives the frames for the gateway itself, if it is a device.
    class Own {
    public:
        /// A frame for the gateway's id or for the broadcast address passed all checks. `from` may be `ourselves`. Answers must
        /// be sent later, outside of the calls of the Forwarder.
        virtual void take(const Channel& from, ano::FrameView frame, TimePoint now) = 0;

    protected:
        ~Own() = default;
    };

    /// `station` must be different in every gateway.
    Forwarder(const GatewaySettings& settings, std::uint64_t station);
    ~Forwarder();

    /// Returns the lowest free number; one must be free.
    LinkId add_link(const ForwarderLink& link);
    /// Closes its channels and erases all that is stored about it. Its number is free for another link then.
    void remove_link(LinkId link);
    /// Changes the settings and keeps the learned routes. set_unknown_link() must be called again.
    void set(const GatewaySettings& settings) { router_.set(settings); }
    /// The ids whose frames are treated differently from the message table.
    void set_classes(const std::vector<ClassSettings>& classes);
    void pin(std::uint8_t first, std::uint8_t last, LinkId link) { router_.pin(first, last, link); }
    /// Except for the aliases of the link, which stay pinned.
    void unpin(std::uint8_t first, std::uint8_t last, LinkId link);
    /// Erases the route of `address` and its last claimant. False: it had no route.
    bool forget(std::uint8_t address) {
        claimants_.erase(address);
        return router_.forget(address);
    }
    /// As in Router: restores the route of the open `channel` from an earlier run of the program.
    void restore(std::uint8_t address, const Channel& channel, TimePoint heard_at) {
        router_.restore(address, channel.id, heard_at);
    }
    void restore_last_homes(const std::bitset<256>& addresses, LinkId link) { router_.restore_last_homes(addresses, link); }
    void restore_first(std::uint8_t address, const Channel& channel) { router_.restore_first(address, channel.id); }
    /// The frames that a link of a group received after `since`. With them the next run of the program still detects the copies
    /// of other links of the group.
    std::vector<DuplicateGuard::Memory> brought_by(LinkId link, TimePoint since) const {
        return duplicates_.brought_by(link, since);
    }
    void restore(LinkId link, const DuplicateGuard::Memory& brought);
    /// For exclusive use: while a person writes to the devices of `link` manually, frames to it are dropped (denied_out).
    void set_exclusive(LinkId link, bool exclusive);
    bool is_exclusive(LinkId link) const noexcept;
    void set_unknown_link(LinkId link) { router_.set_unknown_link(link); }
    /// Makes `link`, which was added, the tunnel. Tunnel frames that are received on `carried` are sent by it. `port` must live
    /// until the link is removed. Another call changes the set of links.
    void set_tunnel(LinkId link, LinkSet carried, TunnelPort& port);

    /// nullptr: all 64 are in use. The channel lives until close_channel(), or until its link is removed. Its outbox is closed at
    /// first.
    Channel* open_channel(LinkId link, std::string peer, TimePoint now);
    /// Router::leave_group(), for a channel that was just opened.
    void leave_group(Channel& channel);
    void close_channel(Channel& channel);
    /// The wire of the link is connected: opens the outboxes of its channels. Call it again after a channel was opened.
    void link_up(LinkId link, TimePoint now);
    void link_down(LinkId link);
    /// The peer of `link` refuses the frames: another link of its group is tried.
    void report_unreachable(LinkId link) { router_.report_unreachable(link); }
    /// The clock did not count `time` (the machine was suspended): adds it to the age of all waiting frames.
    void grow_older(Duration time);
    /// The program is about to end: sends no more questions and awaits no answers.
    void stop_asking();

    /// Processes a valid frame that was received on `from`, at its `arrived_at`.
    void receive(Channel& from, ano::FrameView frame, TimePoint now);
    /// Sends a frame of the gateway itself on `to`. No address is learned from it. It is counted, filtered and queued like any
    /// other frame.
    void send_own(ChannelId to, ano::FrameView frame, TimePoint now);

    /// Routes a frame of the gateway itself. `from` is not one of the opened channels, and its id is `ourselves`. The rules and
    /// switches of its link apply, and it counts dropped frames. No address is learned from the frame.
    void send_on(Channel& from, ano::FrameView frame, TimePoint now);

    /// Sends zero bytes (Outbox::flush_parser()) on each line on which `frame`, the next one for send_on(), will be sent. If
    /// there are several lines, the result is that of the slowest.
    ano::Flush flush_parsers(LinkId from, ano::FrameView frame, TimePoint now);

    /// As say(), for an answer of the gateway itself, which may be received again on any link.
    void answer(ChannelId to, ano::FrameView frame, TimePoint now);
    /// Sends a frame of the gateway itself to a host: on each channel on which its destination was received, and on no other. No
    /// address is learned from it.
    void send_to_active_channels(ano::FrameView frame, TimePoint now);
    /// nullptr, the initial value: no call. `own` must outlive the Forwarder, or be replaced before.
    void set_own(Own* own) noexcept { own_ = own; }

    /// For the tunnel: whether a tunnel frame from it may be opened.
    bool admit(Channel& from, ano::FrameView frame, TimePoint now);
    /// Passes a frame from inside a tunnel frame, which was received on `from` and is sent by the tunnel, through all steps of
    /// receive() that may drop it. False: it was dropped, and counted.
    bool passes_into_tunnel(Channel& from, ano::FrameView inner, TimePoint now);
    /// The same for a frame that was received by the tunnel and is sent to the devices of `to` inside a tunnel frame.
    bool passes_to_wrap(Channel& from, ano::FrameView frame, LinkId to, TimePoint now);
    /// Learns that the source of the frame is behind `from`: answers are sent there.
    void learn(Channel& from, ano::FrameView frame, TimePoint now);
    /// Sends a tunnel frame with frames of passes_to_wrap() on each channel of `to`.
    void send(LinkId to, ano::FrameView frame, TimePoint now);

    /// A channel to whose outbox frames were added since it was last flushed; nullptr: none.
    Channel* next_to_flush() noexcept;
    /// When tick() must be called; std::nullopt: no time is set. The time may be too early, but is never too late.
    std::optional<TimePoint> due() const noexcept;
    void tick(TimePoint now);
    /// The same for send_hellos(), which may be called a little later.
    std::optional<TimePoint> hello_due() const noexcept { return hello_due_; }
    void send_hellos(TimePoint now);

    /// The next conflict that began and was not returned yet; for the log.
    std::optional<Conflict> pop_conflict();
    struct Claimant {
        LinkId link{};
        std::string peer;    // Channel::peer
    };
    /// The last claimant of the address; nullptr: none.
    const Claimant* claimant(const Conflict& conflict) const;

    /// Whether a frame received on `from` with this `source` has the address of a device that is at home elsewhere:
    /// Router::claims() for the address under which other links see it.
    bool is_elsewhere(const Channel& from, std::uint8_t source) const noexcept;

    /// As in Router; for the log.
    std::optional<Router::Moved> pop_move() noexcept { return router_.pop_move(); }

    /// Without observers, nothing is copied for them. If the observer is already registered, this changes its `wants`.
    void add_observer(Observer& observer, Observer::Wants wants);
    void add_observer(Observer& observer) { add_observer(observer, Observer::Wants{}); }
    void remove_observer(Observer& observer);
    bool is_observed() const noexcept { return observers_.size() > always_.size(); }
    /// Assigns the port id to the open channel alone.
    void bear(const Channel& channel, std::uint8_t port_id) { router_.bear(channel.id, port_id); }
    /// Changes whenever a link or a channel is added or removed.
    std::uint64_t version() const noexcept { return version_; }

    const LinkTraffic& traffic(LinkId link) const;
    const Channel& channel(ChannelId id) const { return *channels_[index(id)]; }
    ChannelSet channels() const noexcept { return used_; }
    const Router& router() const noexcept { return router_; }
    const SameDevice& same_device() const noexcept { return same_device_; }
    const LoopGuard& loops() const noexcept { return loop_guard_; }
    /// The switches that block control frames.
    Inhibit& inhibit() noexcept { return inhibit_; }

private:
    struct LinkEntry;
    LinkEntry& entry(LinkId link) noexcept { return *links_[index(link)]; }
    const LinkEntry& entry(LinkId link) const noexcept { return *links_[index(link)]; }

    QueuePolicy policy(ano::FrameView frame) const noexcept { return policies_[frame.id()]; }

    void left(ChannelId channel, ano::FrameView frame) noexcept override;
    void dropped(ChannelId channel, ano::FrameView frame, SendCause cause) noexcept override;
    void watch_outboxes() noexcept;

    // forwarder_links.cpp
    void present(LinkEntry& link);
    void forget_presentation(LinkEntry& link);

    void note_arrival(Channel& from) {
        arrived_at_ = std::min(from.arrived_at, now_);
        from.record_received(now_);
    }

    // forwarder.cpp: the steps
    void begin(Channel& from, ano::FrameView frame, TimePoint now);
    void replay(Channel& from, ano::FrameView frame);
    LoopGuard::Arrival arrival(const Channel& from, ano::FrameView frame, std::uint64_t key) const;
    void end_loop(Channel& from, ano::FrameView frame, ChannelSet ask);
    bool is_echo(Channel& from, ano::FrameView brought, std::uint64_t key) const;
    bool is_duplicate(Channel& from, ano::FrameView brought, std::uint64_t key, QueuePolicy policy);
    void compare(const Channel& from, ano::FrameView frame, std::uint64_t key);
    bool admit(Channel& from, ano::FrameView frame);
    bool admit_unopened(Channel& from, ano::FrameView frame);
    void pass_on(Channel& from, ano::FrameView frame, QueuePolicy policy, const LoopGuard::Arrival& arrival,
                 const LoopGuard::Judgement& judgement);
    void keep_from_tunnel(Route& route);
    void pass_to_own(const Channel& from, ano::FrameView frame, Via via) {
        if (own_ && (via == Via::own || via == Via::broadcast)) [[unlikely]]
            own_->take(from, frame, now_);
    }
    void note_receiver(Channel& from, ano::FrameView frame, const Route& route, bool is_ours);
    void drop_unrouted(Channel& from, ano::FrameView frame);
    void note_device(const Channel& from, ano::FrameView frame);
    void offer(ChannelId from, ChannelId to, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at);
    SendCause rewrite(LinkEntry& link, ano::FrameView& frame);
    void drop(Channel& from, ano::FrameView frame, ReceiveCause cause);
    void refuse(LinkId to, ano::FrameView frame, SendCause cause);

    // forwarder_tunnel.cpp
    bool passes_loop_guard(Channel& from, ano::FrameView frame, LinkId to);
    bool may_leave(LinkId to, ano::FrameView frame);
    void learn(Channel& from, ano::FrameView frame);

    // forwarder_questions.cpp
    void send_own(ChannelId to, ano::FrameView frame);
    void send_probes(ChannelId from, ChannelSet channels);
    void receive_probe(Channel& from, ano::FrameView probe);
    SendCause ask(ChannelId from, Channel& channel, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at);
    void release_questions();
    void ask_holders();
    void send_own_and_remember(ChannelId to, ano::FrameView frame);
    ano::Flush flush_parser(ChannelId to);
    TimePoint heard_at(const LinkEntry& link) const;
    void await_hellos();
    void note_claimants();

    static constexpr std::uint8_t firmware_id = ano::id_of<"firmware">;

    Router router_;
    std::array<QueuePolicy, 256> policies_ = policies;
    LoopGuard loop_guard_;
    DuplicateGuard duplicates_;
    SameDevice same_device_;
    Inhibit inhibit_;
    std::map<std::uint8_t, Claimant> claimants_;
    std::vector<std::unique_ptr<PresentAs>> presentations_;
    std::array<std::unique_ptr<LinkEntry>, max_links> links_;
    LinkSet added_;
    std::array<std::unique_ptr<Channel>, max_channels> channels_;
    ChannelSet used_;
    ChannelSet to_flush_;
    TunnelPort* tunnel_ = nullptr;
    LinkId tunnel_link_{};
    LinkSet carried_;    // the links whose tunnel frames are passed to the tunnel
    LinkSet ruled_;      // the links with rules, aliases, present_as, a hello, or devices that accept few questions at a time
    std::vector<Observer*> observers_;    // all
    std::vector<Observer*> arrival_observers_, fate_observers_, departure_observers_, always_;
    Own* own_ = nullptr;
    std::uint64_t frame_number_ = 0;
    bool to_one_place_ = false;    // the frame now offered goes to one receiver: only an echo returns it
    std::uint64_t version_ = 0;
    TimePoint now_{};
    TimePoint arrived_at_{};    // of the frame being received
    TimePoint questions_due_ = TimePoint::max();
    std::optional<TimePoint> hello_due_;
    bool asks_ = true;    // until stop_asking()
};

/// A link, and what processes its frames.
struct Forwarder::LinkEntry {
    ForwarderLink settings;
    LinkTraffic traffic;
    bool up = false;
    std::unique_ptr<Rules> rules;        // nullptr: none
    std::unique_ptr<Aliases> aliases;    // nullptr: none
    PresentAs* present_as = nullptr;     // nullptr: hosts keep their addresses; the links of a group share one
    std::optional<Hello> hello;          // std::nullopt: it never sends first
    bool exclusive = false;              // no frames are sent
    bool has_rules() const noexcept { return rules || aliases || present_as || hello || settings.limits_questions; }
};

inline const LinkTraffic& Forwarder::traffic(LinkId link) const { return entry(link).traffic; }

}    // namespace anogate
