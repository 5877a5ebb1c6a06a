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
#include <optional>

namespace anogate {

/// For one channel: the last frames that ask or act and were sent by it. No allocation.
class AnswerWatch {
public:
    static constexpr std::size_t memory = 8;    // frames
    static constexpr ano::Duration window = std::chrono::seconds{2};

    void sent(ano::FrameView frame, ano::TimePoint now) noexcept {
        if (ano::intent_of(frame) == ano::Intent::informs) return;
        sent_[next_++ % memory] = {frame.destination(), frame.id(), frame.checks(), ano::question_in(frame), now};
    }
    /// `frame` came by the channel. True: it answers or acknowledges a frame to another address than its source, and none to its
    /// source.
    bool is_for_another(ano::FrameView frame, ano::TimePoint now) const noexcept {
        if (next_ == 0 || ano::address::is_host(frame.source())) return false;
        bool found = false;
        for (const Sent& sent : sent_) {
            if (sent.to == ano::address::unassigned || now - sent.at >= window || !ends(sent, frame)) continue;
            if (ano::may_answer_for(frame.source(), sent.to)) return false;
            found = true;
        }
        return found;
    }

private:
    struct Sent {
        std::uint8_t to = ano::address::unassigned, id = 0;
        ano::Checks checks{};
        std::optional<ano::Question> question{};
        ano::TimePoint at{};
    };
    static bool ends(const Sent& sent, ano::FrameView frame) noexcept {
        if (frame.id() != ano::id_of<"check">) return sent.question && ano::answers_data_of(frame, *sent.question);
        const auto data = frame.data();
        return data.size() >= 3 && data[0] == sent.id && data[1] == sent.checks.sum && data[2] == sent.checks.add;
    }

    std::array<Sent, memory> sent_{};
    std::size_t next_ = 0;
};

}    // namespace anogate
