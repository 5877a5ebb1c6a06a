// Which requests a gateway accepts from the broker. No I/O.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Why `rule` is not "METHOD /PATH", in a clause; empty: it is.
std::string fault_in_rule(std::string_view rule);

/// A rule allows its path and everything below; '*' is any one step. Reading what the gateway knows is always allowed.
class AllowedRequests {
public:
    explicit AllowedRequests(std::vector<std::string> rules) : rules_{std::move(rules)} {}
    bool allows(std::string_view method, std::string_view target) const;

private:
    std::vector<std::string> rules_;
};

}    // namespace anogate
