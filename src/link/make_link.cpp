#include <link/make_link.hpp>
#include <link/pty_link.hpp>
#include <link/serial_link.hpp>
#include <link/sim_link.hpp>
#include <link/udp_link.hpp>
#include <link/udp_listen_link.hpp>

#include <stdexcept>

namespace anogate {

std::unique_ptr<Link> make_link(LinkId id, const LinkSettings& settings, const LinkContext& context) {
    if (settings.kind == "serial") return std::make_unique<SerialLink>(id, settings, context);
    if (settings.kind == "udp-listen") return std::make_unique<UdpListenLink>(id, settings, context);
    if (settings.kind == "udp") return std::make_unique<UdpLink>(id, settings, context);
    if (settings.kind == "pty") return std::make_unique<PtyLink>(id, settings, context);
    if (settings.kind == "sim") return std::make_unique<SimLink>(id, settings, context);
    throw std::logic_error("no link kind " + settings.kind);
}

}  // namespace anogate
