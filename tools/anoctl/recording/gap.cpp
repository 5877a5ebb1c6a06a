#include "gap.hpp"

#include <ano/v7.hpp>

#include <cstddef>

namespace anoctl {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// The start of the longest sequence of frames that ends at the end of `gap`.
std::size_t last_row(Bytes gap, std::size_t (*frame_size)(Bytes)) {
    std::vector<bool> in_row(gap.size() + 1);
    in_row[gap.size()] = true;
    std::size_t first = gap.size();
    for (std::size_t at = gap.size(); at-- > 0;) {
        const std::size_t size = frame_size(gap.subspan(at));
        if (size == 0 || !in_row[at + size]) continue;
        in_row[at] = true;
        first = at;
    }
    return first;
}

std::size_t whole(Bytes bytes, std::size_t size) { return size <= bytes.size() ? size : 0; }

}    // namespace

std::size_t v8_frame_size(Bytes bytes) {
    if (bytes.size() < ano::overhead || bytes[0] != ano::head) return 0;
    return whole(bytes, ano::overhead + bytes[4] + 256u * bytes[5]);
}

std::size_t v7_frame_size(Bytes bytes) {
    if (bytes.size() < ano::v7::overhead || bytes[0] != ano::v7::head) return 0;
    return whole(bytes, ano::v7::overhead + bytes[3]);
}

std::vector<GapPart> parts_of(Bytes gap, std::size_t (*frame_size)(Bytes)) {
    std::vector<GapPart> parts;
    const auto read_frames = [&] {
        for (std::size_t size = frame_size(gap); size > 0; size = frame_size(gap)) {
            parts.push_back({gap.first(size), ano::checks_of(gap.first(size - 2))});
            gap = gap.subspan(size);
        }
    };
    read_frames();
    if (const std::size_t row = last_row(gap, frame_size); row > 0) {
        parts.push_back({gap.first(row), {}});
        gap = gap.subspan(row);
    }
    read_frames();
    return parts;
}

}    // namespace anoctl
