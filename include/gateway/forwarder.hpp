// What becomes of a frame that came in: alias, guards, rules, tunnel, route, offer, in this order. It does no I/O and reads no
// clock.
//
// Flow:    const LinkId link = forwarder.add_link({...});
//          Channel* channel = forwarder.open_channel(link, peer, now);
//          forwarder.link_up(link, now);                         // its wire is there
//          forwarder.receive(*channel, frame, now);              // every good frame
//          while (Channel* to = forwarder.next_to_flush()) ...   // at the end of a batch: frames wait in its outbox
//          forwarder.tick(now);                                  // at due(), and say_hellos(now) at hello_due(); then flush
#pragma once
#include <ano/frame.hpp>
#include <ano/messages.hpp>
#include <ano/time.hpp>
#include <gateway/channel.hpp>
#include <gateway/duplicate_guard.hpp>
#include <gateway/forwarder_link.hpp>
#include <gateway/held.hpp>
#include <gateway/hello.hpp>
#include <gateway/ids.hpp>
#include <gateway/inhibit.hpp>
#include <gateway/loop_guard.hpp>
#include <gateway/outbox_watch.hpp>
#include <gateway/present_as.hpp>
#include <gateway/router.hpp>
#include <gateway/same_device.hpp>
#include <gateway/settings.hpp>
#include <gateway/tunnel_port.hpp>

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

/// Neither throws nor allocates while the links and channels stay the same. Links and channels come and go at any time but
/// inside a call of an observer or of the tunnel.
class Forwarder final : private OutboxWatch {
public:
    /// Is told of every frame, as long as it is registered. It neither adds nor removes observers in a call.
    class Observer {
    public:
        /// Of what it is told. What nobody wants costs a frame nothing.
        struct Wants {
            bool arrivals = true;      // received()
            bool fates = true;         // passes(), offered(), dropped(), refused()
            bool departures = true;    // left(), gave_up()
            bool operator==(const Wants&) const = default;
        };

        /// A good frame came in, as it was sent.
        virtual void received(const Channel& from, ano::FrameView frame, TimePoint arrived_at) = 0;
        /// Nothing keeps it back: it goes to whom it concerns, as these are to see it. True: it is an answer to the gateway itself, so
        /// it has a taker even when nobody else wants it.
        virtual bool passes(const Channel& /*from*/, ano::FrameView /*frame*/) { return false; }
        /// It waits in the outbox of `to`, or in the queue of questions before it, as its receiver will see it. left() or
        /// gave_up() tell what becomes of it there. `from` may be `ourselves`.
        virtual void offered(const Channel& to, ano::FrameView frame, ChannelId from) = 0;
        /// What came in goes no further. A frame that was withheld and whose next never came is counted `looped` without this.
        virtual void dropped(const Channel& from, ano::FrameView frame, ReceiveCause cause) = 0;
        /// It was to leave by `to` and does not.
        virtual void refused(LinkId to, ano::FrameView frame, SendCause cause) = 0;
        /// What was offered left by `to`, or was dropped while it waited. Outboxes tell it: these must not throw.
        virtual void left(const Channel& /*to*/, ano::FrameView /*frame*/) noexcept {}
        virtual void gave_up(const Channel& /*to*/, ano::FrameView /*frame*/, SendCause /*cause*/) noexcept {}
        /// The link is gone, with its channels.
        virtual void removed(LinkId /*link*/) {}

    protected:
        ~Observer() = default;
    };

    /// What the gateway itself is told, where it is a device.
    class Own {
    public:
        /// Nothing kept it back: it is for the gateway's id, or for everybody. `from` may be `ourselves`. Whatever is to be said to it
        /// is said later, outside the calls of the Forwarder.
        virtual void take(const Channel& from, ano::FrameView frame, TimePoint now) = 0;

    protected:
        ~Own() = default;
    };

    /// `station` is a number that no other gateway has.
    Forwarder(const GatewaySettings& settings, std::uint64_t station);
    ~Forwarder();

    /// The lowest number that is free; there is one.
    LinkId add_link(const ForwarderLink& link);
    /// Closes its channels and forgets all that is known of it: another that gets its number starts anew.
    void remove_link(LinkId link);
    /// Other settings from now on; what was learned stays. set_unknown_link() is to be called anew.
    void set(const GatewaySettings& settings) { router_.set(settings); }
    void pin(std::uint8_t first, std::uint8_t last, LinkId link) { router_.pin(first, last, link); }
    /// But for the aliases of the link, which stay pinned.
    void unpin(std::uint8_t first, std::uint8_t last, LinkId link);
    /// Where `address` was heard, and who claimed it. False: it was nowhere.
    bool forget(std::uint8_t address) {
        claimants_.erase(address);
        return router_.forget(address);
    }
    /// As of the Router: what was known of `channel`, which is open, when the program ran before.
    void restore(std::uint8_t address, const Channel& channel, TimePoint heard_at) {
        router_.restore(address, channel.id, heard_at);
    }
    void restore_first(std::uint8_t address, const Channel& channel) { router_.restore_first(address, channel.id); }
    /// What a link of a group brought behind `since`, and the same when the program ran before: a copy by another member is one still.
    std::vector<DuplicateGuard::Memory> brought_by(LinkId link, TimePoint since) const {
        return duplicates_.brought_by(link, since);
    }
    void restore(LinkId link, const DuplicateGuard::Memory& brought);
    void set_unknown_link(LinkId link) { router_.set_unknown_link(link); }
    /// `link`, that was added, is the tunnel; tunnel frames that come by `carried` leave by it. `port` lives until the link is
    /// removed. Called again, it changes what is carried.
    void set_tunnel(LinkId link, LinkSet carried, TunnelPort& port);

