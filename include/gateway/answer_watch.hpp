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
#include <optional>

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
        if (answer && answer->id() != ano::id_of<"firmware">) sent_[next_++ % memory] = {frame.destination(), *answer, now, {}};
    }
    /// The same answer again within this time is a duplicate made by the line.
    static constexpr ano::Duration doubled_within = std::chrono::milliseconds{100};
    /// `frame` was received on the channel. True: it answers or acknowledges a sent frame whose destination is not the source of
    /// `frame`, and no sent frame whose destination is: each of those has one answer.
    bool is_for_another(ano::FrameView frame, ano::TimePoint now) noexcept {
        if (next_ == 0 || !ano::may_answer(frame.id()) || ano::address::is_host(frame.source())) return false;
        const auto answer = ano::answer_in(frame);
        bool is_asked_of_another = false, is_doubled = false;
        Sent* open = nullptr;
        for (Sent& sent : sent_) {
            if (sent.to == ano::address::unassigned || now - sent.at >= window || sent.answer != answer) continue;
            if (!ano::may_answer_for(frame.source(), sent.to)) is_asked_of_another = true;
            else if (sent.answered_at) is_doubled = is_doubled || now - *sent.answered_at < doubled_within;
            else if (open == nullptr || sent.at < open->at) open = &sent;
        }
        if (open != nullptr) open->answered_at = now;
        return open == nullptr && is_asked_of_another && !is_doubled;
    }

private:
    struct Sent {
        std::uint8_t to = ano::address::unassigned;
        ano::Answer answer{};
        ano::TimePoint at{};
        std::optional<ano::TimePoint> answered_at{};
    };

    std::array<Sent, memory> sent_{};
    std::size_t next_ = 0;
};

}    // namespace anogate
