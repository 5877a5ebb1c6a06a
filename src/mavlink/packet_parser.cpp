#include <mavlink/packet_parser.hpp>

#include <algorithm>

namespace anogate::mavlink {

std::span<std::uint8_t> PacketParser::prepare() noexcept {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(pos_), buffer_.begin() + static_cast<std::ptrdiff_t>(end_),
              buffer_.begin());
    barrier_ -= std::min(barrier_, pos_);
    end_ -= pos_;
    pos_ = 0;
    return std::span{buffer_}.subspan(end_);
}

void PacketParser::commit(std::size_t n) noexcept {
    end_ += n;
    counters_.bytes_in += n;
}

std::optional<PacketView> PacketParser::next() noexcept {
    for (;;) {
        skip_to_magic();
        std::size_t size = 1;
        const Verdict verdict = judge(size);
        if (verdict == Verdict::incomplete && pos_ >= barrier_) return std::nullopt;
        if (verdict == Verdict::good) {
            const PacketView packet{std::span{buffer_}.subspan(pos_, size)};
            pos_ += size;
            ++counters_.packets;
            return packet;
        }
        if (transport_ == Transport::lossy) skip(1);
        else skip(verdict == Verdict::incomplete ? barrier_ - pos_ : size);
    }
}

// `size`: of the candidate, once it is known.
PacketParser::Verdict PacketParser::judge(std::size_t& size) noexcept {
    constexpr std::size_t needed = 3;    // for packet_size()
    const auto bytes = std::span{buffer_}.subspan(pos_, end_ - pos_);
    if (bytes.size() < needed || bytes.size() < header_size(bytes[0])) return Verdict::incomplete;
    size = packet_size(bytes);
    const PacketView header{bytes};
    const Message* const row = (header.incompatible_flags() & ~flag_signed) == 0 ? find_message(header.id()) : nullptr;
    if (row == nullptr && transport_ == Transport::lossy) {
        ++counters_.unknown;
        return Verdict::bad;
    }
    if (bytes.size() < size) return Verdict::incomplete;
    if (row == nullptr) {
        ++counters_.unknown;
        return Verdict::bad;
    }
    if (PacketView{bytes.first(size)}.agrees_with(*row)) return Verdict::good;
    ++counters_.bad_crc;
    return Verdict::bad;
}

void PacketParser::skip(std::size_t n) noexcept {
    pos_ += n;
    counters_.skipped_bytes += n;
}

void PacketParser::skip_to_magic() noexcept {
    const auto begin = buffer_.begin() + static_cast<std::ptrdiff_t>(pos_),
               end = buffer_.begin() + static_cast<std::ptrdiff_t>(end_);
    skip(static_cast<std::size_t>(std::find_if(begin, end, is_magic) - begin));
}

}    // namespace anogate::mavlink
