#include <ano/frame.hpp>

namespace ano {

// Both checks of 16 interleaved strands at once, all mod 256. Each step of a strand is 16 bytes of the frame, so its sum is
// counted 16 times. A byte of strand j does not count for the j bytes before it in its step.
Checks checks_of_many(std::span<const std::uint8_t> bytes) noexcept {
    using Strands [[gnu::vector_size(16)]] = std::uint8_t;
    Strands sums{};
    Strands adds{};
    std::size_t i = 0;
    for (; i + sizeof(Strands) <= bytes.size(); i += sizeof(Strands)) {
        Strands block;
        std::memcpy(&block, bytes.data() + i, sizeof block);
        sums += block;
        adds += sums;
    }
    unsigned sum = 0;
    unsigned add = 0;
    for (unsigned j = 0; j < sizeof(Strands); ++j) {
        sum += sums[j];
        add += 16u * adds[j] - j * sums[j];
    }
    for (; i < bytes.size(); ++i) {
        sum += bytes[i];
        add += sum;
    }
    return {static_cast<std::uint8_t>(sum), static_cast<std::uint8_t>(add)};
}

}    // namespace ano
