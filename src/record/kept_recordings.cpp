#include <record/kept_recordings.hpp>

#include <algorithm>
#include <string_view>
#include <tuple>

namespace anogate {
namespace {

// Of the files of one recording that changed in the same second, "flight.pcapng" is the first, and "flight-10.pcapng" behind
// "flight-9.pcapng".
auto age_of(const KeptRecording& recording) {
    return std::tuple{recording.time, recording.name.size(), std::string_view{recording.name}};
}

std::vector<std::size_t> oldest_first(std::span<const KeptRecording> recordings) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < recordings.size(); ++i)
        if (!recordings[i].is_written) order.push_back(i);
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return age_of(recordings[a]) < age_of(recordings[b]); });
    return order;
}

}    // namespace

std::vector<std::size_t> recordings_to_delete(std::span<const KeptRecording> recordings, const KeepLimits& limits,
                                              std::chrono::seconds now, std::uint64_t free_bytes) {
    const std::vector<std::size_t> order = oldest_first(recordings);
    std::uint64_t all = 0, may_go = 0;
    for (const KeptRecording& recording : recordings) all += recording.bytes;
    for (const std::size_t i : order) may_go += recordings[i].bytes;
    std::uint64_t wanted = free_bytes < limits.free ? limits.free - free_bytes : 0;
    if (wanted > may_go) wanted = 0;

    std::vector<std::size_t> going;
    for (const std::size_t i : order) {
        const KeptRecording& recording = recordings[i];
        const bool is_too_old = limits.age > std::chrono::seconds::zero() && now - recording.time > limits.age;
        if (!is_too_old && (limits.bytes == 0 || all <= limits.bytes) && wanted == 0) break;
        going.push_back(i);
        all -= recording.bytes;
        wanted -= std::min(wanted, recording.bytes);
    }
    return going;
}

}    // namespace anogate
