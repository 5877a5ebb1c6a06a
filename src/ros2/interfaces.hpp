// The IPv4 addresses of network interfaces, and their changes.
#pragma once
#include <sys/asio.hpp>
#include <sys/descriptor.hpp>
#include <sys/expected.hpp>

#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace anogate {

/// An address, with the number of its interface: an interface that was removed and added again has another one.
using InterfaceAddress = std::pair<unsigned, std::string>;

/// Those of interfaces that are up and have a carrier. `names` empty: all interfaces.
std::set<InterfaceAddress> interface_addresses(const std::vector<std::string>& names);

/// What to do after a change. An address that is gone may return; a new one has to be announced to others.
bool must_rejoin(const std::set<InterfaceAddress>& joined, const std::set<InterfaceAddress>& now);

class InterfaceWatch {
public:
    /// `call` is called from the loop after changes, some time after the last of several.
    InterfaceWatch(asio::io_context& io, std::function<void()> call);

    /// The error, if the system does not report changes.
    Expected<void> start();
    void stop();

private:
    void read();

    Descriptor descriptor_;
    asio::steady_timer settled_;
    std::function<void()> call_;
    bool waits_ = false;
};

}    // namespace anogate
