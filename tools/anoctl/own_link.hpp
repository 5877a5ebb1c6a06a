// A link that this process opens itself, without a gateway.
#pragma once
#include "anoctl.hpp"
#include "frame_receiver.hpp"

#include <ano/flush.hpp>
#include <ano/time.hpp>
#include <gateway/settings.hpp>
#include <sys/asio_fwd.hpp>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace anoctl {

/// Parses a LINK text. Throws UsageError. `if_name` is added to the error if `link` is only a name: "a link of the gateway, by
/// its name: monitor --link".
anogate::LinkSettings link_settings_of(const std::string& link, std::string_view if_name = {});
/// "hello, limit.0x01": the keys of a LINK text that have no effect for a listener, because they apply to sending or forwarding.
std::string keys_idle_for_listener(std::string_view link);

/// Passes each valid frame to a FrameReceiver. Reports on `err` whether the link is up, or why it waits, and the hints that the
/// status of a gateway would contain. Runs while its loop runs, and stops the loop when the FrameReceiver needs no more frames.
class OwnLink {
public:
    /// The references must outlive it. `who`: the command, for the messages on `err`; if empty, there is no message when the link
    /// is up. `look_every`: interval of the check for hints.
    OwnLink(anogate::asio::io_context& io, const anogate::LinkSettings& settings, FrameReceiver& receiver, Streams& streams,
            std::string who, ano::Duration look_every = std::chrono::seconds{3});
    ~OwnLink();
    OwnLink(const OwnLink&) = delete;
    OwnLink& operator=(const OwnLink&) = delete;

    void start();
    /// Closes the link. Must not be called from within the FrameReceiver.
    void stop();
    /// Sends a frame to every channel on which its destination was heard, or else to all channels. False: no channel accepted it,
    /// for example because none is open or the port of the link is missing.
    bool send(ano::FrameView frame);
    /// Sends zero bytes (Outbox::flush_parser()) before `next`, the frame that will be passed to send().
    ano::Flush flush_parser(ano::FrameView next);
    const std::string& name() const noexcept;
    bool is_up() const noexcept;
    /// A clause with the fault of a link that is up: "refused: nothing listens at 127.0.0.1:5555". Empty: no fault.
    std::string trouble() const;
    /// Number of received bytes outside any frame.
    std::uint64_t skipped() const noexcept;
    /// Number of frames passed to send() that still wait, and that were dropped; a frame counts once for each channel.
    std::size_t waiting() const noexcept;
    std::uint64_t dropped_frames() const noexcept;

private:
    class Host;
    std::unique_ptr<Host> host_;
};

/// Receives until interrupted or until `receiver` needs no more frames. Returns the number of bytes outside any frame.
std::uint64_t listen(const std::string& link, FrameReceiver& receiver, Streams& streams, const std::string& who);

}    // namespace anoctl
