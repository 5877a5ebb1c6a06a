// Watches the interface of a link-local address, which may be removed and added again with another index.
#pragma once
#include <link/link_context.hpp>
#include <link/reconnect.hpp>
#include <link/udp/ip_socket.hpp>
#include <sys/alarm.hpp>

#include <functional>
#include <string>

namespace anogate {

/// Checks once per second whether the interface of an open socket still exists: a socket that only receives gets no error. Does
/// nothing for an address without an interface.
class InterfaceWatch {
public:
    /// `gone` is called at most once after start(), with a text for the user.
    InterfaceWatch(const LinkContext& context, std::function<void(LinkError why)> gone)
        : host_{context.host}, gone_{std::move(gone)}, look_{context.alarms, [this] { look(); }, retry_slack} {}

    void start(const EndpointSpec& written) {
        if (written.interface.empty()) return;
        written_ = written;
        opened_ = endpoint_now(written);
        look_.set(host_.now() + between_looks);
    }
    void stop() { look_.cancel(); }

private:
    static constexpr Duration between_looks = std::chrono::seconds{1};

    void look() {
        const auto now = endpoint_now(written_);
        if (now && now == opened_) return look_.set(host_.now() + between_looks);
        gone_(now ? LinkError{"network interface " + written_.interface + " was replaced by another one"}
                  : no_interface(written_.interface));
    }

    LinkHost& host_;
    std::function<void(LinkError)> gone_;
    Alarm look_;
    EndpointSpec written_;
    std::optional<Endpoint> opened_;
};

}    // namespace anogate
