// Any bytes as an MCAP file: read from begin to end, by its index, and repaired.
#include <record/mcap/mcap_index.hpp>
#include <record/recording_repair.hpp>
#include <support/recorded.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

void require(bool holds) {
    if (!holds) std::abort();
}

std::string repaired(std::string_view file) {
    anogate::RecordingRepair repair{anogate::RecordingFormat::mcap};
    repair.feed(file);
    const auto result = repair.finish();
    require(result.keep <= file.size());
    if (!result.is_recording) return {};
    return std::string{file.substr(0, result.keep)} + result.append;
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0 || size > 65536) return 0;
    const std::string_view file{reinterpret_cast<const char*>(data), size};
    require(support::holds_the_laws_of_recordings(file));
    anogate::read_mcap_index(size, [&](std::uint64_t at, std::size_t bytes) {
        return std::string{file.substr(static_cast<std::size_t>(std::min<std::uint64_t>(at, size)), bytes)};
    });
    const std::string once = repaired(file);
    if (once.empty()) return 0;
    require(support::read_recording(once).has_end);
    require(repaired(once) == once);
    return 0;
}
