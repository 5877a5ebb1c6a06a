#include <http/attempts.hpp>
#include <http/client_network.hpp>

#include <algorithm>

namespace anogate::http {

ano::Duration Attempts::barred_for(const std::string& peer, ano::TimePoint now) const {
    const auto found = failures_.find(client_network(peer));
    if (found == failures_.end() || found->second.size() < max_failures) return {};
    return std::max(ano::Duration{}, found->second.front() + window - now);
}

void Attempts::failed(const std::string& peer, ano::TimePoint now) {
    auto& times = failures_[client_network(peer)];
    times.push_back(now);
    if (times.size() > max_failures) times.pop_front();
    if (failures_.size() <= max_peers) return;
    failures_.erase(std::min_element(failures_.begin(), failures_.end(),
                                     [](const auto& a, const auto& b) { return a.second.back() < b.second.back(); }));
}

}    // namespace anogate::http
