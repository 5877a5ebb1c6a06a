#include <http/attempts.hpp>

#include <arpa/inet.h>

#include <algorithm>

namespace anogate::http {
namespace {

std::string counted_as(const std::string& peer) {
    in6_addr address{};
    if (::inet_pton(AF_INET6, peer.substr(0, peer.find('%')).c_str(), &address) != 1) return peer;
    return {reinterpret_cast<const char*>(address.s6_addr), 8};
}

}    // namespace

ano::Duration Attempts::barred_for(const std::string& peer, ano::TimePoint now) const {
    const auto found = failures_.find(counted_as(peer));
    if (found == failures_.end() || found->second.size() < max_failures) return {};
    return std::max(ano::Duration{}, found->second.front() + window - now);
}

void Attempts::failed(const std::string& peer, ano::TimePoint now) {
    auto& times = failures_[counted_as(peer)];
    times.push_back(now);
    if (times.size() > max_failures) times.pop_front();
    if (failures_.size() <= max_peers) return;
    failures_.erase(std::min_element(failures_.begin(), failures_.end(),
                                     [](const auto& a, const auto& b) { return a.second.back() < b.second.back(); }));
}

}    // namespace anogate::http
