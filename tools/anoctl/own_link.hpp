// A link of our own, without a gateway.
#pragma once
#include "anoctl.hpp"
#include "frame_taker.hpp"

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

/// The settings of a LINK text. Throws UsageError. `if_name`: what the user may have meant when `link` is only a name: "a link of the
/// gateway, by its name: monitor --link".
anogate::LinkSettings link_settings_of(const std::string& link, std::string_view if_name = {});
/// "hello, limit.0x01": the keys of a LINK text that have no effect for a listener, since they concern sending or forwarding.
std::string keys_idle_for_listener(std::string_view link);

/// Passes each good frame to its taker, and reports the state of the link on `err`: up, or waiting and why, and the hints that a
/// gateway's status would have. It works while its loop runs, and stops the loop when the taker wants no more.
class OwnLink {
public:
    /// The arguments outlive it. `who`: the command, for the messages on `err`; empty: the message that the link is up is omitted.
    /// `look_every`: the interval for checking whether there is a hint.
    OwnLink(anogate::asio::io_context& io, const anogate::LinkSettings& settings, FrameTaker& taker, Streams& streams,
            std::string who, ano::Duration look_every = std::chrono::seconds{3});
    ~OwnLink();
    OwnLink(const OwnLink&) = delete;
    OwnLink& operator=(const OwnLink&) = delete;

    void start();
    /// Closes it. Not to be called by the taker.
    void stop();
    /// Sends a frame to every channel on which its destination was heard, or else to all channels. False: there is no channel, or the port
    /// of the link is missing.
    bool send(ano::FrameView frame);
    /// Has zero bytes sent (Outbox::flush_parser()) before `next`, which send() is to get.
    ano::Flush flush_parser(ano::FrameView next);
    const std::string& name() const noexcept;
    bool is_up() const noexcept;
    /// A clause: what is wrong with it while it is up: "refused: nothing listens at 127.0.0.1:5555". Empty: nothing is wrong.
    std::string trouble() const;
    /// Bytes that belong to no frame.
    std::uint64_t skipped() const noexcept;
    /// Frames of send() that wait to be sent, and those that were given up, counted for each channel.
    std::size_t waiting() const noexcept;
    std::uint64_t given_up() const noexcept;

private:
    class Host;
    std::unique_ptr<Host> host_;
};

/// Listens until it is interrupted or the taker wants no more. Returns the number of bytes that belong to no frame.
std::uint64_t listen(const std::string& link, FrameTaker& taker, Streams& streams, const std::string& who);

}    // namespace anoctl
