#include <ano/address.hpp>
#include <ano/typed.hpp>
#include <devices/device_log.hpp>

#include <algorithm>
#include <new>
#include <span>
#include <utility>

namespace anogate {
namespace {

constexpr std::size_t place_of(DeviceLog::Origin origin) noexcept { return static_cast<std::size_t>(origin); }

std::string line_text(std::span<const std::uint8_t> bytes) {
    std::string_view text{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    text = text.substr(0, text.find('\0'));
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.remove_suffix(1);
    return std::string{text.substr(0, DeviceLog::max_text)};
}

}    // namespace

bool DeviceLog::receive(ano::FrameView frame, std::string_view link, std::uint64_t time_ns, Origin origin) noexcept {
    if (frame.id() != ano::id_of<"log"> && frame.id() != ano::id_of<"log_value">) return false;
    if (ano::address::is_host(frame.source())) return false;
    try {
        Line line{last_ + 1, count(frame.source()) + 1, time_ns, std::string{link}, 0, std::nullopt, {}, origin};
        if (const auto log = ano::as<"log">(frame)) {
            line.color = log->get<"color">();
            line.text = line_text(log->bytes<"str">());
        } else if (const auto value = ano::as<"log_value">(frame)) {
            line.value = value->get<"val">();
            line.text = line_text(value->bytes<"str">());
        } else return false;
        auto& kept = kept_[frame.source()];
        if (!kept) kept = std::make_unique<Kept>();
        kept->lines.push_back(std::move(line));
        ++kept->of_origin[place_of(origin)];
        ++size_;
        ++last_;
        ++kept->count;
        if (kept->lines.back().is_red() && origin == Origin::known) ++kept->red;
        make_room(*kept, origin);
        return true;
    } catch (const std::bad_alloc&) {
        return false;
    }
}

void DeviceLog::make_room(Kept& of, Origin origin) noexcept {
    if (of.of_origin[place_of(origin)] > max_lines) return forget_oldest(of, origin);
    if (size_ <= max_of_all) return;
    if (Kept* const loser = fullest(Origin::anybody)) forget_oldest(*loser, Origin::anybody);
    else forget_oldest(*fullest(Origin::known), Origin::known);
}

// The device with the most lines of that origin; nullptr: none has any.
DeviceLog::Kept* DeviceLog::fullest(Origin origin) noexcept {
    const std::size_t place = place_of(origin);
    Kept* most = nullptr;
    for (const auto& kept : kept_)
        if (kept && kept->of_origin[place] > (most ? most->of_origin[place] : 0)) most = kept.get();
    return most;
}

void DeviceLog::forget_oldest(Kept& of, Origin origin) noexcept {
    const auto oldest = std::find_if(of.lines.begin(), of.lines.end(), [&](const Line& line) { return line.origin == origin; });
    of.lines.erase(oldest);
    --of.of_origin[place_of(origin)];
    --size_;
}

const std::deque<DeviceLog::Line>& DeviceLog::lines(std::uint8_t address) const noexcept {
    static const std::deque<Line> none;
    return kept_[address] ? kept_[address]->lines : none;
}

}    // namespace anogate
