#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <gateway/alias.hpp>

#include <algorithm>
#include <cassert>

namespace anogate {
namespace {

constexpr std::uint8_t check_id = ano::id_of<"check">;    // DATA: the id and both checks of the frame that is acknowledged
constexpr std::uint8_t device_info_id = ano::id_of<"device_info">;    // DATA: the device's id first

// Identifies a rewritten frame: requester, alias, and the id and checks of the frame.
std::uint64_t memory_key(std::uint8_t requester, std::uint8_t alias, std::uint8_t id, ano::Checks checks) noexcept {
    return std::uint64_t{requester} | std::uint64_t{alias} << 8 | std::uint64_t{id} << 16 | std::uint64_t{checks.sum} << 24 |
           std::uint64_t{checks.add} << 32;
}

std::span<std::uint8_t> copy(ano::FrameView frame, std::uint8_t* to) noexcept {
    std::copy(frame.bytes().begin(), frame.bytes().end(), to);
    return {to, frame.bytes().size()};
}

}    // namespace

Aliases::Aliases(const std::vector<AliasRule>& rules, std::size_t max_data)
    : max_size_{ano::overhead + max_data}, in_{new std::uint8_t[max_size_]}, out_{new std::uint8_t[max_size_]} {
    for (const AliasRule& rule : rules) {
        assert(!ano::address::is_nobody(rule.as));
        as_[rule.device] = rule.as;
        device_[rule.as] = rule.device;
    }
}

ano::FrameView Aliases::inbound(ano::FrameView frame, ano::TimePoint now) noexcept {
    const std::uint8_t alias = as_[frame.source()];
    if (alias == 0 || frame.bytes().size() > max_size_) return frame;
    const auto bytes = copy(frame, in_.get());
    bytes[1] = alias;
    if (frame.id() == check_id) restore_checks(bytes, frame.destination(), alias, now);
    if (frame.id() == device_info_id && !frame.data().empty() && frame.data()[0] == frame.source())
        bytes[ano::header_size] = alias;
    return finish(bytes, frame, alias, alias, now);
}

std::optional<ano::FrameView> Aliases::outbound(ano::FrameView frame, ano::TimePoint now) noexcept {
    const std::uint8_t alias = frame.destination();
    const bool is_for_all = alias == ano::address::broadcast;    // even if a device has this id
    if (!device_[alias]) return as_[alias] == 0 || is_for_all ? std::optional{frame} : std::nullopt;
    if (frame.bytes().size() > max_size_) return frame;
    const auto bytes = copy(frame, out_.get());
    bytes[2] = *device_[alias];
    if (frame.id() == check_id) restore_checks(bytes, alias, alias, now);
    return finish(bytes, frame, frame.source(), alias, now);
}

void Aliases::restore_checks(std::span<std::uint8_t> acknowledgement, std::uint8_t requester, std::uint8_t alias,
                             ano::TimePoint now) noexcept {
    if (acknowledgement.size() < ano::overhead + 3) return;
    const auto data = acknowledgement.subspan(ano::header_size, 3);
    const ano::Checks* original = sent_as_.find(memory_key(requester, alias, data[0], {data[1], data[2]}), now);
    if (!original) return;    // it acknowledges a broadcast, which is not rewritten, or is too late
    data[1] = original->sum;
    data[2] = original->add;
}

ano::FrameView Aliases::finish(std::span<std::uint8_t> bytes, ano::FrameView original, std::uint8_t requester, std::uint8_t alias,
                               ano::TimePoint now) noexcept {
    ano::seal(bytes);
    const ano::FrameView frame{bytes};
    if (ano::may_be_acknowledged(frame.id()))
        sent_as_.put(memory_key(requester, alias, frame.id(), frame.checks()), original.checks(), now);
    return frame;
}

}    // namespace anogate
