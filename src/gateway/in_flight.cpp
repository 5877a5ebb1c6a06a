#include <ano/address.hpp>
#include <gateway/in_flight.hpp>
#include <gateway/question_ids.hpp>

#include <algorithm>

namespace anogate {
namespace {

using namespace questions;

constexpr std::uint8_t how_many = 0xFF;    // in place of the number of a waypoint

// The number that begins at `at` of DATA, which is long enough.
std::uint16_t number_at(std::span<const std::uint8_t> data, std::size_t at) noexcept {
    return static_cast<std::uint16_t>(data[at] | data[at + 1] << 8);
}

// Whether the source of an answer fits the address that was asked.
bool may_be_of(std::uint8_t source, std::uint8_t asked) noexcept {
    return source == asked || asked == ano::address::broadcast || ano::address::is_port_id(asked);
}

}    // namespace

std::optional<Question> question_in(ano::FrameView frame) noexcept {
    const std::uint8_t to = frame.destination();
    const auto data = frame.data();
    if (ano::address::is_host(to)) return std::nullopt;
    if (frame.id() == waypoint_read && !data.empty())
        return data[0] == how_many ? Question{to, waypoint_read, 0} : Question{to, waypoint, data[0]};
    if (frame.id() != command_query && frame.id() != parameter_command) return std::nullopt;
    if (data.size() < 3) return std::nullopt;
    const std::uint16_t value = number_at(data, 1);
    if (frame.id() == command_query) {
        if (data[0] == 0) return Question{to, command_query, 0};
        if (data[0] == 1) return Question{to, command_info, value};
        return std::nullopt;
    }
    switch (data[0]) {
    case 0: return Question{to, device_info, 0};
    case 1: return Question{to, parameter_command, 0};
    case 2: return Question{to, parameter_value, value};
    case 3: return Question{to, parameter_info, value};
    default: return std::nullopt;    // an action
    }
}

bool answers(ano::FrameView frame, Question question) noexcept {
    const auto data = frame.data();
    if (frame.id() != question.answer_id || !may_be_of(frame.source(), question.asked)) return false;
    switch (frame.id()) {
    case device_info:
    case waypoint_read: return true;
    case waypoint: return !data.empty() && data[0] == question.about;
    case command_query: return !data.empty() && data[0] == 0;
    case parameter_command: return !data.empty() && data[0] == 1;
    default: return data.size() >= 2 && number_at(data, 0) == question.about;
    }
}

InFlight::Slot* InFlight::oldest(State state, auto fits) noexcept {
    Slot* found = nullptr;
    for (Slot& slot : slots_)
        if (slot.state == state && fits(slot) && (!found || slot.left_at < found->left_at)) found = &slot;
    return found;
}

bool InFlight::has_room(ano::TimePoint now) noexcept {
    bool room = false;
    for (Slot& slot : slots_) {
        if (slot.state == State::left && now >= slot.left_at + patience) slot = {};
        room |= slot.state == State::free;
    }
    return room;
}

std::size_t InFlight::size() const noexcept {
    return max_questions - static_cast<std::size_t>(std::count_if(slots_.begin(), slots_.end(),
                                                                  [](const Slot& slot) { return slot.state == State::free; }));
}

std::optional<ano::TimePoint> InFlight::next_given_up() const noexcept {
    std::optional<ano::TimePoint> first;
    for (const Slot& slot : slots_)
        if (slot.state == State::left) first = std::min(first.value_or(ano::TimePoint::max()), slot.left_at + patience);
    return first;
}

void InFlight::queued(ano::FrameView frame) noexcept {
    const auto question = question_in(frame);
    if (!question) return;
    if (Slot* slot = oldest(State::free, [](const Slot&) { return true; })) *slot = {*question, State::queued, {}};
}

void InFlight::left(ano::FrameView frame, ano::TimePoint now) noexcept {
    const auto question = question_in(frame);
    if (!question) return;
    Slot* slot = oldest(State::queued, [&](const Slot& s) { return s.question == *question; });
    if (slot) *slot = {*question, State::left, now};
}

void InFlight::dropped(ano::FrameView frame) noexcept {
    const auto question = question_in(frame);
    if (!question) return;
    Slot* slot = oldest(State::queued, [&](const Slot& s) { return s.question == *question; });
    if (slot) *slot = {};
}

bool InFlight::hear(ano::FrameView frame) noexcept {
    Slot* slot = oldest(State::left, [&](const Slot& s) { return answers(frame, s.question); });
    if (slot) *slot = {};
    return slot != nullptr;
}

}    // namespace anogate
