// A byte stream that carries the frames of one channel, from its opening to its end.
#pragma once
#include <gateway/arrival.hpp>
#include <link/link_context.hpp>
#include <link/pacing.hpp>
#include <link/raw_port.hpp>
#include <link/stored_link.hpp>
#include <link/v7_edge.hpp>
#include <sys/descriptor.hpp>

#include <sys/types.h>
#include <sys/uio.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace anogate {

/// The common part of serial ports, pseudo-terminals and connections. A link may have several; a link with one derives from it
/// (StreamLink). Must not be destroyed from within its own calls.
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
    /// To be called before open() for a descriptor of the previous run, or one that was read from before: its stored state.
    void go_on_from(StoredLink stored) { stored_ = std::move(stored); }
    /// To be called before open(): the devices use V7. Nothing happens unless `v7` is on.
    void translate(const V7LinkSettings& v7, const LinkSettings& link);
    bool is_open() const noexcept { return descriptor_.is_open(); }
    int fd() const noexcept { return descriptor_.fd(); }
    /// Sends the frames in the outbox: as many as can be written now, and the rest later.
    void write();
    virtual void close() noexcept;

    void pause_reading() { descriptor_.stop_reading(); }
    void resume_reading();
    /// Nothing more will be received: handles the bytes after the last complete frame.
    void end_of_input();
    /// As RawPort.
    void set_tap(RawTap* tap) noexcept { tap_ = tap; }
    bool write_raw(std::span<const std::uint8_t> bytes);

protected:
    /// Work before frames can be exchanged, such as connecting or a handshake. Called by open(), and again when the descriptor
    /// can be read or written, depending on the result. `failed`: see errno. `waits`: until continue_opening() is called.
    enum class Opening { done, wants_to_read, wants_to_write, waits, failed };
    virtual Opening go_on_opening() { return Opening::done; }
    /// The opening is done. Nothing is read before resume_reading(), except by the opening itself.
    virtual void opened() = 0;
    /// As read() and writev(): return the number of bytes, 0 at the end of input, or -1 and errno.
    virtual ssize_t read_some(std::span<std::uint8_t> room);
    virtual ssize_t write_some(std::span<const iovec> pieces);
    /// write_some() buffered bytes that are not yet written: it is called again, perhaps without data, when more can be written.
    virtual bool holds_bytes() const { return false; }
    /// write_some() accepted nothing (EAGAIN): arranges a call of write() when more can be written.
    virtual void write_later();
    /// Bytes in the driver that are not on the wire yet; 0 where asking is expensive.
    virtual std::size_t held_by_driver() const { return 0; }
    /// A valid frame was received.
    virtual void receive(ano::FrameView frame) { context_.host.receive(*channel_, frame); }
    /// A read failed, or reached the end of input (`error` is 0).
    virtual void read_ended(int error) = 0;
    /// A write or the opening failed.
    virtual void failed(int error) = 0;

    /// Reads even if the descriptor is not reported as readable.
    void read_again() {
        if (is_open() && !is_opening_) read();
    }
    bool is_opening() const noexcept { return is_open() && is_opening_; }
    void continue_opening();
    /// Data that is readable now may be as old as the last standstill; it is treated so, even if it is read later.
    void check_what_waits() { arrival_.unstamped(context_.host.turn()); }
    Pacing& pacing() noexcept { return pacing_; }
    const Pacing& pacing() const noexcept { return pacing_; }
    Channel& channel() noexcept { return *channel_; }
    /// The counters of the translation, where there is one.
    void add_facts(LinkFacts& facts) const {
        if (v7_) add_v7_facts(facts, v7_->counters());
    }
    /// nullptr: the devices use V8.
    const V7Edge* translation() const noexcept { return v7_.get(); }

    LinkContext context_;

private:
    void begin_input();
    void read();
    void deliver();
    bool write_held();
    void write_v7();
    void queue_v7();
    bool write_raw_first();
    void pass_to_tap(std::span<const std::span<const std::uint8_t>> frames, std::size_t bytes);

    Descriptor descriptor_;
    Arrival arrival_;
    Channel* channel_ = nullptr;
    Alarm expiry_;
    Pacing pacing_;
    RawTap* tap_ = nullptr;
    std::vector<std::uint8_t> raw_;    // written by hand; sent before the next frame
    bool is_opening_ = false;
    std::optional<StoredLink> stored_;
    std::unique_ptr<V7Edge> v7_;    // nullptr: the devices use V8
};

}    // namespace anogate
