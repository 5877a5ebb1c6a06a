#include "pictures.hpp"

#include <ano/reading.hpp>
#include <ano/typed.hpp>

#include <algorithm>
#include <utility>

namespace anoctl {
namespace {

constexpr std::size_t colors = 7;

bool are_of_one(const Picture& a, const Picture& b) {
    return a.flag == b.flag && a.color == b.color && a.width == b.width && a.height == b.height;
}

// The reason why a frame can't be part of a picture. Empty: it can.
std::string fault_of(const Picture& picture, std::size_t bytes) {
    if (picture.color >= colors) return "colour " + std::to_string(picture.color) + " is none";
    const std::string size = std::to_string(picture.width) + "x" + std::to_string(picture.height);
    if (picture.width == 0 || picture.height == 0) return "a picture of " + size + " has no pixels";
    if (picture.row_bytes() * picture.height > Pictures::max_bytes) return "a picture of " + size + " is too large";
    if (bytes == 0) return "the frame has no rows";
    if (bytes % picture.row_bytes() != 0)
        return std::to_string(bytes) + " bytes are not a whole number of rows of " + std::to_string(picture.row_bytes());
    if (bytes / picture.row_bytes() > picture.height) return "the frame has more rows than a picture of " + size;
    return {};
}

}    // namespace

std::string color_name(std::uint8_t color) {
    const ano::Field* field = ano::find_message(0xB0)->field("color");
    for (const ano::Meaning& meaning : field->meanings)
        if (meaning.value == color) return std::string{meaning.text};
    return {};
}

Pictures::Taken Pictures::accept(ano::FrameView frame, ano::TimePoint now, double time) {
    Taken taken;
    if (frame.id() != 0xB0) return taken;
    const auto image = ano::as<"image">(frame);
    if (!image) {
        taken.fault = "the frame is too short";
        return taken;
    }
    Picture part{
        frame.source(), image->get<"flag">(), image->get<"color">(), image->get<"width">(), image->get<"height">(), {}, {}, time};
    const auto pixels = image->get<"pixels">();
    taken.fault = fault_of(part, pixels.size());
    if (!taken.fault.empty()) return taken;
    std::copy_n(image->get<"val">().begin(), part.value.size(), part.value.begin());
    part.is_first = !heard_[part.source];
    heard_.set(part.source);

    const auto known = begun_.find(frame.source());
    if (known != begun_.end()) {
        Picture& before = known->second.picture;
        const bool fits = before.rows() + pixels.size() / part.row_bytes() <= before.height;
        if (!are_of_one(before, part) || !fits || now - known->second.last > pause) {
            taken.ended.push_back(std::move(before));
            begun_.erase(known);
        }
    }
    Begun& begun = begun_.try_emplace(frame.source(), Begun{std::move(part), now}).first->second;
    begun.last = now;
    begun.picture.pixels.insert(begun.picture.pixels.end(), pixels.begin(), pixels.end());
    if (begun.picture.is_whole()) {
        taken.ended.push_back(std::move(begun.picture));
        begun_.erase(frame.source());
    }
    return taken;
}

std::vector<Picture> Pictures::end() {
    std::vector<Picture> all;
    for (auto& [source, begun] : begun_) all.push_back(std::move(begun.picture));
    begun_.clear();
    return all;
}

}    // namespace anoctl