    /// nullptr: all 64 are in use. It lives until close_channel(), or until its link is removed; its outbox starts closed.
    Channel* open_channel(LinkId link, std::string peer, TimePoint now);
    void close_channel(Channel& channel);
    /// The wire of the link is there: opens the outboxes of its channels. To be called again for a channel that is new.
    void link_up(LinkId link, TimePoint now);
    void link_down(LinkId link);
    /// What went out by `link` did not arrive: its peer refuses. Another link of its group may do better.
    void report_unreachable(LinkId link) { router_.report_unreachable(link); }
    /// The clock stood still for `time`, though it passed: all that waits is that much older.
    void grow_older(Duration time);
    /// The end is near: nothing is asked any more, and no answer awaited.
    void stop_asking();

    /// A good frame came by `from`, whose `arrived_at` says when.
    void receive(Channel& from, ano::FrameView frame, TimePoint now);
    /// What the gateway itself says to the other end of `to`: it came by no channel and teaches no address. Counted, ruled and
    /// queued like any other frame.
    void say(ChannelId to, ano::FrameView frame, TimePoint now);

    /// What the gateway itself sends to whom it concerns. `from` is none of the channels that were opened, its id is `ourselves`: it
    /// has the rules and the switches of its link, and counts what is kept back. The frame teaches no address.
    void send_on(Channel& from, ano::FrameView frame, TimePoint now);

    /// The same for what may come back by any link: an answer to who asked the gateway itself.
    void answer(ChannelId to, ano::FrameView frame, TimePoint now);
    /// What the gateway itself says to hosts, addressed to one: to every channel where that was heard. Nobody who was not heard gets
    /// it, and it teaches no address.
    void say_to_heard(ano::FrameView frame, TimePoint now);
    /// nullptr: nobody is told, as at first. It outlives the Forwarder, or is taken back.
    void set_own(Own* own) noexcept { own_ = own; }

    /// For the tunnel. A tunnel frame came by it: whether it may be opened.
    bool admit(Channel& from, ano::FrameView frame, TimePoint now);
    /// A frame inside a tunnel frame that came by `from` and leaves by the tunnel takes all steps of receive() that keep one
    /// back. False: it does not leave, and was counted.
    bool passes_into_tunnel(Channel& from, ano::FrameView inner, TimePoint now);
    /// The same for one that came by the tunnel and is to go to the devices of `to` inside a tunnel frame.
    bool passes_to_wrap(Channel& from, ano::FrameView frame, LinkId to, TimePoint now);
    /// The source of the frame is behind `from`: answers go there.
    void learn(Channel& from, ano::FrameView frame, TimePoint now);
    /// To every channel of `to`: a tunnel frame of passes_to_wrap().
    void send(LinkId to, ano::FrameView frame, TimePoint now);

    /// A channel in whose outbox frames wait since it was flushed last; nullptr: none.
    Channel* next_to_flush() noexcept;
    /// When tick() has something to do; nothing: not by itself. It may come too early, never too late.
    std::optional<TimePoint> due() const noexcept;
    void tick(TimePoint now);
    /// The same for say_hellos(), which may come a little later.
    std::optional<TimePoint> hello_due() const noexcept { return hello_due_; }
    void say_hellos(TimePoint now);

    /// The next conflict that began and was not taken yet; for the log.
    std::optional<Conflict> take_conflict();
    struct Claimant {
        LinkId link{};
        std::string peer;    // Channel::peer
    };
    /// Who claimed the address last; nullptr: nobody did.
    const Claimant* claimant(const Conflict& conflict) const;

    /// While there is none, nothing is told and nothing copied. One that is there already is told of other things from now on.
    void add_observer(Observer& observer, Observer::Wants wants);
    void add_observer(Observer& observer) { add_observer(observer, Observer::Wants{}); }
    void remove_observer(Observer& observer);
    bool is_observed() const noexcept { return !observers_.empty(); }
    /// The open channel bears the port id, by itself.
    void bear(const Channel& channel, std::uint8_t port_id) { router_.bear(channel.id, port_id); }
    /// Another number whenever a link or a channel has come or gone.
    std::uint64_t version() const noexcept { return version_; }

