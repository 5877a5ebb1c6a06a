// The questions that a device has not answered yet. Small devices lose questions when many come at a time.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

/// A question that a device answers with data (protocol text, section 3): who is asked, and how the answer is recognised.
struct Question {
    std::uint8_t asked = 0;    // 0xFF and port ids stand for any device
    std::uint8_t answer_id = 0;
    std::uint16_t about = 0;    // the number of a parameter, command or waypoint; 0 where only one answer is possible
    friend constexpr bool operator==(Question, Question) noexcept = default;
};

/// The question that `frame` asks: 0x60, 0xC1, and 0xE0 with the commands 0 to 3. std::nullopt for any other frame: a write
/// or a command is not a question, and a frame to a host is an answer, which in 0x60, 0xC1 and 0xE0 1 looks the same.
std::optional<Question> question_in(ano::FrameView frame) noexcept;
/// Whether `frame` answers `question`.
bool answers(ano::FrameView frame, Question question) noexcept;

/// The questions on their way to one channel: those that wait in its outbox, and those that have left and were neither
/// answered nor left more than `patience` ago. Room for `max_questions`; no allocation.
class InFlight {
public:
    static constexpr std::size_t max_questions = 8;
    static constexpr ano::Duration patience = std::chrono::milliseconds{500};

    /// Whether one more may be sent at `now`. Forgets questions that were not answered in time.
    bool has_room(ano::TimePoint now) noexcept;
    std::size_t size() const noexcept;
    /// When the oldest question that has left is given up; std::nullopt when none has left.
    std::optional<ano::TimePoint> next_given_up() const noexcept;

    /// Called by the outbox for every frame: it waits there, has left, or was dropped. Frames that are not questions
    /// are ignored.
    void queued(ano::FrameView frame) noexcept;
    void left(ano::FrameView frame, ano::TimePoint now) noexcept;
    void dropped(ano::FrameView frame) noexcept;
    /// A frame came in by the channel. True: it answers a question; the oldest one that it answers is removed.
    bool hear(ano::FrameView frame) noexcept;
    /// To be called when the channel is closed: no question will be answered.
    void clear() noexcept { slots_ = {}; }

private:
    enum class State : std::uint8_t { free, queued, left };
    struct Slot {
        Question question;
        State state = State::free;
        ano::TimePoint left_at{};
    };
    Slot* oldest(State state, auto fits) noexcept;

    std::array<Slot, max_questions> slots_{};
};

}    // namespace anogate
