// Finds the MAVLink packets in a stream of bytes.
//
// Flow:    auto room = parser.prepare();              // read into it
//          parser.commit(n);
//          while (auto packet = parser.next()) …      // each view is valid until the next prepare()
//          if no byte follows within PacketParser::quiet: parser.give_up(), and next() again
#pragma once
#include <ano/time.hpp>
#include <mavlink/packet.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace anogate::mavlink {

/// Counters of the bytes. bytes_in = the bytes of packets + skipped_bytes + the waiting bytes.
struct ParserCounters {
    std::uint64_t packets = 0;
    std::uint64_t bytes_in = 0;
    std::uint64_t bad_crc = 0;          // candidates with a wrong checksum
    std::uint64_t unknown = 0;          // candidates of messages that are not in the table: their checksum can't be verified
    std::uint64_t skipped_bytes = 0;    // outside of packets
};

enum class Transport : std::uint8_t {
    lossy,    // a serial line. After a refused candidate the search continues one byte later, so that a damaged packet never takes
              // others with it.
    reliable,    // UDP, TCP. A refused packet is skipped as a whole: it may carry packets as data, which must not be carried out.
};

/// Linear time for any input: a byte belongs to at most max_packet candidates. Neither throws nor allocates.
class PacketParser {
public:
    static constexpr ano::Duration quiet = std::chrono::milliseconds{50};

    explicit PacketParser(Transport transport) noexcept : transport_{transport} {}

    /// Room for the next bytes, at least max_packet if next() was called until it returned std::nullopt. Invalidates all views.
    std::span<std::uint8_t> prepare() noexcept;
    void commit(std::size_t n) noexcept;
    /// The next packet with a valid checksum; std::nullopt: none is complete.
    std::optional<PacketView> next() noexcept;
    /// The rest of a waiting candidate will not be received: the search continues after it. At the end of every datagram, too.
    void give_up() noexcept { barrier_ = end_; }

    std::size_t waiting() const noexcept { return end_ - pos_; }
    const ParserCounters& counters() const noexcept { return counters_; }

private:
    enum class Verdict : std::uint8_t { good, bad, incomplete };
    Verdict judge(std::size_t& size) noexcept;
    void skip(std::size_t n) noexcept;
    void skip_to_magic() noexcept;

    Transport transport_;
    ParserCounters counters_;
    std::array<std::uint8_t, 4096> buffer_{};
    std::size_t pos_ = 0, end_ = 0;
    std::size_t barrier_ = 0;    // candidates that begin before it are not waited for
};

}    // namespace anogate::mavlink
