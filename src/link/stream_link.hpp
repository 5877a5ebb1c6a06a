// A link that is one byte stream: the common part of serial ports and pseudo-terminals.
#pragma once
#include <link/reconnect.hpp>
#include <link/stream_session.hpp>

namespace anogate {

class StreamLink : public Link, public RawPort, protected StreamSession {
public:
    StreamLink(LinkId id, LinkSettings settings, const LinkContext& context);

    void start() override;
    void stop_reading() override;
    void stop() override;
    void flush(Channel&) override { write(); }
    void set_tap(RawTap* tap) override { StreamSession::set_tap(tap); }
    bool write_raw(std::span<const std::uint8_t> bytes) override { return StreamSession::write_raw(bytes); }

protected:
    /// Opens the descriptor, which must be non-blocking.
    virtual Opened<UniqueFd> open_wire() = 0;
    /// The name of the channel.
    virtual const std::string& peer() const = 0;
    /// The rate in bytes/s to which sending is limited; 0: not limited.
    virtual std::uint32_t line_rate() const { return 0; }
    /// Called right before the descriptor is closed, to restore the device.
    virtual void leave_wire(int) {}
    /// The text for a read that failed, or that reached the end (`error` is 0).
    virtual LinkError why_gone(int error) const = 0;
    virtual void came_up() { context_.host.link_up(*this); }

    /// The connection is lost: closes it, reports `why`, and retries later.
    void fail(LinkError why);
    void opened() override;
    void read_ended(int error) override { fail(why_gone(error)); }
    void failed(int error) override { fail(why_gone(error)); }

private:
    Channel* channel_ = nullptr;
    Reconnect reconnect_;
};

}    // namespace anogate
