// A link that is a stream of bytes with one channel: what serial ports and pseudo-terminals have in common.
#pragma once
#include <link/descriptor.hpp>
#include <link/link_context.hpp>
#include <link/pacing.hpp>

#include <gateway/backoff.hpp>

#include <span>

#include <sys/uio.h>

namespace anogate {

class StreamLink : public Link {
public:
    StreamLink(LinkId id, LinkSettings settings, const LinkContext& context);

    void start() override;
    void stop_reading() override {
        descriptor_.stop_reading();
        retry_.cancel();
    }
    void stop() override;
    void flush(Channel& channel) override;

protected:
    /// The open, non-blocking descriptor, or nothing and why not.
    struct Opened {
        UniqueFd fd;
        std::string error;
    };
    virtual Opened open_wire() = 0;
    /// What the channel is called.
    virtual const std::string& peer() const = 0;
    /// writev() to the open descriptor.
    virtual ssize_t write_some(std::span<const iovec> pieces);
    /// What the open wire carries, in bytes/s, when it is to be given no more; 0: it takes what it takes.
    virtual std::uint32_t line_rate() const { return 0; }
    /// Bytes that the driver holds and has not put on the wire, where asking is cheap.
    virtual std::size_t held_by_driver() const { return 0; }
    /// Leaves the wire as it should be found; the descriptor is closed right after.
    virtual void leave_wire(int) {}
    /// What a read that ends (`error` is 0) or fails means to the user.
    virtual std::string gone_text(int error) const = 0;
    /// A read ended or failed.
    virtual void wire_ended(int error) { fail(gone_text(error)); }

    void pause_reading() { descriptor_.stop_reading(); }
    void resume_reading();
    /// What can be read now may be as old as a standstill, however much later it is read.
    void check_what_waits() { arrival_.unstamped(context_.host.turn()); }
    /// What came after the last whole frame has no rest to hope for.
    void end_of_input();
    /// The wire is gone: closes it, says why, and tries again later.
    void fail(std::string why);
    virtual void came_up() { context_.host.link_up(*this); }

    int fd() const noexcept { return descriptor_.fd(); }
    const Pacing& pacing() const noexcept { return pacing_; }

    LinkContext context_;

private:
    void try_open();
    void read();
    void deliver();
    void write();

    Descriptor descriptor_;
    Arrival arrival_;
    Channel* channel_ = nullptr;
    Backoff backoff_;
    Alarm retry_;
    Alarm expiry_;
    Pacing pacing_;
};

}    // namespace anogate
