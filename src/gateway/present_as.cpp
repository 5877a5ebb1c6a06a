#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <gateway/present_as.hpp>
#include <gateway/queue_policy.hpp>

#include <algorithm>
#include <cassert>

namespace anogate {
namespace {

namespace address = ano::address;

constexpr std::uint8_t check = ano::id_of<"check">, firmware = ano::id_of<"firmware">;

}    // namespace

PresentAs::PresentAs(std::uint8_t address, std::size_t max_data)
    : address_{address},
      max_size_{ano::overhead + max_data},
      in_{new std::uint8_t[max_size_]},
      out_{new std::uint8_t[max_size_]},
      answers_{new ano::Answer[capacity]},
      questions_{new Question[capacity]},
      sessions_{new Session[256]} {
    assert(address != address::unassigned && address != address::broadcast);
    everybody_.set(address::broadcast);
}

void PresentAs::make_room(std::size_t max_data) {
    if (ano::overhead + max_data <= max_size_) return;
    max_size_ = ano::overhead + max_data;
    in_.reset(new std::uint8_t[max_size_]);
    out_.reset(new std::uint8_t[max_size_]);
    last_number_ = 0;
}

ano::FrameView PresentAs::outbound(ano::FrameView frame, std::uint64_t number, ano::TimePoint now) noexcept {
    const std::uint8_t from = frame.source(), to = frame.destination();
    if (to == address_ || address::is_host(to) || frame.bytes().size() > max_size_) return frame;
    if (from != address_ && !address::is_host(from) && (devices_[from] || !ano::is_for_devices(frame.id()))) return frame;
    if (number != last_number_) {
        last_number_ = number;
        last_size_ = frame.bytes().size();
        const std::span<std::uint8_t> bytes{out_.get(), last_size_};
        std::copy(frame.bytes().begin(), frame.bytes().end(), bytes.begin());
        bytes[1] = address_;
        ano::seal(bytes);
        remember(ano::FrameView{bytes}, frame, now);
    }
    return ano::FrameView{{out_.get(), last_size_}};
}

ano::FrameView PresentAs::inbound(ano::FrameView frame, ano::TimePoint now) noexcept {
    const bool to_everybody = frame.destination() == address::broadcast;
    if (frame.destination() == address_) devices_.set(frame.source());
    if ((frame.destination() != address_ && !to_everybody) || frame.bytes().size() > max_size_) return frame;
    const auto answered = ano::answer_in(frame);
    if (!answered) return frame;
    const Question* question = asked(*answered, frame.source(), now);
    const auto asker = question                 ? std::optional{question->asker}
                       : frame.id() == firmware ? updater(frame.source(), now)
                                                : std::nullopt;
    if (!asker || *asker == address_ || to_everybody) return frame;
    const std::span<std::uint8_t> bytes{in_.get(), frame.bytes().size()};
    std::copy(frame.bytes().begin(), frame.bytes().end(), bytes.begin());
    bytes[2] = *asker;
    if (frame.id() == check) {
        bytes[ano::header_size + 1] = question->checks.sum;
        bytes[ano::header_size + 2] = question->checks.add;
    }
    ano::seal(bytes);
    return ano::FrameView{bytes};
}

void PresentAs::remember(ano::FrameView sent, ano::FrameView original, ano::TimePoint now) noexcept {
    const auto answer = ano::answer_to(sent);
    if (!answer) return;
    if (sent.id() == firmware) sessions_[sent.destination()] = {now, original.source()};
    if (end_ - first_ == capacity) ++first_;
    const std::size_t place = end_++ % capacity;
    answers_[place] = *answer;
    questions_[place] = {now, {}, original.source(), original.destination(), original.checks()};
}

// Finds the question that a frame of `device` answers, and marks it as answered by `device`.
const PresentAs::Question* PresentAs::asked(ano::Answer answer, std::uint8_t device, ano::TimePoint now) noexcept {
    while (first_ != end_ && now - questions_[first_ % capacity].at >= memory) ++first_;
    Addresses served;    // askers to whom this device has already sent an answer to this question
    const auto each = [&](auto visit) {
        for (std::size_t n = first_; n != end_; ++n)
            if (answers_[n % capacity] == answer && reaches(questions_[n % capacity].to, device)) visit(questions_[n % capacity]);
    };
    Question* latest = nullptr;
    each([&](Question& question) {
        latest = &question;
        if (question.answered_by[device]) served.set(question.asker);
    });
    Question *unserved = nullptr, *open = nullptr;    // the oldest of each
    each([&](Question& question) {
        if (question.answered_by[device]) return;
        if (!open) open = &question;
        if (!unserved && !served[question.asker]) unserved = &question;
    });
    // The steps of a firmware update differ in bytes that the answer does not repeat: each answer belongs to the oldest question.
    Question* const chosen = unserved && answer.id() != firmware ? unserved : open;
    if (chosen) chosen->answered_by.set(device);
    // A device may acknowledge a frame twice, and no other frame has these checks.
    return chosen || !answer.is_acknowledgement() ? chosen : latest;
}

// The host that last sent firmware to the device: it receives the answers that have several steps.
std::optional<std::uint8_t> PresentAs::updater(std::uint8_t device, ano::TimePoint now) const noexcept {
    const Session* last = nullptr;
    for (unsigned to = 1; to <= address::broadcast; ++to)
        if (reaches(static_cast<std::uint8_t>(to), device) && (!last || sessions_[to].at > last->at)) last = &sessions_[to];
    return last && last->at != ano::TimePoint::min() && now - last->at < session ? std::optional{last->asker} : std::nullopt;
}

}    // namespace anogate
