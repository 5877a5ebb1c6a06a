// What UdpListenLink keeps of each peer. For its own sources only.
#pragma once
#include <gateway/far_peer.hpp>
#include <link/alarm.hpp>
#include <link/udp_listen_link.hpp>

#include <memory>

namespace anogate {

struct UdpListenLink::Peer {
    Peer(UdpListenLink& link, const Endpoint& e, Channel& c)
        : endpoint{e},
          address{SocketAddress::of(e, link.local_.address.v6)},
          channel{c},
          expiry{link.context_.alarms, [&link, this] { link.expire(*this); }},
          again{link.context_.alarms, [&link, this] { link.flush(channel); }} {}

    Endpoint endpoint;
    SocketAddress address;
    Channel& channel;
    Alarm expiry;
    Alarm again;                     // after SendResult::no_memory
    std::unique_ptr<FarPeer> far;    // set for a peer outside our networks, until it has shown that it receives
    TimePoint ask_at{};              // earliest time to ask whether it is a listening gateway
    TimePoint silenced_until{};      // its frames are refused until then
    bool is_gateway = false;         // it answered so; to be forgotten when its datagram has been read
};

}    // namespace anogate
