// Lets a device behind a link appear under another address: two sensors with one default id (protocol text, section 2).
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/expiring_cache.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace anogate {

struct AliasRule {
    std::uint8_t device = 0;    // the id it has; 0x00 and 0xFF are no ids, but some devices send from there
    std::uint8_t as = 0;        // the id it appears under; no other device may have it
    bool operator==(const AliasRule&) const = default;
};

/// The aliases of one link. Both directions rewrite the address and the checks. An acknowledgement (0x00) repeats the check bytes
/// of the frame it acknowledges. The checks of each rewritten frame that may be acknowledged are therefore stored for `memory`,
/// at most 1024 of them; the oldest are replaced. No allocation after construction.
class Aliases {
public:
    static constexpr ano::Duration memory = std::chrono::seconds{5};

    /// `max_data` of the link: larger frames pass unchanged, and the outbox refuses them.
    Aliases(const std::vector<AliasRule>& rules, std::size_t max_data);

    /// Returns a frame from the link as other links see it. The source, the device id of a device info (0xE3) and the checks in
    /// an acknowledgement are rewritten. Valid until the next call.
    ano::FrameView inbound(ano::FrameView frame, ano::TimePoint now) noexcept;
    /// The id under which a device of the link appears.
    std::uint8_t appears_as(std::uint8_t device) const noexcept { return as_[device] != 0 ? as_[device] : device; }
    /// Returns a frame to the link as its devices see it. std::nullopt for a frame to the real id of an aliased device: it is
    /// meant for another device with this id and must not reach this one. Valid until the next call.
    std::optional<ano::FrameView> outbound(ano::FrameView frame, ano::TimePoint now) noexcept;

private:
    void restore_checks(std::span<std::uint8_t> acknowledgement, std::uint8_t requester, std::uint8_t alias,
                        ano::TimePoint now) noexcept;
    ano::FrameView finish(std::span<std::uint8_t> bytes, ano::FrameView original, std::uint8_t requester, std::uint8_t alias,
                          ano::TimePoint now) noexcept;

    std::array<std::uint8_t, 256> as_{};                       // by device; 0: none
    std::array<std::optional<std::uint8_t>, 256> device_{};    // by alias
    std::size_t max_size_;
    std::unique_ptr<std::uint8_t[]> in_, out_;            // two buffers: a frame may go from one device of the link to another
    ExpiringCache<ano::Checks> sent_as_{memory, 1024};    // the original checks of a frame, by its rewritten checks
};

}    // namespace anogate
