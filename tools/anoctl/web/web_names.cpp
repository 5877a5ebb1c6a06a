#include "web_names.hpp"

#include <algorithm>

namespace anoctl {

using anogate::IpAddress;

namespace {

std::string url_of(const WebAddress& web_address, const std::string& host) {
    return (web_address.is_encrypted ? "https://" : "http://") + host + ":" + std::to_string(web_address.port) + "/";
}

std::string host_of(const IpAddress& address) { return address.v6 ? "[" + address.text() + "]" : address.text(); }

}    // namespace

std::vector<std::string> names_of(const Computer& computer) {
    if (computer.name.empty()) return {};
    if (computer.name.find('.') != std::string::npos) return {computer.name};
    return {computer.name, computer.name + ".local"};
}

std::vector<IpAddress> reachable(const Computer& computer) {
    std::vector<IpAddress> all;
    for (const IpAddress& address : computer.addresses)
        if (!address.is_loopback() && !(address.v6 && address.is_link_local())) all.push_back(address);
    return all;
}

std::vector<std::string> urls_of(const WebAddress& web_address, const Computer& computer) {
    std::vector<std::string> hosts;
    if (web_address.address.is_any()) {
        for (const IpAddress& address : reachable(computer))
            if (!address.v6 || web_address.address.v6) hosts.push_back(host_of(address));    // [::] also accepts IPv4
    } else {
        hosts.push_back(host_of(web_address.address));
    }
    const std::vector<std::string> names = web_address.address.is_loopback() ? std::vector<std::string>{"localhost"}
                                                                             : names_of(computer);
    hosts.insert(hosts.end(), names.begin(), names.end());
    hosts.insert(hosts.end(), web_address.hosts.begin(), web_address.hosts.end());
    for (std::string& host : hosts) host = url_of(web_address, host);
    return hosts;
}

std::string url_for_phones(const WebAddress& web_address, const Computer& computer) {
    const std::vector<std::string> all = urls_of(web_address, computer);
    const auto found = std::find_if(all.begin(), all.end(), [](const std::string& url) { return url.find('[') == url.npos; });
    return found == all.end() ? all.front() : *found;
}

std::string url_here(const WebAddress& web_address) {
    const bool is_here = web_address.address.is_any() || web_address.address.is_loopback();
    return url_of(web_address, is_here ? "localhost" : host_of(web_address.address));
}

}    // namespace anoctl
