#include <mqtt/seen_records.hpp>

#include <iterator>

namespace anogate {

bool SeenRecords::add(std::string_view stream, std::uint64_t seq) {
    auto found = streams_.find(stream);
    if (found == streams_.end()) found = streams_.try_emplace(std::string{stream}).first;
    Ranges& ranges = found->second;
    const auto after = ranges.upper_bound(seq);
    const auto before = after == ranges.begin() ? ranges.end() : std::prev(after);
    if (before != ranges.end() && seq <= before->second) return false;
    const bool joins_before = before != ranges.end() && before->second + 1 == seq;
    const bool joins_after = after != ranges.end() && after->first == seq + 1;
    const std::uint64_t last = joins_after ? after->second : seq;
    if (joins_after) ranges.erase(after);
    if (joins_before) before->second = last;
    else ranges.emplace(seq, last);
    return true;
}

std::size_t SeenRecords::ranges() const noexcept {
    std::size_t count = 0;
    for (const auto& [stream, ranges] : streams_) count += ranges.size();
    return count;
}

}    // namespace anogate
