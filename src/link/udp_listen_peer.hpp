// For the sources of UdpListenLink alone: what it has of each peer.
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
    Alarm again;                     // after the system had no memory to send
    std::unique_ptr<FarPeer> far;    // outside our networks, until it has shown that it is there
    TimePoint ask_at{};              // a suspect, whether it is a listening gateway
    TimePoint silenced_until{};      // nothing of it is taken before
    bool is_gateway = false;         // it said so: to be forgotten when what it sent has been read
};

}    // namespace anogate
