// Which bytes of a file a request wants.
#pragma once
#include <cstdint>
#include <string_view>

namespace anogate::http {

struct Range {
    enum class Kind : std::uint8_t {
        whole,      // it names none, or in a way that may be passed over
        part,       // these: 206
        outside,    // none that there are: 416
    };
    Kind kind = Kind::whole;
    std::uint64_t first = 0;
    std::uint64_t size = 0;    // bytes; of the whole as well
};

/// Of the header Range of a request for what has `size` bytes. Several ranges are answered with the whole.
Range wanted_range(std::string_view header, std::uint64_t size);

}    // namespace anogate::http
