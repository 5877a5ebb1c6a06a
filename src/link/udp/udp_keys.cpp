#include <config/values.hpp>
#include <link/udp/udp_keys.hpp>

namespace anogate {

// A number may mean the same interface as a name.
void check_interface(const std::string& interface, const EndpointSpec& endpoint, LinkFaults& faults) {
    const std::string& other = endpoint.interface;
    if (!interface.empty() && !other.empty() && interface != other && !parse_number(other))
        faults.error("interface",
                     "'interface' " + in_quotes(interface) + " contradicts " + endpoint.text() + ": remove one of them");
}

}    // namespace anogate
