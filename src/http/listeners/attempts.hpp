// Slows down clients that send wrong tokens too often.
#pragma once
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>

namespace anogate::http {

/// After ten wrong tokens of a client (client_network) within a minute, further wrong ones are slowed down until the first is a
/// minute old. Above max_peers clients, the one whose last failure is oldest is forgotten.
class Attempts {
public:
    /// The time for which wrong tokens of `peer` are still slowed down; zero: they are not.
    ano::Duration slowed_for(const std::string& peer, ano::TimePoint now) const;
    struct News {
        bool is_told = false;    // log it: this client is slowed down for the first time (unless it was forgotten meanwhile)
        std::uint64_t unlogged = 0;    // clients before it that were not logged
        bool is_last = false;          // further clients are not logged within this minute
    };
    /// `token`: a hash of the wrong token if knows() may be called for it; 0: none.
    News failed(const std::string& peer, ano::TimePoint now, std::size_t token = 0);
    /// Whether the token is one of the newest failures of `peer`.
    bool knows(const std::string& peer, std::size_t token) const;
    /// Number of clients that were slowed down, each counted at its first time.
    std::uint64_t slowed() const noexcept { return slowed_; }

    static constexpr std::size_t max_failures = 10, max_peers = 256, max_logged = 10;    // max_logged: logged within a window
    static constexpr ano::Duration window = std::chrono::minutes{1};

private:
    struct Failure {
        ano::TimePoint at;
        std::size_t token = 0;    // see failed()
    };
    struct Client {
        std::deque<Failure> failures;    // the newest max_failures
        bool was_slowed = false;
    };
    News news(ano::TimePoint now);

    std::map<std::string, Client> clients_;
    std::uint64_t slowed_ = 0, unlogged_ = 0;
    std::size_t logged_ = 0;    // since logged_since_
    ano::TimePoint logged_since_{};
};

}    // namespace anogate::http
