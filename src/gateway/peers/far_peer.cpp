#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <gateway/peers/far_peer.hpp>

namespace anogate {
namespace {

// Addresses of user devices. A port id would be ambiguous.
constexpr std::uint8_t first_address = ano::address::last_port_id + 1, last_address = 199;

bool is_user_address(std::uint8_t a) noexcept { return a >= first_address && a <= last_address; }

}    // namespace

void FarPeer::roll(TimePoint now) noexcept {
    if (now - window_began_ < window) return;
    window_began_ = now;
    in_ = out_ = 0;
    wrong_ = 0;
    may_ask_ = true;
}

void FarPeer::came(std::size_t bytes, TimePoint now) noexcept {
    roll(now);
    in_ += bytes;
}

std::size_t FarPeer::allowance(TimePoint now) noexcept {
    roll(now);
    return times_its_own * in_ > out_ ? times_its_own * in_ - out_ : 0;
}

std::optional<FarPeer::Question> FarPeer::question(const std::function<std::uint64_t()>& random, TimePoint now) {
    if (is_there_ || allowance(now) < Question{}.size() || !may_ask_) return std::nullopt;
    may_ask_ = false;
    asked_as_ = static_cast<std::uint8_t>(first_address + random() % (last_address - first_address + 1));
    asked_at_ = now;
    Question question;
    const std::uint8_t who_are_you[] = {0, 0, 0};
    ano::encode(question, asked_as_, ano::address::broadcast, ano::id_of<"parameter_command">, who_are_you);
    return question;
}

void FarPeer::sent(ano::FrameView frame, TimePoint now) noexcept {
    const auto answer = ano::answer_to(frame);
    if (!answer || !answer->is_acknowledgement()) return;
    sent_[next_] = {*answer, now};
    next_ = (next_ + 1) % sent_.size();
}

bool FarPeer::heard(ano::FrameView frame, TimePoint now) noexcept {
    roll(now);
    if (frame.id() == ano::id_of<"check">) acknowledges(frame, now);
    if (frame.id() != ano::id_of<"device_info"> || asked_as_ == 0 || now - asked_at_ > answer_within ||
        !is_user_address(frame.destination()))
        return false;
    const bool right = frame.destination() == asked_as_;
    answers_ = right ? answers_ + 1 : 0;
    may_ask_ = may_ask_ || right;
    asked_as_ = 0;
    is_there_ = is_there_ || answers_ >= answers_needed;
    return right;
}

void FarPeer::acknowledges(ano::FrameView frame, TimePoint now) noexcept {
    const auto answer = ano::answer_in(frame);
    if (!answer || wrong_ >= max_wrong_acknowledgements) return;
    for (const Sent& s : sent_)
        if (s.answer == answer && now - s.at <= acknowledged_within) {
            is_there_ = true;
            return;
        }
    ++wrong_;
}

}    // namespace anogate
