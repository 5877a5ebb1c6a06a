// The unanswered questions to a device. Small devices lose questions when too many arrive at a time.
#pragma once
#include <ano/conversation.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/ids.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace anogate {

using ano::answers;
using ano::Question;
using ano::question_in;

/// The questions to one channel: those that wait in its outbox, and those sent at most `patience` ago and not answered. At most
/// `max_questions`, of which one is reserved for the gateway itself; no allocation.
class InFlight {
public:
    static constexpr std::size_t max_questions = 8;
    static constexpr std::size_t max_of_others = max_questions - 1;
    static constexpr ano::Duration patience = std::chrono::milliseconds{500};
    /// A question not answered within this time loses its place to a sender that has none, if its own sender has several.
    static constexpr ano::Duration early = std::chrono::milliseconds{100};

    /// Removes questions that were not answered in time.
    void expire(ano::TimePoint now) noexcept;
    /// Whether the sender may add one more.
    bool has_place(ChannelId from) const noexcept;
    /// The number of questions of the sender.
    std::size_t places(ChannelId from) const noexcept;
    /// Removes the oldest question, sent by `now` - `early`, of a sender that has several. False: there is none.
    bool expire_one(ano::TimePoint now) noexcept;
    /// When expire_one() can remove one; std::nullopt: no sender has several.
    std::optional<ano::TimePoint> next_early() const noexcept;
    std::size_t size() const noexcept;
    /// When the oldest sent question is removed as unanswered; std::nullopt: none was sent.
    std::optional<ano::TimePoint> next_expiry() const noexcept;

    /// Called by the outbox for each frame: it waits there, was sent, or was dropped. Frames that are not questions are ignored.
    void queued(ano::FrameView frame, ChannelId from) noexcept;
    void left(ano::FrameView frame, ano::TimePoint now) noexcept;
    void dropped(ano::FrameView frame) noexcept;
    /// A frame was received on the channel. True: it answers a question; the oldest one that it answers is removed.
    bool receive(ano::FrameView frame) noexcept;
    /// Call when the channel is closed: no question will be answered.
    void clear() noexcept { slots_ = {}; }

private:
    enum class State : std::uint8_t { free, queued, left };
    struct Slot {
        Question question;
        State state = State::free;
        ano::TimePoint left_at{};
        ChannelId from{};
    };
    Slot* oldest(State state, auto fits) noexcept;

    std::array<Slot, max_questions> slots_{};
};

}    // namespace anogate
