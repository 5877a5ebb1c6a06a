// The screen of `anoctl top`, made from two statuses of a gateway. No I/O.
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
    double in = 0, out = 0, dropped = 0;    // frames per second
    std::string causes{};                   // causes of dropped frames: "stale 3.0, limited 1.0"; or why the link is down
    std::uint64_t waiting = 0;              // queued frames
    std::optional<double> age{};            // seconds since the last frame
};

struct TopAddress {
    std::string address, who, links;
    double rate = 0;    // frames per second from this address
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

/// Number of received frames, by source.
using HeardFrames = std::array<std::uint64_t, 256>;

/// `before` and `now`: statuses with an interval of `seconds`; `heard`: the frames received in between. A channel that is missing
/// in `before`, or had higher counters there, has rates of 0. From a status in an unknown format, the known parts are used.
TopView top_view(const nlohmann::json& before, const nlohmann::json& now, double seconds, const HeardFrames& heard);

/// By name, by rate (highest first), or by age (latest first).
void sort(TopView& view, TopSort by);

/// Exactly `height` lines of at most `width` characters; the last one shows the keys. Rows that don't fit are only counted.
/// Control characters are shown as '?'.
std::vector<std::string> top_screen(const TopView& view, TopSort by, std::size_t width, std::size_t height);

}    // namespace anoctl
