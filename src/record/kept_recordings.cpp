#include <record/kept_recordings.hpp>

#include <algorithm>
#include <string_view>
#include <tuple>
#include <utility>

namespace anogate {
namespace {

constexpr std::chrono::seconds clock_was_set{1'577'836'800};    // 2020-01-01
constexpr std::chrono::seconds far_ahead = std::chrono::hours{24} * 365 * 15;

bool is_far_ahead(std::chrono::seconds changed, std::chrono::seconds since_1970) {
    return changed > std::max(since_1970, clock_was_set) + far_ahead;
}

// Sort key: oldest first. Among the files of one recording that changed in the same second, "flight.pcapng" is first, and
// "flight-10.pcapng" comes after "flight-9.pcapng".
auto order_of(const KeptRecording& recording) {
    return std::tuple{-recording.age, !recording.is_far_ahead, recording.changed, recording.name.size(),
                      std::string_view{recording.name}};
}

std::vector<std::size_t> oldest_first(std::span<const KeptRecording> recordings) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < recordings.size(); ++i)
        if (!recordings[i].is_written) order.push_back(i);
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return order_of(recordings[a]) < order_of(recordings[b]); });
    return order;
}

// The recordings that are kept unless they are too old, by their index.
struct Staying {
    std::vector<bool> for_bytes, for_free;
};

// While a recording is being written, the newest of the others may be deleted for free bytes, but not for `bytes`.
Staying which_stay(std::span<const KeptRecording> recordings, const std::vector<std::size_t>& order) {
    Staying stay{std::vector<bool>(recordings.size()), std::vector<bool>(recordings.size())};
    for (std::size_t i = 0; i < recordings.size(); ++i)
        stay.for_bytes[i] = stay.for_free[i] = recordings[i].is_written || recordings[i].is_just_saved;
    if (order.empty()) return stay;
    stay.for_bytes[order.back()] = true;
    if (order.size() == recordings.size()) stay.for_free[order.back()] = true;
    return stay;
}

// For each time of a change: how much older than the newest file it is, without the longest pause in between. Ignores the file
// being written, because its time is that of the clock; files ahead of the clock if the clock is set; and files far ahead.
std::map<std::chrono::seconds, std::chrono::seconds> ages_by_time(std::span<const KeptRecording> recordings,
                                                                  std::chrono::seconds since_1970) {
    const bool is_set = since_1970 >= clock_was_set;
    std::map<std::chrono::seconds, std::chrono::seconds> ages;
    for (const KeptRecording& recording : recordings)
        if (!recording.is_written && !is_far_ahead(recording.changed, since_1970) && (!is_set || recording.changed <= since_1970))
            ages[recording.changed] = {};
    if (ages.empty()) return ages;
    std::chrono::seconds newer = ages.rbegin()->first, sum{}, longest{};
    for (auto older = ages.rbegin(); older != ages.rend(); ++older) {
        const std::chrono::seconds pause = std::exchange(newer, older->first) - older->first;
        sum += pause;
        longest = std::max(longest, pause);
        older->second = sum - longest;
    }
    return ages;
}

}    // namespace

void RecordingAges::look(std::span<KeptRecording> recordings, seconds since_1970, seconds steady) {
    std::map<seconds, seconds> ages;
    if (!looked_at_) ages = ages_by_time(recordings, since_1970);
    const auto age_when_seen = [&](const KeptRecording& recording) {
        if (recording.changed < clock_was_set) return seconds::zero();
        if (looked_at_) return std::min(std::max(since_1970 - recording.changed, seconds::zero()), steady - *looked_at_);
        const auto known_age = ages.find(recording.changed);
        return known_age == ages.end() ? seconds::zero() : known_age->second;
    };
    std::map<std::string, Seen> seen;
    for (KeptRecording& recording : recordings) {
        const auto before = seen_.find(recording.name);
        if (before != seen_.end() && before->second.changed == recording.changed) seen.insert(*before);
        else
            seen[recording.name] = {recording.changed, age_when_seen(recording), steady,
                                    is_far_ahead(recording.changed, since_1970)};
        const Seen& is = seen.at(recording.name);
        recording.age = is.age + (steady - is.at);
        recording.is_far_ahead = is.is_far_ahead;
    }
    seen_ = std::move(seen);
    looked_at_ = steady;
}

RecordingsToDelete recordings_to_delete(std::span<const KeptRecording> recordings, const KeepLimits& limits,
                                        std::uint64_t free_bytes) {
    const std::vector<std::size_t> order = oldest_first(recordings);
    const Staying stay = which_stay(recordings, order);
    std::uint64_t all = 0, may_go = 0;
    for (std::size_t i = 0; i < recordings.size(); ++i) {
        all += recordings[i].bytes;
        if (!stay.for_free[i]) may_go += recordings[i].bytes;
    }
    std::uint64_t wanted = free_bytes < limits.free ? limits.free - free_bytes : 0;
    if (wanted > may_go) wanted = 0;

    RecordingsToDelete result;
    for (const std::size_t i : order) {
        const KeptRecording& recording = recordings[i];
        const bool is_too_old = limits.age > std::chrono::seconds::zero() && recording.age > limits.age;
        const bool is_beyond = limits.bytes != 0 && all > limits.bytes;
        if (!is_too_old && !is_beyond && wanted == 0) break;
        const bool may_go_now = (is_beyond && !stay.for_bytes[i]) || (wanted > 0 && !stay.for_free[i]);
        if (!is_too_old && !may_go_now) {
            if (stay.for_free[i]) result.stays = i;
            continue;
        }
        result.going.push_back(i);
        all -= recording.bytes;
        wanted -= std::min(wanted, recording.bytes);
    }
    if (limits.bytes == 0 || all <= limits.bytes) result.stays.reset();
    return result;
}

}    // namespace anogate
