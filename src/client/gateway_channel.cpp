#include <client/gateway_channel.hpp>

#include <utility>

namespace anogate {
namespace {

// A message of the gateway contains only complete frames.
void for_each_frame(std::string_view message, const std::function<void(ano::FrameView)>& call) {
    ano::Bytes rest{reinterpret_cast<const std::uint8_t*>(message.data()), message.size()};
    while (const auto frame = ano::frame_at(rest)) {
        call(*frame);
        rest = rest.subspan(frame->bytes().size());
    }
}

}    // namespace

GatewayChannel::GatewayChannel(asio::io_context& io, std::string control, const std::string& name, Events events)
    : events_{std::move(events)},
      socket_{io,
              std::move(control),
              "/link?name=" + name,
              {.opened = [this] { events_.opened(); },
               .received =
                   [this](std::string_view message, http::WebSocket::Kind kind) {
                       if (kind == http::WebSocket::Kind::binary) for_each_frame(message, events_.frame);
                   },
               .closed = [this](const std::string& why) { events_.closed(why); }}} {}

bool GatewayChannel::send(ano::Bytes frame) {
    if (socket_.send({reinterpret_cast<const char*>(frame.data()), frame.size()})) return true;
    ++dropped_;
    return false;
}

}    // namespace anogate
