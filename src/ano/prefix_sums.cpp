#include <ano/prefix_sums.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

namespace ano {
namespace {

constexpr std::size_t stride = 256;    // extending them one byte at a time would cost more than the sums themselves
constexpr std::size_t width = 16;

// Two lanes of eight bytes. A sum within a lane takes three shifts. The carry from lane to lane is a separate number, so that no
// lane waits for the one before. Measured: 3 times as fast as a loop over bytes.
using Bytes [[gnu::vector_size(width)]] = std::uint8_t;
using Lanes [[gnu::vector_size(width)]] = std::uint64_t;
constexpr std::uint64_t ones = 0x0101010101010101;

Bytes sums_within_lanes(Bytes x) noexcept {
    x += reinterpret_cast<Bytes>(reinterpret_cast<Lanes>(x) << 8);
    x += reinterpret_cast<Bytes>(reinterpret_cast<Lanes>(x) << 16);
    x += reinterpret_cast<Bytes>(reinterpret_cast<Lanes>(x) << 32);
    return x;
}

// Sums over both lanes that continue from `carry`, which becomes the last of them.
Bytes sums_from(std::uint64_t& carry, Bytes x) noexcept {
    const Bytes within = sums_within_lanes(x);
    const Lanes totals = reinterpret_cast<Lanes>(within) >> 56;
    const std::uint64_t middle = carry + totals[0];
    const Lanes carries{(carry & 0xFF) * ones, (middle & 0xFF) * ones};
    carry = middle + totals[1];
    return within + reinterpret_cast<Bytes>(carries);
}

}    // namespace

PrefixSums::PrefixSums(std::size_t capacity) : sum_{capacity + 1}, add_{capacity + 1}, gap_{capacity + 1} {}

void PrefixSums::extend(std::span<const std::uint8_t> bytes, std::size_t to) noexcept {
    extend_to(bytes.data(), std::min(std::max(to, end_ + stride), bytes.size()));
}

void PrefixSums::move_front(std::size_t distance) noexcept {
    if (end_ < distance) {
        begin(0);
        return;
    }
    end_ -= distance;
    for (const auto* sums : {&sum_, &add_, &gap_}) std::memmove(sums->get(), sums->get() + distance, end_ + 1);
}

void PrefixSums::extend_to(const std::uint8_t* bytes, std::size_t to) noexcept {
    std::size_t i = end_;
    std::uint64_t sum = sum_[i];
    std::uint64_t add = add_[i];
    if constexpr (std::endian::native == std::endian::little) {
        for (; i + width <= to; i += width) {
            Bytes x;
            std::memcpy(&x, bytes + i, width);
            const Bytes s = sums_from(sum, x);
            const Bytes a = sums_from(add, s);
            const Bytes gap = s - x - x;
            std::memcpy(&sum_[i + 1], &s, width);
            std::memcpy(&add_[i + 1], &a, width);
            std::memcpy(&gap_[i], &gap, width);
        }
    }
    for (; i < to; ++i) {
        gap_[i] = static_cast<std::uint8_t>(sum - bytes[i]);
        sum_[i + 1] = static_cast<std::uint8_t>(sum += bytes[i]);
        add_[i + 1] = static_cast<std::uint8_t>(add += sum);
    }
    end_ = to;
}

}    // namespace ano
