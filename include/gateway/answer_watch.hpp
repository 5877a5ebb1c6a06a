// Finds devices that answer frames for other addresses: some of the oldest do not look at D_ADDR.
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

/// For one channel: the last frames that were sent by it and are answered with data or acknowledged. Steps of an upgrade are not among them:
/// of two upgrades at a time, the answers can't be told apart. No allocation.
class AnswerWatch {
public:
    static constexpr std::size_t memory = 8;    // frames
    static constexpr ano::Duration window = std::chrono::seconds{2};

    void sent(ano::FrameView frame, ano::TimePoint now) noexcept {
        if (ano::intent_of(frame) == ano::Intent::informs) return;
        const auto answer = ano::answer_to(frame);
        if (answer && answer->id() != ano::id_of<"firmware">) sent_[next_++ % memory] = {frame.destination(), *answer, now};
    }
    /// `frame` came by the channel. True: it answers or acknowledges a frame to another address than its source, and none to its
    /// source.
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
