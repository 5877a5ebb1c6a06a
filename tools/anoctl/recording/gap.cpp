#include "gap.hpp"

#include <cstddef>

namespace anoctl {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// The size of the frame at the beginning of `bytes`; 0: none, or it is incomplete.
std::size_t frame_size(Bytes bytes) {
    if (bytes.size() < ano::overhead || bytes[0] != ano::head) return 0;
    const std::size_t size = ano::overhead + bytes[4] + 256u * bytes[5];
    return size <= bytes.size() ? size : 0;
}

/// The start of the longest sequence of frames that ends at the end of `gap`.
std::size_t last_row(Bytes gap) {
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

}    // namespace

std::vector<GapPart> parts_of(Bytes gap) {
    std::vector<GapPart> parts;
    const auto read_frames = [&] {
        for (std::size_t size = frame_size(gap); size > 0; size = frame_size(gap)) {
            parts.push_back({gap.first(size), ano::checks_of(gap.first(size - 2))});
            gap = gap.subspan(size);
        }
    };
    read_frames();
    if (const std::size_t row = last_row(gap); row > 0) {
        parts.push_back({gap.first(row), {}});
        gap = gap.subspan(row);
    }
    read_frames();
    return parts;
}

}    // namespace anoctl
