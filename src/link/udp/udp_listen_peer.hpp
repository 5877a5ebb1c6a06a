// The state of a peer of UdpListenLink. Internal to its sources.
#pragma once
#include <gateway/peers/far_peer.hpp>
#include <gateway/peers/host_command.hpp>
#include <link/udp/datagram_queue.hpp>
#include <link/udp/udp_listen_link.hpp>
#include <link/v7_edge.hpp>
#include <sys/alarm.hpp>

#include <memory>

namespace anogate {

struct UdpListenLink::Peer {
    Peer(UdpListenLink& link, const Endpoint& e, Channel& c)
        : endpoint{e},
          address{SocketAddress::of(e, link.local_.address.v6)},
          channel{c},
          expiry{link.context_.alarms, [&link, this] { link.expire(*this); }},
          again{link.context_.alarms, [&link, this] { link.flush(channel); }} {
        const V7LinkSettings& keys = link.settings().as<UdpListenSettings>().v7;
        if (!keys.is_on()) return;
        v7 = std::make_unique<V7Edge>(keys, link.settings(), link.context_,
                                      V7Edge::Calls{[&link, this] { link.flush(channel); },
                                                    [&link, this](ano::FrameView frame) { link.receive_v7(*this, frame); }});
        v7->begin(channel);
    }

    Endpoint endpoint;
    SocketAddress address;
    Channel& channel;
    Alarm expiry;
    Alarm again;                                 // after SendResult::no_memory
    std::unique_ptr<DatagramQueue> waiting{};    // nullptr: no datagram waits
    std::unique_ptr<V7Edge> v7{};                // nullptr: the devices use V8
    std::unique_ptr<FarPeer> far;                // set for a peer outside our networks, until it has shown that it receives
    TimePoint ask_at{};                          // earliest time to check whether it is a listening gateway
    TimePoint suspended_until{};                 // its frames are refused until then
    TimePoint absent_until{};                    // until then it gets few datagrams: the kernel finds no host at its address
    TimePoint next_try{};                        // while it is absent
    bool is_tried = false;                       // while it is absent: no report of a try was received yet
    TimePoint believed_again{};                  // from then on a datagram of it shows that it is not absent
    bool came = false;                           // a datagram of it was processed
    bool is_gateway = false;                     // according to its answer; removed when its datagram is processed
};

}    // namespace anogate
