// A value of the configuration, in a form between the JSON or text and the field of the settings.
#pragma once
#include <gateway/filter.hpp>
#include <gateway/host_spec.hpp>

#include <ano/time.hpp>

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace anogate {

struct NetworkList {
    bool any = false;    // every network; `networks` is empty then
    std::vector<Network> networks{};
    std::vector<std::string> hosts{};    // host names, if the key allows them
};

/// std::monostate: not set. The value of an enumeration is the text of the choice.
using Value =
    std::variant<std::monostate, bool, std::uint64_t, ano::Duration, std::string, EndpointSpec, HostSpec, IpAddress, Network,
                 NetworkList, ByteRange, std::vector<ByteRange>, std::vector<std::string>, std::vector<LimitRule>>;

}    // namespace anogate
