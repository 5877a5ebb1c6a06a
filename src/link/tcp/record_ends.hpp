// Where the records of a TLS handshake end.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace anogate {

/// Counts the bytes that OpenSSL has read (RFC 8446, 5.1): it may hold the beginning of a record whose rest is not yet received.
class RecordEnds {
public:
    static constexpr std::size_t header_size = 5;
    static constexpr std::size_t max_body = 16 * 1024 + 256;

    void took(std::span<const std::uint8_t> bytes) noexcept {
        while (!bytes.empty()) {
            const std::size_t size = body_ > 0 ? std::min(body_, bytes.size()) : 1;
            if (body_ > 0) body_ -= size;
            else read_header(bytes[0]);
            bytes = bytes.subspan(size);
        }
    }
    /// Number of bytes up to the end of the next record, or up to the end of its header if `waiting`, the next bytes, does not
    /// contain that.
    int missing(std::span<const std::uint8_t> waiting) const noexcept {
        if (body_ > 0) return static_cast<int>(std::min(body_, max_body));
        const std::size_t header = header_size - has_;
        if (waiting.size() < header) return static_cast<int>(header);
        RecordEnds then = *this;
        then.took(waiting.first(header));
        return static_cast<int>(header + std::min(then.body_, max_body));
    }

private:
    void read_header(std::uint8_t byte) noexcept {
        header_[has_++] = byte;
        if (has_ < header_size) return;
        body_ = std::size_t{header_[3]} << 8 | header_[4];
        has_ = 0;
    }

    std::array<std::uint8_t, header_size> header_{};
    std::size_t has_ = 0;     // bytes of the header
    std::size_t body_ = 0;    // bytes still to be read
};

}    // namespace anogate
