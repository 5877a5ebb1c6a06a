// Finds devices that answer frames for other addresses. Some of the oldest devices ignore D_ADDR.
#pragma once
#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace anogate {

/// For one channel. Stores the last frames sent by it that are answered with data or acknowledged, except the steps of an
/// upgrade: the answers of two simultaneous upgrades can't be distinguished. No allocation.
class AnswerWatch {
public:
    static constexpr std::size_t memory = 8;    // frames
    static constexpr ano::Duration window = std::chrono::seconds{2};

    void sent(ano::FrameView frame, ano::TimePoint now) noexcept {
        if (ano::intent_of(frame) == ano::Intent::informs) return;
        const auto answer = ano::answer_to(frame);
        if (answer && answer->id() != ano::id_of<"firmware">) sent_[next_++ % memory] = {frame.destination(), *answer, now};
    }
    /// `frame` was received on the channel. True: it answers or acknowledges a sent frame whose destination is not the source of
    /// `frame`, and no sent frame whose destination is.
    bool is_for_another(ano::FrameView frame, ano::TimePoint now) const noexcept {
        if (next_ == 0 || !ano::may_answer(frame.id()) || ano::address::is_host(frame.source())) return false;
        const auto answer = ano::answer_in(frame);
        bool found = false;
        for (const Sent& sent : sent_) {
            if (sent.to == ano::address::unassigned || now - sent.at >= window || sent.answer != answer) continue;
            if (ano::may_answer_for(frame.source(), sent.to)) return false;
            found = true;
        }
        return found;
    }

private:
    struct Sent {
        std::uint8_t to = ano::address::unassigned;
        ano::Answer answer{};
        ano::TimePoint at{};
    };

    std::array<Sent, memory> sent_{};
    std::size_t next_ = 0;
};

}    // namespace anogate
