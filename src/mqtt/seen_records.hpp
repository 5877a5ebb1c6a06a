// Which records a reader has, so that a record that comes again is dropped. No I/O.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace anogate {

class SeenRecords {
public:
    /// False: this record was added before.
    bool add(std::string_view stream, std::uint64_t seq);
    /// Of all streams: gaps cost memory, not records.
    std::size_t ranges() const noexcept;

private:
    using Ranges = std::map<std::uint64_t, std::uint64_t>;    // from the first to the last
    std::map<std::string, Ranges, std::less<>> streams_;
};

}    // namespace anogate
