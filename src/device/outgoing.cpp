#include <device/outgoing.hpp>

namespace ano::device {

void Outgoing::commit(std::size_t size, Link link) noexcept {
    if (size == 0 || waiting_ == max_frames) return;
    Slot& slot = slots_[(first_ + waiting_) % max_frames];
    slot.size = size;
    slot.link = link;
    ++waiting_;
}

std::optional<Outgoing::Departure> Outgoing::next() noexcept {
    if (waiting_ == 0) return std::nullopt;
    const Slot& slot = slots_[first_];
    first_ = (first_ + 1) % max_frames;
    --waiting_;
    return Departure{FrameView{std::span{slot.bytes}.first(slot.size)}, slot.link};
}

}    // namespace ano::device
