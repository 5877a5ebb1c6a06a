// The raw bytes of links, for tools that show or write them: GET /links/{link}/raw, a WebSocket.
//
// To the client: a text {"link", "kind", "encoding", "exclusive", "may_send"} first, then a binary message for each read or write:
// '<' (received) or '>' (sent), the time in ns since 1970 (8 bytes, little endian), the bytes. {"lost": {"received": N, "sent": N}}
// is the number of bytes left out before the next ones, {"error": "..."} the reason why bytes were not sent.
// From the client: binary messages, whose bytes are sent unchanged.
#pragma once
#include <gateway/forwarder.hpp>
#include <http/response.hpp>

#include <map>
#include <memory>

namespace anogate {

class Gateway;
class RawSocket;

class RawStreams final : private Forwarder::Observer {
public:
    static constexpr std::size_t max_waiting = 256 * 1024;    // bytes per client; the rest is dropped, counted and reported

    /// `gateway` must outlive it.
    explicit RawStreams(Gateway& gateway);
    ~RawStreams();
    RawStreams(const RawStreams&) = delete;
    RawStreams& operator=(const RawStreams&) = delete;

    http::Response answer(const http::Request& request);

private:
    friend class RawSocket;
    class TappedLink;

    /// Empty, or the reason for the failure: the link was removed, or another client uses it exclusively.
    std::string join(RawSocket& socket);
    void leave(RawSocket& socket);
    void set_exclusive(LinkId link, bool exclusive);
    bool is_exclusive(const std::string& link) const;

    void received(const Channel&, ano::FrameView, TimePoint) override {}
    void offered(const Channel&, ano::FrameView, ChannelId) override {}
    void dropped(const Channel&, ano::FrameView, ReceiveCause) override {}
    void refused(LinkId, ano::FrameView, SendCause) override {}
    void removed(LinkId link) override;

    Gateway& gateway_;
    std::map<LinkId, std::unique_ptr<TappedLink>> tapped_;
};

}    // namespace anogate
