// Slows down clients that send wrong tokens too often.
#pragma once
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>

namespace anogate::http {

/// After ten wrong tokens of a client (client_network) within a minute, further wrong ones are slowed down until the first is a minute old. Of
/// more than max_peers clients the one whose last failure is oldest is forgotten.
class Attempts {
public:
    /// For how long wrong tokens of `peer` are still slowed down; zero: they are not.
    ano::Duration slowed_for(const std::string& peer, ano::TimePoint now) const;
    struct News {
        bool is_told = false;    // this client is slowed down for the first time, as far as is remembered, and it is to be logged
        std::uint64_t untold = 0;    // clients before it that were not logged
        bool is_last = false;        // further ones of this minute will not be logged
    };
    News failed(const std::string& peer, ano::TimePoint now);
    /// How often a client was slowed down for the first time.
    std::uint64_t slowed() const noexcept { return slowed_; }

    static constexpr std::size_t max_failures = 10, max_peers = 256, max_told = 10;    // told in a window
    static constexpr ano::Duration window = std::chrono::minutes{1};

private:
    struct Client {
        std::deque<ano::TimePoint> failures;    // the newest max_failures
        bool was_slowed = false;
    };
    News news(ano::TimePoint now);

    std::map<std::string, Client> clients_;
    std::uint64_t slowed_ = 0, untold_ = 0;
    std::size_t told_ = 0;    // since told_since_
    ano::TimePoint told_since_{};
};

}    // namespace anogate::http
