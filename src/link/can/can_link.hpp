// A CAN interface, which may be absent, down, bus-off, removed or added again. The two subclasses put V8 frames into CAN frames.
#pragma once
#include <gateway/can_settings.hpp>
#include <gateway/can_stream.hpp>
#include <link/can/can_bus.hpp>
#include <link/can/can_socket.hpp>
#include <link/link_context.hpp>
#include <link/pacing.hpp>
#include <link/reconnect.hpp>
#include <sys/descriptor.hpp>

#include <memory>

namespace anogate {

class CanLink : public Link, public StorableLink {
public:
    CanLink(LinkId id, LinkSettings settings, const LinkContext& context);

    void start() override;
    void stop_reading() override;
    void stop() override;
    void flush(Channel&) override { write(); }
    LinkFacts facts() const override;
    LinkError trouble() const override;
    int storable_wire() const override { return descriptor_.fd(); }

protected:
    /// `stored` is used if it matches the settings.
    virtual Opened<UniqueFd> open_wire(UniqueFd stored) = 0;
    virtual void read() = 0;
    virtual void write() = 0;
    /// The interface was removed or is down: discards incomplete frames.
    virtual void lost() = 0;
    virtual void close_wire() noexcept { descriptor_.close(); }

    /// The connection is lost: closes it, reports `why`, and retries later.
    void fail(LinkError why);
    /// Nothing more can be sent now: calls write() when there is room. `kernel_notifies`: the kernel reports room (EAGAIN);
    /// otherwise it does not (ENOBUFS: the interface's own queue is full, perhaps with frames of other programs).
    void wait_for_room(bool kernel_notifies);
    /// A CAN frame was received from the bus.
    void heard_on_bus() noexcept;
    /// At least one CAN frame was sent.
    void found_room() noexcept;

    const CanSettings& can() const noexcept { return settings().as<CanSettings>(); }
    int fd() const noexcept { return descriptor_.fd(); }
    bool is_open() const noexcept { return descriptor_.is_open(); }
    Channel& channel() noexcept { return *channel_; }

    LinkContext context_;
    Descriptor descriptor_;
    Arrival arrival_;
    Pacing pacing_;    // on if `rate` is set

private:
    Opened<void> open();
    void watch_bus();
    void read_errors();
    void look_at_carrier();

    Descriptor errors_;    // a separate socket: error frames are needed with either framing, and while the link is down
    CanBus bus_;
    Channel* channel_ = nullptr;
    Reconnect reconnect_;
    Alarm again_;
    Alarm carrier_look_;
    Duration pause_;        // until the next try when the kernel does not report room
    bool woken_ = false;    // write() was called because of room, and has sent nothing since
    std::optional<TimePoint> blocked_since_;
    std::int64_t old_kernel_drops_ = 0;    // of closed sockets
};

/// framing=stream: uses a raw socket.
class CanStreamLink final : public CanLink {
public:
    CanStreamLink(LinkId id, const LinkSettings& settings, const LinkContext& context);
    ~CanStreamLink() override;
    void stop() override;
    LinkFacts facts() const override;

private:
    Opened<UniqueFd> open_wire(UniqueFd stored) override;
    void read() override;
    void write() override;
    void lost() override;
    void expire();
    void batch_ends();

    struct Batch;    // room for many CAN frames in one system call
    std::unique_ptr<Batch> batch_;
    CanCutter cutter_;
    CanStreams streams_;
    Alarm expiry_;
};

/// framing=isotp: one V8 frame is one PDU of the kernel's ISO-TP socket. For a single peer device.
class CanIsotpLink final : public CanLink {
public:
    CanIsotpLink(LinkId id, const LinkSettings& settings, const LinkContext& context);
    LinkFacts facts() const override;
    LinkError trouble() const override;

private:
    Opened<UniqueFd> open_wire(UniqueFd stored) override;
    void read() override;
    void write() override;
    void lost() override {}
    void close_wire() noexcept override;
    void transfer_failed(int error);

    std::int64_t transfer_errors_ = 0;
    LinkError trouble_;
};

}    // namespace anogate
