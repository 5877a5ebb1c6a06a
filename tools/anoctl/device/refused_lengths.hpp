// Detects frames that were refused because of their length while a command waits for large ones.
#pragma once
#include <ano_json/frame_json.hpp>
#include <anoctl/gateway.hpp>

#include <string>
#include <vector>

namespace anoctl {

/// A sentence for each link whose bad_length or too_big has increased between two statuses: how many were refused, and which key
/// to set.
std::vector<std::string> refused_lengths(const ano::Json& before, const ano::Json& now);

/// Compares successive statuses of a gateway.
class RefusedLengths {
public:
    explicit RefusedLengths(const GatewayOptions& gateway) : gateway_{gateway}, before_(status()) {}
    /// The sentences since the last call. Blocks for one request.
    std::vector<std::string> look();

private:
    std::string status() const;

    const GatewayOptions& gateway_;
    std::string before_;    // JSON; empty: no response from the gateway
};

}    // namespace anoctl
