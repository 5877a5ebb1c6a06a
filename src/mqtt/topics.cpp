#include <ano/hex.hpp>
#include <ano_json/text.hpp>
#include <mqtt/topics.hpp>

#include <algorithm>

namespace anogate {
namespace {

bool is_allowed(char c) noexcept {
    return c != '+' && c != '#' && c != '/' && static_cast<unsigned char>(c) >= 0x20 && c != 0x7F;
}

// Empty: it is not a topic of a gateway.
std::string_view behind_gateway(std::string_view topic) noexcept {
    const std::string_view gateway = gateway_of(topic);
    return gateway.empty() ? gateway : topic.substr(topic_root.size() + gateway.size() + 2);
}

}    // namespace

bool is_level(std::string_view text) noexcept {
    return !text.empty() && text.size() <= max_level && text.front() != '$' &&
           std::all_of(text.begin(), text.end(), is_allowed) && ano::is_utf8(text);
}

std::string level_of(std::string_view text) {
    std::string level = ano::valid_utf8(text);
    std::replace_if(
        level.begin(), level.end(), [](char c) { return !is_allowed(c); }, '_');
    if (level.size() > max_level) {
        std::size_t end = max_level;
        while (end > 0 && (static_cast<unsigned char>(level[end]) & 0xC0) == 0x80) --end;    // not inside a character
        level.resize(end);
    }
    if (level.empty()) level = "_";
    if (level.front() == '$') level.front() = '_';
    return level;
}

std::string device_level(std::string_view link, std::uint8_t address) {
    return level_of(link).substr(0, max_level - 3) + '-' + ano::hex_byte(address).substr(2);
}

std::string Topics::up(std::string_view device, std::string_view message) const {
    return base_ + "up/" + std::string{device} + '/' + std::string{message};
}

std::string Topics::backlog(Keep keep) const {
    return base_ + "backlog/" + std::string{keep_names[static_cast<std::size_t>(keep)]};
}

std::string_view Topics::client_of(std::string_view topic) const noexcept {
    constexpr std::string_view kind = "request/";
    if (!topic.starts_with(base_) || !topic.substr(base_.size()).starts_with(kind)) return {};
    const std::string_view client = topic.substr(base_.size() + kind.size());
    return is_level(client) ? client : std::string_view{};
}

std::string_view gateway_of(std::string_view topic) noexcept {
    if (!topic.starts_with(topic_root) || !topic.substr(topic_root.size()).starts_with('/')) return {};
    topic.remove_prefix(topic_root.size() + 1);
    const std::size_t end = topic.find('/');
    return end == topic.npos ? std::string_view{} : topic.substr(0, end);
}

bool is_backlog(std::string_view topic) noexcept { return behind_gateway(topic).starts_with("backlog/"); }

}    // namespace anogate
