// A link that is one stream of bytes: what serial ports and pseudo-terminals have in common.
#pragma once
#include <link/reconnect.hpp>
#include <link/stream_session.hpp>

namespace anogate {

class StreamLink : public Link, protected StreamSession {
public:
    StreamLink(LinkId id, LinkSettings settings, const LinkContext& context);

    void start() override;
    void stop_reading() override;
    void stop() override;
    void flush(Channel&) override { write(); }

protected:
    /// The open, non-blocking descriptor.
    virtual Opened<UniqueFd> open_wire() = 0;
    /// What the channel is called.
    virtual const std::string& peer() const = 0;
    /// What the open wire carries, in bytes/s, when it is to be given no more; 0: it takes what it takes.
    virtual std::uint32_t line_rate() const { return 0; }
    /// Leaves the wire as it should be found; the descriptor is closed right after.
    virtual void leave_wire(int) {}
    /// What a read that ends (`error` is 0) or fails means to the user.
    virtual LinkError why_gone(int error) const = 0;
    virtual void came_up() { context_.host.link_up(*this); }

    /// The wire is gone: closes it, says why, and tries again later.
    void fail(LinkError why);
    void opened() override;
    void read_ended(int error) override { fail(why_gone(error)); }
    void failed(int error) override { fail(why_gone(error)); }

private:
    Channel* channel_ = nullptr;
    Reconnect reconnect_;
};

}    // namespace anogate
