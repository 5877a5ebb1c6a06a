// The totals of a recording: links, messages, rates, losses. No I/O.
#pragma once
#include <record/recording.hpp>

#include <array>
#include <bitset>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

struct LinkCounts {
    std::string description;
    std::array<std::uint64_t, 3> frames{};    // indexed by Direction
    std::map<std::string, std::uint64_t> causes;

    friend bool operator==(const LinkCounts&, const LinkCounts&) = default;
};

struct MessageCounts {
    std::uint64_t frames = 0, bytes = 0;
    std::bitset<256> from;    // source addresses

    friend bool operator==(const MessageCounts&, const MessageCounts&) = default;
};

struct RecordingCounts {
    void add(const RecordedFrame& frame);
    void add(const RecordedLoss& loss);
    void add(const Recorded& item);

    /// The length of the recording in seconds; by the boot-time clock if the recording has it, because that clock is never set.
    double seconds() const;
    /// By how many seconds the system clock was set during the recording; 0: it was not.
    double clock_was_set() const;
    /// `number` per second.
    double rate(std::uint64_t number) const { return seconds() > 0 ? static_cast<double>(number) / seconds() : 0; }

    /// As JSON, complete: of_json() restores all of it.
    std::string json() const;
    /// std::nullopt: `text` is not a result of json().
    static std::optional<RecordingCounts> of_json(std::string_view text);

    std::uint64_t frames = 0, bytes = 0, lost = 0;
    std::uint64_t first = 0, last = 0;                      // ns since 1970, in the order of the recording
    std::uint64_t first_boottime = 0, last_boottime = 0;    // ns
    std::map<std::string, LinkCounts> links;                // by link name
    std::array<MessageCounts, 256> messages;                // by id
    std::map<std::string, std::uint64_t> lost_messages;

    friend bool operator==(const RecordingCounts&, const RecordingCounts&) = default;
};

}    // namespace anogate
