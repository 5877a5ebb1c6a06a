// Whether frames were refused for their length while a command waited for large ones.
#pragma once
#include <ano_json/frame_json.hpp>
#include <anoctl/gateway.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// A sentence for each link whose bad_length or too_big has grown from one status to a later one: what was refused, and what to set.
std::vector<std::string> refused_lengths(const ano::Json& before, const ano::Json& now);

/// Asks a gateway for its status again and again.
class RefusedLengths {
public:
    explicit RefusedLengths(const GatewayOptions& gateway) : gateway_{gateway}, before_(status()) {}
    /// What is new since the last call. Blocks for one request.
    std::vector<std::string> look();

private:
    std::string status() const;

    const GatewayOptions& gateway_;
    std::string before_;    // JSON; empty: the gateway did not answer
};

}    // namespace anoctl
