#include <ano/heard.hpp>
#include <ano/messages.hpp>

namespace ano {
namespace {

constexpr std::uint8_t ip_tunnel = find_message("ip_tunnel")->id;
constexpr std::uint8_t ip_tunnel_short = find_message("ip_tunnel_short")->id;

enum class Length : std::uint8_t { free, fixed, by_first_byte };

consteval std::array<Length, 256> lengths_by_id() {
    std::array<Length, 256> all{};    // not listed: free
    for (const Message& row : messages)
        if (row.is_base()) all[row.id] = Length::fixed;
    for (const Message& row : messages)
        if (row.ends_in_list()) all[row.id] = Length::by_first_byte;
        else if (row.is_open() || row.fields().empty()) all[row.id] = Length::free;
    return all;
}
constexpr std::array<Length, 256> lengths = lengths_by_id();

bool selects_list(std::uint8_t id, std::uint8_t first) noexcept {
    for (const Message& row : layouts_of(id)) {
        if (!row.ends_in_list()) continue;
        const auto& selects = row.fields().front().selects;
        if (!selects || (selects->first <= first && first <= selects->last)) return true;
    }
    return false;
}

}    // namespace

bool is_of_free_length(std::uint8_t id, std::uint8_t first) noexcept {
    return lengths[id] == Length::free || (lengths[id] == Length::by_first_byte && selects_list(id, first));
}

bool Heard::makes_credible(const std::uint8_t* begin) const noexcept {
    const std::uint8_t id = begin[3];
    if (id == ip_tunnel || id == ip_tunnel_short) return true;
    return sources_[begin[1]] && (is_of_free_length(id, begin[header_size]) || data_length(begin) <= max_size_[id]);
}

}    // namespace ano
