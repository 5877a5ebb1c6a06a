// What all frames of a recording come to: links, messages, rates, losses. No I/O.
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
    std::array<std::uint64_t, 3> frames{};    // by Direction
    std::map<std::string, std::uint64_t> causes;

    friend bool operator==(const LinkCounts&, const LinkCounts&) = default;
};

struct MessageCounts {
    std::uint64_t frames = 0, bytes = 0;
    std::bitset<256> from;    // addresses

    friend bool operator==(const MessageCounts&, const MessageCounts&) = default;
};

struct RecordingCounts {
    void add(const RecordedFrame& frame);
    void add(const RecordedLoss& loss);
    void add(const Recorded& item);

    /// How long it is. By the clock that nobody sets, where the recording has it.
    double seconds() const;
    /// By how much the clock was set meanwhile, seconds; 0: it was not.
    double clock_was_set() const;
    /// A second.
    double rate(std::uint64_t number) const { return seconds() > 0 ? static_cast<double>(number) / seconds() : 0; }

    /// As JSON, which keeps everything.
    std::string json() const;
    /// Nothing: `text` is not what json() gives.
    static std::optional<RecordingCounts> of_json(std::string_view text);

    std::uint64_t frames = 0, bytes = 0, lost = 0;
    std::uint64_t first = 0, last = 0;                      // ns since 1970, in the order of the recording
    std::uint64_t first_boottime = 0, last_boottime = 0;    // ns
    std::map<std::string, LinkCounts> links;                // by name
    std::array<MessageCounts, 256> messages;                // by id
    std::map<std::string, std::uint64_t> lost_messages;

    friend bool operator==(const RecordingCounts&, const RecordingCounts&) = default;
};

}    // namespace anogate
