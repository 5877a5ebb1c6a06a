// A stream of bytes that carries the frames of one channel, from its opening to its end.
#pragma once
#include <gateway/arrival.hpp>
#include <link/descriptor.hpp>
#include <link/link_context.hpp>
#include <link/pacing.hpp>
#include <link/stored_link.hpp>

#include <sys/types.h>
#include <sys/uio.h>

#include <optional>
#include <span>

namespace anogate {

/// What serial ports, pseudo-terminals and connections have in common. A link may have one or many; a link of one is one itself
/// (StreamLink). Not to be destroyed by a call of its own.
///
/// Flow:    open(fd, channel) → go_on_opening()..., opened() → resume_reading() → read_ended() or failed() → close()
class StreamSession {
public:
    explicit StreamSession(const LinkContext& context);
    virtual ~StreamSession() = default;
    StreamSession(const StreamSession&) = delete;
    StreamSession& operator=(const StreamSession&) = delete;

    /// Takes `fd`, which must be non-blocking. `channel` lives until close().
    void open(UniqueFd fd, Channel& channel);
    /// Before open(): the descriptor was another program's until now, and this is what that left.
    void go_on_from(StoredLink stored) { stored_ = std::move(stored); }
    bool is_open() const noexcept { return descriptor_.is_open(); }
    int fd() const noexcept { return descriptor_.fd(); }
    /// Frames wait in the outbox: sends what the wire takes, and the rest when it takes more.
    void write();
    void close() noexcept;

    void pause_reading() { descriptor_.stop_reading(); }
    void resume_reading();
    /// What came after the last whole frame has no rest to hope for.
    void end_of_input();

protected:
    /// What is to be done before frames come and go, as a connection that is being made, or a handshake. Asked by open(), and again
    /// when the descriptor can be read or written, as it says. `failed`: errno says why.
    enum class Opening { done, wants_to_read, wants_to_write, failed };
    virtual Opening go_on_opening() { return Opening::done; }
    /// That is done. Nothing is read before resume_reading(), unless the opening had to read.
    virtual void opened() = 0;
    /// As read() and writev(): bytes, 0 for the end of input, or -1 and errno.
    virtual ssize_t read_some(std::span<std::uint8_t> room);
    virtual ssize_t write_some(std::span<const iovec> pieces);
    /// Bytes that the driver holds and has not put on the wire, where asking is cheap.
    virtual std::size_t held_by_driver() const { return 0; }
    /// A read ended (`error` is 0) or failed.
    virtual void read_ended(int error) = 0;
    /// A write failed, or the opening.
    virtual void failed(int error) = 0;

    /// What can be read now may be as old as a standstill, however much later it is read.
    void check_what_waits() { arrival_.unstamped(context_.host.turn()); }
    Pacing& pacing() noexcept { return pacing_; }
    const Pacing& pacing() const noexcept { return pacing_; }
    Channel& channel() noexcept { return *channel_; }

    LinkContext context_;

private:
    void continue_opening();
    void begin_input();
    void read();
    void deliver();

    Descriptor descriptor_;
    Arrival arrival_;
    Channel* channel_ = nullptr;
    Alarm expiry_;
    Pacing pacing_;
    bool is_opening_ = false;
    std::optional<StoredLink> stored_;
};

}    // namespace anogate
