// A link of our own, without a gateway.
#pragma once
#include "anoctl.hpp"
#include "frame_taker.hpp"

#include <ano/time.hpp>
#include <gateway/settings.hpp>
#include <link/asio_fwd.hpp>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace anoctl {

/// As `link` says. Throws UsageError.
/// `if_name` says what was meant when it is only a name: "a link of the gateway, by its name: monitor --link".
anogate::LinkSettings link_settings_of(const std::string& link, std::string_view if_name = {});
/// "hello, limit.0x01": the keys of a LINK text that concern sending only, or what a gateway does with frames.
std::string keys_idle_for_listener(std::string_view link);

/// Gives each good frame that comes to its taker, and says on `err` how the link is: up, waited for and why, and the hints that a
/// gateway's status would have. It works when its loop runs, and stops that when its taker wants no more.
class OwnLink {
public:
    /// Everything outlives it. `who` is the command, for the words on `err`; empty: that it is up is not said. Once in `look_every`
    /// it is looked whether there is a hint.
    OwnLink(anogate::asio::io_context& io, const anogate::LinkSettings& settings, FrameTaker& taker, Streams& streams,
            std::string who, ano::Duration look_every = std::chrono::seconds{3});
    ~OwnLink();
    OwnLink(const OwnLink&) = delete;
    OwnLink& operator=(const OwnLink&) = delete;

    void start();
    /// Closes it. Not within a call of the taker's.
    void stop();
    /// Sends a frame to every channel that heard from its destination, or to all of them when none did. False: there is none, or
    /// its wire is not there.
    bool send(ano::FrameView frame);
    const std::string& name() const noexcept;
    bool is_up() const noexcept;
    /// What is wrong with it while it is up, in a clause: "refused: nothing listens at 127.0.0.1:5555". Empty: nothing.
    std::string trouble() const;
    /// Bytes of no frame.
    std::uint64_t skipped() const noexcept;
    /// Frames of send() that wait to leave, and those that will not, each for every channel.
    std::size_t waiting() const noexcept;
    std::uint64_t given_up() const noexcept;

private:
    class Host;
    std::unique_ptr<Host> host_;
};

/// Listens until it is interrupted or the taker wants no more. Returns how many bytes of no frame there were.
std::uint64_t listen(const std::string& link, FrameTaker& taker, Streams& streams, const std::string& who);

}    // namespace anoctl
