// The constants of MCAP (mcap.dev/spec), and how a recording is stored in it.
//
//   a frame                   a message of the channel /anogate/frames, as CDR with the schema in mcap_items.hpp: log_time and
//                             publish_time are its time since 1970, the rest is in the message. CDR even if decoded messages are JSON
//   a loss                    a message of the channel /anogate/losses before the next frame, with the time of that frame
//   decoded messages          a channel for each link, device and message; after their frame, with its time
//   program, both clocks      the Metadata "anogate.recording" after the Header
//   decoding                  the Metadata "anogate.decoding" after that, and again before the first frame for which it has changed
//   totals                    the Metadata "anogate.summary" before DataEnd: links, messages, rates and losses, for programs that read
//                             only the end of the file
//   the end                   Footer and magic: a file without them was not ended properly
//
// Everything else is usual: chunks compressed with zstd, each followed by a MessageIndex for each channel, and a summary with Statistics,
// ChunkIndex, MetadataIndex and SummaryOffset; all CRCs are set.
#pragma once
#include <ano/wire.hpp>

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

namespace anogate::mcap {

inline constexpr std::string_view magic{"\x89MCAP0\r\n", 8};
inline constexpr std::size_t record_head = 9;    // opcode and length
inline constexpr std::size_t footer_size = record_head + 20;
inline constexpr std::size_t max_chunk = 64 * 1024 * 1024;          // bytes, uncompressed, when reading
inline constexpr std::size_t max_record = max_chunk + 64 * 1024;    // bytes without its head

enum class Opcode : std::uint8_t {
    header = 1,
    footer,
    schema,
    channel,
    message,
    chunk,
    message_index,
    chunk_index,
    attachment,
    attachment_index,
    statistics,
    metadata,
    metadata_index,
    summary_offset,
    data_end,
};

inline constexpr std::string_view frames_topic = "/anogate/frames";
inline constexpr std::string_view losses_topic = "/anogate/losses";
inline constexpr std::string_view head_name = "anogate.recording";    // program, time_ns, boottime_ns
inline constexpr std::string_view decoding_name =
    "anogate.decoding";    // json: Decoding::text(); after_ns: time of the frame before
inline constexpr std::string_view counts_name = "anogate.summary";    // json

template <std::unsigned_integral T>
void append_le(std::string& out, T number) {
    std::uint8_t bytes[sizeof number];
    ano::store(bytes, number);
    out.append(reinterpret_cast<const char*>(bytes), sizeof number);
}

/// Appends the length in four bytes, then the text.
inline void append_string(std::string& out, std::string_view text) {
    append_le(out, static_cast<std::uint32_t>(text.size()));
    out += text;
}

/// Appends the head of a record; end_record() sets its length and needs the result of this.
inline std::size_t begin_record(std::string& out, Opcode opcode) {
    out += static_cast<char>(opcode);
    append_le(out, std::uint64_t{0});
    return out.size();
}
inline void end_record(std::string& out, std::size_t begun) {
    ano::store(reinterpret_cast<std::uint8_t*>(out.data()) + begun - 8, static_cast<std::uint64_t>(out.size() - begun));
}

/// Reads fields from the front of a record. A field beyond its end is 0 or empty, and is_bad() is true from then on.
class Fields {
public:
    explicit Fields(std::string_view body) noexcept : rest_{body} {}

    template <std::unsigned_integral T>
    T number() noexcept {
        const std::string_view taken = bytes(sizeof(T));
        return taken.empty() ? T{0} : ano::load<T>(reinterpret_cast<const std::uint8_t*>(taken.data()));
    }
    std::string_view bytes(std::uint64_t size) noexcept {
        if (size > rest_.size()) {
            bad_ = true;
            rest_ = {};
            return {};
        }
        const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(size));
        rest_.remove_prefix(taken.size());
        return taken;
    }
    std::string_view text() noexcept { return bytes(number<std::uint32_t>()); }
    std::string_view rest() const noexcept { return rest_; }
    bool is_bad() const noexcept { return bad_; }

private:
    std::string_view rest_;
    bool bad_ = false;
};

/// Refers to the memory that it was read from.
struct Record {
    Opcode opcode;
    std::string_view body;
    std::string_view whole;    // including its head
};

/// Removes the first record from `bytes` and returns it; std::nullopt: it is incomplete.
std::optional<Record> next_record(std::string_view& bytes) noexcept;

struct Message {
    std::uint16_t channel = 0;
    std::uint32_t sequence = 0;
    std::uint64_t log_time = 0, publish_time = 0;
    std::string_view data;
};
std::optional<Message> message_of(std::string_view body) noexcept;
void append_message(std::string& out, const Message& message);

/// A schema: its `text` is in `encoding`.
struct SchemaRecord {
    std::uint16_t id = 0;
    std::string_view name, encoding, text;
};
void append_schema(std::string& out, const SchemaRecord& schema);

struct ChannelRecord {
    std::uint16_t id = 0, schema = 0;
    std::string_view topic, encoding;
};
std::optional<ChannelRecord> channel_of(std::string_view body) noexcept;
/// Appends the record as the profile ros2 requires, without qualities of service.
void append_channel(std::string& out, const ChannelRecord& channel);

struct Pair {
    std::string_view key, value;
};
void append_metadata(std::string& out, std::string_view name, std::initializer_list<Pair> pairs);
std::string_view name_of_metadata(std::string_view body) noexcept;
/// Empty if there is no such key.
std::string_view metadata_at(std::string_view body, std::string_view key) noexcept;

}    // namespace anogate::mcap
