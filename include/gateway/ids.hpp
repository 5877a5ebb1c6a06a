// Small numbers for links and channels, and sets of them.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>

namespace anogate {

/// A configured link; 0 to 63. The number of a removed link is used again.
enum class LinkId : std::uint8_t {};
/// A channel of a link, see Channel; 0 to 63. The number of a closed channel is used again.
enum class ChannelId : std::uint8_t {};

inline constexpr std::size_t max_links = 64;
inline constexpr std::size_t max_channels = 64;

/// The channel of frames that the gateway itself sends.
inline constexpr ChannelId ourselves{max_channels};

constexpr std::size_t index(LinkId id) noexcept { return static_cast<std::size_t>(id); }
constexpr std::size_t index(ChannelId id) noexcept { return static_cast<std::size_t>(id); }

/// Up to 64 ids in one word; iterates in ascending order.
template <class Id>
class IdSet {
public:
    class Iterator {
    public:
        constexpr explicit Iterator(std::uint64_t bits) noexcept : bits_{bits} {}
        constexpr Id operator*() const noexcept { return static_cast<Id>(std::countr_zero(bits_)); }
        constexpr Iterator& operator++() noexcept {
            bits_ &= bits_ - 1;
            return *this;
        }
        friend constexpr bool operator==(Iterator, Iterator) noexcept = default;

    private:
        std::uint64_t bits_;
    };

    constexpr IdSet() noexcept = default;
    constexpr IdSet(Id id) noexcept : bits_{std::uint64_t{1} << index(id)} {}

    constexpr bool empty() const noexcept { return bits_ == 0; }
    constexpr std::size_t size() const noexcept { return static_cast<std::size_t>(std::popcount(bits_)); }
    constexpr bool has_several() const noexcept { return (bits_ & (bits_ - 1)) != 0; }
    constexpr bool contains(Id id) const noexcept { return (bits_ >> index(id) & 1) != 0; }
    constexpr void insert(Id id) noexcept { bits_ |= IdSet{id}.bits_; }
    constexpr void erase(Id id) noexcept { bits_ &= ~IdSet{id}.bits_; }
    constexpr void clear() noexcept { bits_ = 0; }
    constexpr Iterator begin() const noexcept { return Iterator{bits_}; }
    constexpr Iterator end() const noexcept { return Iterator{0}; }

    friend constexpr IdSet operator|(IdSet a, IdSet b) noexcept { return IdSet{a.bits_ | b.bits_, 0}; }
    friend constexpr IdSet operator&(IdSet a, IdSet b) noexcept { return IdSet{a.bits_ & b.bits_, 0}; }
    friend constexpr IdSet operator~(IdSet a) noexcept { return IdSet{~a.bits_, 0}; }
    friend constexpr IdSet operator-(IdSet a, IdSet b) noexcept { return IdSet{a.bits_ & ~b.bits_, 0}; }
    constexpr IdSet& operator|=(IdSet other) noexcept { return *this = *this | other; }
    constexpr IdSet& operator-=(IdSet other) noexcept { return *this = *this - other; }
    friend constexpr bool operator==(IdSet, IdSet) noexcept = default;

private:
    constexpr IdSet(std::uint64_t bits, int) noexcept : bits_{bits} {}
    std::uint64_t bits_ = 0;
};

using LinkSet = IdSet<LinkId>;
using ChannelSet = IdSet<ChannelId>;

}    // namespace anogate
