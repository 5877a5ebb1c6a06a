#include <ros/image_rows.hpp>

#include <algorithm>
#include <string_view>

namespace anogate {
namespace {

constexpr std::uint64_t grey = 0, last_color = 6;

std::uint64_t whole_number(const ano::Reading& reading, std::string_view name) {
    const ano::Field* const field = reading.field(name);
    return field != nullptr ? static_cast<std::uint64_t>(reading.number(*field)) : 0;
}

}    // namespace

std::size_t ImageRows::Head::row_size() const noexcept {
    return static_cast<std::size_t>(color == grey ? width : (width + 7) / 8);
}

const WholeImage* ImageRows::receive(std::uint64_t sender, const ano::Reading& reading, std::uint64_t time_ns) {
    const ano::Field* const field = reading.field("pixels");
    if (field == nullptr) return nullptr;
    const Head head{whole_number(reading, "flag"), whole_number(reading, "color"), whole_number(reading, "width"),
                    whole_number(reading, "height")};
    const ano::Bytes bytes = reading.bytes_of(*field);
    const std::size_t row = head.row_size();
    if (head.color > last_color || head.pixels() == 0 || head.pixels() > max_pixels || bytes.empty() || bytes.size() % row != 0 ||
        bytes.size() > row * head.height)
        return nullptr;

    Begun& begun = place_for(sender);
    const std::size_t more = bytes.size() / row * head.width;
    const std::uint64_t apart = std::max(time_ns, begun.heard_ns) - std::min(time_ns, begun.heard_ns);
    const bool goes_on = begun.sender == sender && begun.head == head && apart <= pause_ns &&
                         begun.pixels.size() + more <= head.pixels();
    if (!goes_on) begun.pixels.clear();
    begun.sender = sender;
    begun.head = head;
    begun.heard_ns = time_ns;
    append_rows(head, bytes, begun.pixels);
    if (begun.pixels.size() < head.pixels()) return nullptr;
    whole_pixels_.swap(begun.pixels);
    begun.pixels.clear();
    whole_ = {static_cast<std::uint32_t>(head.width), static_cast<std::uint32_t>(head.height), whole_pixels_};
    return &whole_;
}

// The entry of the sender, or an unused one, or the one that received no frames for the longest time.
ImageRows::Begun& ImageRows::place_for(std::uint64_t sender) {
    Begun* best = &begun_.front();
    for (Begun& one : begun_) {
        if (!one.pixels.empty() && one.sender == sender) return one;
        if (best->pixels.empty()) continue;
        if (one.pixels.empty() || one.heard_ns < best->heard_ns) best = &one;
    }
    return *best;
}

// With one bit per pixel, the highest bit is the leftmost pixel.
void ImageRows::append_rows(const Head& head, ano::Bytes rows, std::vector<std::uint8_t>& pixels) {
    if (head.color == grey) {
        pixels.insert(pixels.end(), rows.begin(), rows.end());
        return;
    }
    const std::size_t row = head.row_size();
    for (std::size_t at = 0; at < rows.size(); at += row)
        for (std::size_t x = 0; x < head.width; ++x)
            pixels.push_back((rows[at + x / 8] >> (7 - x % 8) & 1) != 0 ? std::uint8_t{255} : std::uint8_t{0});
}

}    // namespace anogate
