// The header Range: which bytes of a file a request asks for.
#pragma once
#include <cstdint>
#include <string_view>

namespace anogate::http {

struct Range {
    enum class Kind : std::uint8_t {
        whole,      // no Range, or one that may be ignored
        part,       // 206
        outside,    // beyond the end: 416
    };
    Kind kind = Kind::whole;
    std::uint64_t first = 0;
    std::uint64_t size = 0;    // bytes; set for `whole` too
};

/// `header`: the value of Range, for a file of `size` bytes. Several ranges are answered with the whole file.
Range wanted_range(std::string_view header, std::uint64_t size);

}    // namespace anogate::http
