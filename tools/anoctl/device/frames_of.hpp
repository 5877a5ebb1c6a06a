// The source of frames for commands that only receive: the running gateway, or a link of this process.
#pragma once
#include <anoctl/anoctl.hpp>
#include <anoctl/frame_receiver.hpp>
#include <anoctl/gateway.hpp>

#include <string>
#include <vector>

namespace anoctl {

struct FramesOf {
    GatewayOptions gateway;
    std::string link;                    // empty: the gateway
    std::vector<std::string> devices;    // only frames from these devices; empty: all

    /// Declares --device, --link and --control. `self` must live as long as the run.
    static void add(Options& declared, FramesOf& self);
    /// Passes frames of the messages `ids` to `receiver`. Returns empty if interrupted or `receiver` needs no more frames, otherwise
    /// the reason why no more frames will arrive. Throws UsageError, and Failure if there is no gateway. `who`: the command.
    std::string each(const std::vector<std::string>& ids, FrameReceiver& receiver, Streams& streams,
                     const std::string& who) const;

private:
    std::vector<std::string> by_address() const;
    std::string address_named(const std::string& word) const;
};

}    // namespace anoctl
