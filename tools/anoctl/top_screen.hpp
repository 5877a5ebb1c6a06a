// What anoctl top shows, as arithmetic: from two looks at a gateway's status to the lines of a screen.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

struct TopChannel {
    std::string link, peer;
    double in = 0, out = 0, dropped = 0;    // frames a second
    std::string causes{};                   // of those that were dropped: "stale 3.0, limited 1.0"; or why the link is not up
    std::uint64_t waiting = 0;              // frames
    std::optional<double> age{};            // of the last frame, seconds
};

struct TopAddress {
    std::string address, who, links;
    double rate = 0;    // frames a second that it sent
    std::optional<double> age{};
};

struct TopView {
    std::string title;
    std::vector<TopChannel> channels;
    std::vector<TopAddress> addresses;
};

enum class TopSort : std::uint8_t { name, in, out, dropped, age };
std::string_view text(TopSort sort) noexcept;
TopSort next(TopSort sort) noexcept;

/// Frames by source, as they were seen.
using HeardFrames = std::array<std::uint64_t, 256>;

/// `before` and `now` are statuses, so many `seconds` apart, in which `heard` were seen. Where `before` does not know a channel, or
/// counted more, its rates are 0. A status that has not the shape of one gives what it has.
TopView top_view(const nlohmann::json& before, const nlohmann::json& now, double seconds, const HeardFrames& heard);

/// Busiest first, or by name; of the youngest frame first.
void sort(TopView& view, TopSort by);

/// Exactly `height` lines, none wider than `width` characters, the last with the keys. What has no room is counted. Control characters
/// are shown as '?'.
std::vector<std::string> top_screen(const TopView& view, TopSort by, std::size_t width, std::size_t height);

}    // namespace anoctl
