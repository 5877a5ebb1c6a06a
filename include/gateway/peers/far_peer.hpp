// Limits what is sent to a peer outside of our networks before it has shown that it receives. Otherwise a datagram of 8 bytes
// with a forged source could start a stream of data to the owner of that address.
#pragma once
#include <ano/conversation.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

namespace anogate {

using ano::Duration;
using ano::TimePoint;

/// A peer shows it by acknowledging (0x00) a frame that was sent to it, or by two answers (0xE3) to our questions. Each question
/// is sent from another randomly chosen address, to which the answer must go. An attacker with a forged source does not know that
/// address.
class FarPeer {
public:
    static constexpr Duration window = std::chrono::seconds{10};
    static constexpr std::size_t times_its_own = 3;    // bytes to it for each byte from it, in each window
    static constexpr Duration answer_within = std::chrono::seconds{3};
    static constexpr Duration acknowledged_within = std::chrono::seconds{10};
    static constexpr int answers_needed = 2;
    static constexpr int max_wrong_acknowledgements = 4;    // per window; later ones are ignored

    using Question = std::array<std::uint8_t, ano::overhead + 3>;

    explicit FarPeer(TimePoint now) : window_began_{now} {}

    /// A datagram of the peer was received.
    void came(std::size_t bytes, TimePoint now) noexcept;
    /// How many bytes may be sent to it now.
    std::size_t allowance(TimePoint now) noexcept;
    void left(std::size_t bytes) noexcept { out_ += bytes; }

    /// 0xE0 0, if a question is due and within the allowance: once per window, and again immediately after a correct answer.
    std::optional<Question> question(const std::function<std::uint64_t()>& random, TimePoint now);
    /// A frame is being sent to it.
    void sent(ano::FrameView frame, TimePoint now) noexcept;
    /// A frame of the peer was received. True: it answers one of our questions and is not forwarded.
    bool heard(ano::FrameView frame, TimePoint now) noexcept;
    /// Whether it has shown that it receives our frames.
    bool is_there() const noexcept { return is_there_; }

private:
    struct Sent {
        std::optional<ano::Answer> answer{};    // an acknowledgement
        TimePoint at{};
    };

    void roll(TimePoint now) noexcept;
    void acknowledges(ano::FrameView frame, TimePoint now) noexcept;

    TimePoint window_began_;
    std::size_t in_ = 0, out_ = 0;    // bytes in this window
    bool may_ask_ = true;
    std::uint8_t asked_as_ = 0;    // our address in the open question; 0: none
    TimePoint asked_at_{};
    int answers_ = 0;
    int wrong_ = 0;
    std::array<Sent, 8> sent_{};
    std::size_t next_ = 0;
    bool is_there_ = false;
};

}    // namespace anogate
