#include <http/client/client_network.hpp>
#include <http/listeners/attempts.hpp>

#include <algorithm>
#include <utility>

namespace anogate::http {

ano::Duration Attempts::slowed_for(const std::string& peer, ano::TimePoint now) const {
    const auto found = clients_.find(client_network(peer));
    if (found == clients_.end() || found->second.failures.size() < max_failures) return {};
    return std::max(ano::Duration{}, found->second.failures.front().at + window - now);
}

bool Attempts::knows(const std::string& peer, std::size_t token) const {
    const auto found = clients_.find(client_network(peer));
    return found != clients_.end() && std::any_of(found->second.failures.begin(), found->second.failures.end(),
                                                  [token](const Failure& one) { return one.token == token; });
}

Attempts::News Attempts::failed(const std::string& peer, ano::TimePoint now, std::size_t token) {
    Client& client = clients_[client_network(peer)];
    client.failures.push_back({now, token});
    if (client.failures.size() > max_failures) client.failures.pop_front();
    const bool is_news = slowed_for(peer, now) > ano::Duration{} && !std::exchange(client.was_slowed, true);
    if (clients_.size() > max_peers)
        clients_.erase(std::min_element(clients_.begin(), clients_.end(), [](const auto& a, const auto& b) {
            return a.second.failures.back().at < b.second.failures.back().at;
        }));
    return is_news ? news(now) : News{};
}

Attempts::News Attempts::news(ano::TimePoint now) {
    ++slowed_;
    if (logged_ == 0 || now - logged_since_ >= window) logged_ = 0, logged_since_ = now;
    if (logged_ == max_logged) return ++unlogged_, News{};
    return {true, std::exchange(unlogged_, 0), ++logged_ == max_logged};
}

}    // namespace anogate::http