    const LinkTraffic& traffic(LinkId link) const;
    const Channel& channel(ChannelId id) const { return *channels_[index(id)]; }
    ChannelSet channels() const noexcept { return used_; }
    const Router& router() const noexcept { return router_; }
    const SameDevice& same_device() const noexcept { return same_device_; }
    const RingWatch& rings() const noexcept { return loop_guard_.rings(); }
    /// The switches that keep control frames off.
    Inhibit& inhibit() noexcept { return inhibit_; }

private:
    struct LinkEntry;
    LinkEntry& entry(LinkId link) noexcept { return *links_[index(link)]; }
    const LinkEntry& entry(LinkId link) const noexcept { return *links_[index(link)]; }

    void left(ChannelId channel, ano::FrameView frame) noexcept override;
    void dropped(ChannelId channel, ano::FrameView frame, SendCause cause) noexcept override;
    void watch_outboxes() noexcept;

    // forwarder_links.cpp
    void present(LinkEntry& link);
    void forget_presentation(LinkEntry& link);

    void note_arrival(Channel& from) {
        arrived_at_ = std::min(from.arrived_at, now_);
        from.hear(now_);
    }

    // forwarder.cpp: the steps
    void begin(Channel& from, ano::FrameView frame, TimePoint now);
    void replay(Channel& from, ano::FrameView frame);
    Said said_at(const Channel& from, ano::FrameView frame, std::uint64_t key) const;
    bool goes_round(Channel& from, ano::FrameView frame, ano::FrameView brought, const Said& said, std::uint32_t& copies);
    void end_loop(Channel& from, ano::FrameView frame);
    bool is_duplicate(Channel& from, ano::FrameView brought, std::uint64_t key, QueuePolicy policy);
    void compare(const Channel& from, ano::FrameView frame, std::uint64_t key);
    bool admit(Channel& from, ano::FrameView frame);
    bool admit_unopened(Channel& from, ano::FrameView frame);
    void pass_on(Channel& from, ano::FrameView frame, QueuePolicy policy, const Said& said, std::uint32_t copies);
    void keep_from_tunnel(Route& route);
    void tell_own(const Channel& from, ano::FrameView frame, Via via) {
        if (own_ && (via == Via::own || via == Via::broadcast)) [[unlikely]]
            own_->take(from, frame, now_);
    }
    void note_taker(Channel& from, ano::FrameView frame, const Route& route, bool is_ours);
    void offer(ChannelId from, ChannelId to, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at);
    SendCause rewrite(LinkEntry& link, ano::FrameView& frame);
    void drop(Channel& from, ano::FrameView frame, ReceiveCause cause);
    void refuse(LinkId to, ano::FrameView frame, SendCause cause);

    // forwarder_tunnel.cpp
    bool passes_loop_guard(Channel& from, ano::FrameView frame, LinkId to);
    bool may_leave(LinkId to, ano::FrameView frame);
    void learn(Channel& from, ano::FrameView frame);

    // forwarder_held.cpp
    static bool keeps_order(ano::FrameView frame) noexcept;
    bool hold(Channel& from, ano::FrameView brought, TimePoint due, Held::Repeats repeats = {});
    void make_room_for(const Channel& from, ano::FrameView frame);
    void hurry(ChannelId from);
    void receive_held(const Held::Frame& held);
    void release_held_until(TimePoint due);

    // forwarder_questions.cpp
    void say(ChannelId to, ano::FrameView frame);
    void send_probe(ChannelId channel);
    void take_probe(Channel& from, ano::FrameView probe);
    SendCause ask(ChannelId from, Channel& channel, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at);
    void release_questions();
    void ask_holders();
    void say_and_remember(ChannelId to, ano::FrameView frame);
    TimePoint heard_at(const LinkEntry& link) const;
    void await_hellos();
    void note_claimants();

    static constexpr std::uint8_t firmware_id = ano::id_of<"firmware">;

    Router router_;
    LoopGuard loop_guard_;
    Held held_;    // for what the guard waits
    bool releasing_ = false;
    bool hurrying_ = false;
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
    LinkSet carried_;    // whose tunnel frames the tunnel takes
    LinkSet ruled_;      // that have rules, aliases, another face of hosts, a hello, or devices that take few questions
    std::vector<Observer*> observers_;    // all
    std::vector<Observer*> hear_arrivals_, hear_fates_, hear_departures_;
    Own* own_ = nullptr;
    std::uint64_t frame_number_ = 0;
    std::uint64_t version_ = 0;
    TimePoint now_{};
    TimePoint arrived_at_{};    // what is being received had come then
    TimePoint questions_due_ = TimePoint::max();
    std::optional<TimePoint> hello_due_;
    bool asks_ = true;    // until the end is near
};

/// A link and what its frames pass.
struct Forwarder::LinkEntry {
    ForwarderLink settings;
    LinkTraffic traffic;
    bool up = false;
    std::unique_ptr<Rules> rules;        // nullptr: none
    std::unique_ptr<Aliases> aliases;    // nullptr: none
    PresentAs* present_as = nullptr;     // nullptr: hosts appear as they are; the links of a group have one in common
    std::optional<Hello> hello;          // nothing: it never speaks first
};

inline const LinkTraffic& Forwarder::traffic(LinkId link) const { return entry(link).traffic; }

}    // namespace anogate
