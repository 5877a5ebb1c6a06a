// The link `control`: frames of programs that use the control interface. Each WebSocket of GET /link is a channel of it.
#pragma once
#include <ano/flush.hpp>
#include <gateway/forwarder.hpp>
#include <http/response.hpp>
#include <link/link_context.hpp>

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// The reason why Gateway::control() returns nullptr.
inline constexpr std::string_view no_control_link = "all 64 links are in use, so the link 'control' is not available";

class LinkSocket;

class ControlLink final : public Link, public UnassignedReceiver {
public:
    ControlLink(LinkId id, LinkSettings settings, const LinkContext& context, Forwarder& forwarder);
    ~ControlLink() override;
    /// The settings of the link `control`, as if it were configured.
    static LinkSettings link_settings(const Settings& settings);

    void start() override { context_.host.link_up(*this); }
    void stop_reading() override { reads_ = false; }
    void stop() override;
    void flush(Channel& channel) override;
    UnassignedTraffic unassigned_traffic() const override;

    /// GET /link?name=N&id=P: opens a channel for the program.
    http::Response join(const http::Request& request, std::uint8_t own_id);
    /// Closes the connections of programs whose port id now belongs to another link or to the gateway itself.
    void release_ports(std::uint8_t own_id);
    /// POST /send: forwards one frame that belongs to no connected program. Its source address is not learned.
    void send(ano::FrameView frame);
    /// Forwarder::flush_parsers() before `next`, the frame that will be passed to send().
    ano::Flush flush_parsers(ano::FrameView next);

private:
    friend class LinkSocket;
    bool is_free(std::uint8_t port_id) const { return forwarder_.router().port(port_id).empty(); }

    LinkContext context_;
    Forwarder& forwarder_;
    std::array<LinkSocket*, max_channels> sockets_{};    // by channel
    std::unique_ptr<Channel> sender_;                    // for the frames of send(); nullptr: none yet
    bool reads_ = true;
};

}    // namespace anogate
