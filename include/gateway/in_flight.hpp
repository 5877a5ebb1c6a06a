// What a device was asked and has not answered yet. Small devices lose questions that come many at a time.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

/// What a device answers with data (protocol text, section 3): who is asked, and by what the answer is known.
struct Question {
    std::uint8_t asked = 0;    // 0xFF, and a port id: whoever is there
    std::uint8_t answer_id = 0;
    std::uint16_t about = 0;    // the number of a parameter, command or waypoint; 0 where there is but one answer
    friend constexpr bool operator==(Question, Question) noexcept = default;
};

/// The question that `frame` asks: 0x60, 0xC1, and 0xE0 with the commands 0 to 3. Nothing for any other frame: what
/// writes or commands is no question, and what goes to a host is not one either but its answer, which in 0x60, 0xC1
/// and 0xE0 1 looks the same.
std::optional<Question> question_in(ano::FrameView frame) noexcept;
/// Whether `frame` is what `question` asked for.
bool answers(ano::FrameView frame, Question question) noexcept;

/// The questions on their way to one channel: those that wait in its outbox, and those that have left and were neither
/// answered nor left more than `patience` ago. Room for `most`; no allocation.
class InFlight {
public:
    static constexpr std::size_t most = 8;
    static constexpr ano::Duration patience = std::chrono::milliseconds{500};

    /// Whether one more may go at `now`. Forgets those that nobody has answered in time.
    bool has_room(ano::TimePoint now) noexcept;
    std::size_t size() const noexcept;
    /// When the first that has left is given up; nothing when none has left.
    std::optional<ano::TimePoint> next_given_up() const noexcept;

    /// What the outbox tells, of every frame: that it waits there, has left, or was dropped. Other frames than questions
    /// are passed over.
    void queued(ano::FrameView frame) noexcept;
    void left(ano::FrameView frame, ano::TimePoint now) noexcept;
    void dropped(ano::FrameView frame) noexcept;
    /// A frame came in by the channel. True: it answers a question, the oldest it fits, which is done.
    bool hear(ano::FrameView frame) noexcept;
    /// The channel is closed, nothing will be answered.
    void clear() noexcept { slots_ = {}; }

private:
    enum class State : std::uint8_t { free, queued, left };
    struct Slot {
        Question question;
        State state = State::free;
        ano::TimePoint left_at{};
    };
    Slot* oldest(State state, auto fits) noexcept;

    std::array<Slot, most> slots_{};
};

}    // namespace anogate
