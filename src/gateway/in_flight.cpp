#include <gateway/in_flight.hpp>

#include <algorithm>

namespace anogate {

InFlight::Slot* InFlight::oldest(State state, auto fits) noexcept {
    Slot* found = nullptr;
    for (Slot& slot : slots_)
        if (slot.state == state && fits(slot) && (!found || slot.left_at < found->left_at)) found = &slot;
    return found;
}

void InFlight::expire(ano::TimePoint now) noexcept {
    for (Slot& slot : slots_)
        if (slot.state == State::left && now >= slot.left_at + patience) slot = {};
}

bool InFlight::has_place(ChannelId from) const noexcept {
    return size() < max_questions && (from == ourselves || size() - places(ourselves) < max_of_others);
}

std::size_t InFlight::places(ChannelId from) const noexcept {
    return static_cast<std::size_t>(std::count_if(
        slots_.begin(), slots_.end(), [from](const Slot& slot) { return slot.state != State::free && slot.from == from; }));
}

bool InFlight::expire_one(ano::TimePoint now) noexcept {
    Slot* slot = oldest(State::left, [&](const Slot& s) { return now >= s.left_at + early && places(s.from) > 1; });
    if (slot) *slot = {};
    return slot != nullptr;
}

std::optional<ano::TimePoint> InFlight::next_early() const noexcept {
    std::optional<ano::TimePoint> first;
    for (const Slot& slot : slots_)
        if (slot.state == State::left && places(slot.from) > 1)
            first = std::min(first.value_or(ano::TimePoint::max()), slot.left_at + early);
    return first;
}

std::size_t InFlight::size() const noexcept {
    return max_questions - static_cast<std::size_t>(std::count_if(slots_.begin(), slots_.end(),
                                                                  [](const Slot& slot) { return slot.state == State::free; }));
}

std::optional<ano::TimePoint> InFlight::next_expiry() const noexcept {
    std::optional<ano::TimePoint> first;
    for (const Slot& slot : slots_)
        if (slot.state == State::left) first = std::min(first.value_or(ano::TimePoint::max()), slot.left_at + patience);
    return first;
}

void InFlight::queued(ano::FrameView frame, ChannelId from) noexcept {
    const auto question = question_in(frame);
    if (!question) return;
    if (Slot* slot = oldest(State::free, [](const Slot&) { return true; })) *slot = {*question, State::queued, {}, from};
}

void InFlight::left(ano::FrameView frame, ano::TimePoint now) noexcept {
    const auto question = question_in(frame);
    if (!question) return;
    Slot* slot = oldest(State::queued, [&](const Slot& s) { return s.question == *question; });
    if (!slot) return;
    slot->state = State::left;
    slot->left_at = now;
}

void InFlight::dropped(ano::FrameView frame) noexcept {
    const auto question = question_in(frame);
    if (!question) return;
    Slot* slot = oldest(State::queued, [&](const Slot& s) { return s.question == *question; });
    if (slot) *slot = {};
}

bool InFlight::receive(ano::FrameView frame) noexcept {
    if (!ano::may_answer(frame.id())) return false;
    Slot* slot = oldest(State::left, [&](const Slot& s) { return answers(frame, s.question); });
    if (slot) *slot = {};
    return slot != nullptr;
}

}    // namespace anogate
