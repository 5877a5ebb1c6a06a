// Where commands that only listen have their frames from: the gateway that runs, or a link of our own.
#pragma once
#include <anoctl/anoctl.hpp>
#include <anoctl/frame_taker.hpp>
#include <anoctl/gateway.hpp>

#include <string>
#include <vector>

namespace anoctl {

struct FramesOf {
    GatewayOptions gateway;
    std::string link;                    // empty: the gateway's
    std::vector<std::string> devices;    // only from these; empty: from all

    /// Declares --device, --link and --control. `self` lives as long as the run.
    static void add(Options& declared, FramesOf& self);
    /// Gives those of the messages `ids` to `taker` until it is interrupted or wants no more. Returns why no more will come; empty: one of
    /// these. Throws UsageError, and Failure when there is no gateway. `who` is the command.
    std::string each(const std::vector<std::string>& ids, FrameTaker& taker, Streams& streams, const std::string& who) const;

private:
    std::vector<std::string> by_address() const;
    std::string address_named(const std::string& word) const;
};

}    // namespace anoctl
