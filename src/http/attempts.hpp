// Bars clients that sent wrong tokens too often.
#pragma once
#include <ano/time.hpp>

#include <deque>
#include <map>
#include <string>

namespace anogate::http {

/// Ten wrong tokens of a client (client_network) within a minute bar it until the first of them is a minute old. Of more than max_peers
/// clients the one whose last failure is oldest is forgotten.
class Attempts {
public:
    /// How long requests of `peer` are still refused; zero: they are not.
    ano::Duration barred_for(const std::string& peer, ano::TimePoint now) const;
    void failed(const std::string& peer, ano::TimePoint now);

    static constexpr std::size_t max_failures = 10, max_peers = 256;
    static constexpr ano::Duration window = std::chrono::minutes{1};

private:
    std::map<std::string, std::deque<ano::TimePoint>> failures_;    // by peer: its newest max_failures
};

}    // namespace anogate::http
