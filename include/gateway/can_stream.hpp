// V8 frames on CAN, framing=stream: the bytes of each frame in order, in the data of CAN frames whose id identifies the sender.
// This mapping is specific to anogate: the protocol text does not mention CAN (src/link/README.md, "CAN").
//
// Flow, sending:      pieces = cutter.cut(outbox.gather(…))       // as many CAN frames as there is room for
//                     outbox.sent(cutter.taken(n))                // the bus accepted the first n of them
// Flow, receiving:    streams.receive(id, data, now, on_frame)
//                     at streams.deadline(): streams.expire(now, on_frame)
#pragma once
#include <ano/parser.hpp>
#include <gateway/can_settings.hpp>
#include <gateway/counters.hpp>
#include <gateway/settings.hpp>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace anogate {

/// The error in `can`, as a sentence; empty: it is valid.
std::string fault_of(const CanSettings& can);

/// The smallest legal size of the data of a CAN FD frame that holds `bytes`, 0 to 64.
constexpr std::uint8_t can_fd_size(std::size_t bytes) noexcept {
    if (bytes <= 8) return static_cast<std::uint8_t>(bytes);
    if (bytes <= 24) return static_cast<std::uint8_t>((bytes + 3) / 4 * 4);
    return bytes <= 32 ? 32 : bytes <= 48 ? 48 : 64;
}

/// The CAN id of a V8 frame. 11-bit: base + S_ADDR. 29-bit: base + class × 65536 + S_ADDR × 256 + D_ADDR, where class is
/// 0 urgent, 1 telemetry, 2 bulk: the lower id wins the bus.
class CanIds {
public:
    static constexpr std::uint32_t default_base = 0x600;
    static constexpr std::uint32_t default_extended_base = 0x0AB0'0000;

    explicit CanIds(const CanSettings& can) noexcept
        : base_{can.base.value_or(can.extended ? default_extended_base : default_base)}, extended_{can.extended} {}

    /// `header` begins with HEAD to ID of a frame.
    std::uint32_t of(std::span<const std::uint8_t> header) const noexcept;
    /// The S_ADDR that V8 frames with the CAN id `id` must have; std::nullopt: it is not one of our ids.
    std::optional<std::uint8_t> source(std::uint32_t id) const noexcept;

    /// Filters that accept all our ids and no others: an id passes when (id & mask) == base for one of them.
    struct Filter {
        std::uint32_t id;
        std::uint32_t mask;
    };
    std::vector<Filter> filters() const;
    std::uint32_t base() const noexcept { return base_; }

private:
    std::uint32_t base_;
    bool extended_;
};

/// Cuts V8 frames into the data of CAN frames. A V8 frame begins a new CAN frame.
class CanCutter {
public:
    explicit CanCutter(const CanSettings& can) noexcept : ids_{can}, fd_{can.fd} {}

    struct Piece {
        std::uint32_t id;
        std::span<const std::uint8_t> bytes;
        std::uint8_t size;    // of the data of the CAN frame: bytes.size(), or more with CAN FD, padded with 0x00
        bool last;            // the last piece of its V8 frame
    };
    /// `frames`: as returned by Outbox::gather(). The result is valid until the next call, and only as long as those bytes are.
    std::span<const Piece> cut(std::span<const std::span<const std::uint8_t>> frames) noexcept;
    /// The bus accepted the first `n` of the last cut pieces. Returns the number of bytes of V8 frames in them.
    std::size_t taken(std::size_t n) noexcept;
    /// Abandons a partly sent frame.
    void reset() noexcept { rest_id_.reset(); }

    static constexpr std::size_t max_pieces = 64;    // that cut() returns

private:
    CanIds ids_;
    bool fd_;
    std::optional<std::uint32_t> rest_id_;    // the CAN id of a partly sent frame, whose rest does not contain the header
    std::array<Piece, max_pieces> pieces_;
};

/// Joins the data of each CAN id to V8 frames, with one parser per id, so senders never mix. At most 256 ids; on a 29-bit bus
/// with more, a new id replaces the least recently used one. Does not allocate for a known id.
class CanStreams {
public:
    static constexpr std::size_t max_streams = 256;

    CanStreams(const CanSettings& can, std::size_t max_data) : ids_{can}, max_data_{max_data} {}

    /// Processes the data of one CAN frame. Calls `on_frame` for each valid frame whose S_ADDR matches the id.
    template <class OnFrame>
    void receive(std::uint32_t id, std::span<const std::uint8_t> data, TimePoint now, OnFrame on_frame) {
        Stream* stream = find(id);
        if (!stream) {
            if (!begins_stream(id, data)) return;
            stream = &open(id, on_frame);
        }
        put(*stream, data, now);
        drain(*stream, on_frame);
    }
    /// Abandons incomplete frames whose rest is overdue. Call at deadline().
    template <class OnFrame>
    void expire(TimePoint now, OnFrame on_frame) {
        for (Stream& stream : streams_)
            if (stream.parser.expire(now)) drain(stream, on_frame);
    }
    std::optional<TimePoint> deadline() const noexcept;
    /// Call when the bus is down: abandons incomplete frames.
    template <class OnFrame>
    void finish(OnFrame on_frame) {
        for (Stream& stream : streams_) {
            stream.parser.finish();
            drain(stream, on_frame);
        }
    }

    /// The sum for all ids. A frame whose S_ADDR does not match its id counts as denied_in.
    ReceiveCounters received() const noexcept;
    /// Only the frames whose S_ADDR does not match their id.
    std::uint64_t wrong_source() const noexcept { return refused_.denied_in; }
    std::size_t size() const noexcept { return streams_.size(); }

private:
    struct Stream {
        std::uint32_t id;
        std::uint8_t source;
        std::uint64_t used;    // a larger number was used later
        ano::FrameParser parser;
    };

    Stream* find(std::uint32_t id) noexcept;
    bool begins_stream(std::uint32_t id, std::span<const std::uint8_t> data) noexcept;
    void put(Stream& stream, std::span<const std::uint8_t> data, TimePoint now) noexcept;
    Stream& unused_longest() noexcept;

    template <class OnFrame>
    Stream& open(std::uint32_t id, OnFrame on_frame) {
        const std::uint8_t source = *ids_.source(id);
        if (streams_.size() < max_streams) {
            ano::FrameParser::Options options;
            options.max_data = max_data_;
            options.zero_padding = true;
            return streams_.emplace_back(Stream{id, source, 0, ano::FrameParser{options}});
        }
        Stream& stream = unused_longest();
        stream.parser.finish();
        drain(stream, on_frame);
        stream.id = id;
        stream.source = source;
        return stream;
    }

    template <class OnFrame>
    void drain(Stream& stream, OnFrame on_frame) {
        while (const auto frame = stream.parser.next()) {
            if (frame->source() == stream.source) on_frame(*frame);
            else ++refused_.denied_in;
        }
    }

    CanIds ids_;
    std::size_t max_data_;
    std::vector<Stream> streams_;
    std::uint64_t uses_ = 0;
    ReceiveCounters refused_;    // frames that belong to no stream
};

}    // namespace anogate
