// Who gave wrong tokens too often.
#pragma once
#include <ano/time.hpp>

#include <deque>
#include <map>
#include <string>

namespace anogate::http {

/// Ten wrong tokens of a client (client_network) within a minute bar it until the first of them is a minute old. Bounded: of many clients
/// the one that failed longest ago is forgotten.
class Attempts {
public:
    /// How long nothing of `peer` is looked at any more; zero: it is.
    ano::Duration barred_for(const std::string& peer, ano::TimePoint now) const;
    void failed(const std::string& peer, ano::TimePoint now);

    static constexpr std::size_t max_failures = 10, max_peers = 256;
    static constexpr ano::Duration window = std::chrono::minutes{1};

private:
    std::map<std::string, std::deque<ano::TimePoint>> failures_;    // of each, the newest max_failures
};

}    // namespace anogate::http
