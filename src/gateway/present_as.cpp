#include <ano/address.hpp>
#include <ano/control.hpp>
#include <gateway/inhibit.hpp>
#include <gateway/present_as.hpp>
#include <gateway/question_ids.hpp>
#include <gateway/queue_policy.hpp>

#include <algorithm>
#include <cassert>

namespace anogate {
namespace {

namespace address = ano::address;

using namespace questions;
constexpr std::uint8_t check = ano::id_of<"check">, firmware = ano::id_of<"firmware">;

// The same for a question and its answer: the id of the answer, and what the answer repeats of the question.
constexpr std::uint32_t key(std::uint8_t id, std::uint32_t repeats = 0) noexcept { return id | repeats << 8; }

constexpr std::uint32_t acknowledgement_key(std::uint8_t id, ano::Checks checks) noexcept {
    return key(check, std::uint32_t{id} | std::uint32_t{checks.sum} << 8 | std::uint32_t{checks.add} << 16);
}

constexpr std::uint8_t u8_at(std::span<const std::uint8_t> data, std::size_t i) noexcept { return i < data.size() ? data[i] : 0; }
constexpr std::uint32_t u16_at(std::span<const std::uint8_t> data, std::size_t i) noexcept {
    return std::uint32_t{u8_at(data, i)} | std::uint32_t{u8_at(data, i + 1)} << 8;
}

// The key of the answer to this frame (protocol text, sections 3 and 4); std::nullopt: no answer is known.
std::optional<std::uint32_t> answer_to(ano::FrameView frame) noexcept {
    const auto data = frame.data();
    switch (frame.id()) {
    case check: return std::nullopt;
    case waypoint_read: return u8_at(data, 0) == 0xFF ? key(waypoint_read) : key(waypoint, u8_at(data, 0));
    case command_query: return u8_at(data, 0) == 0 ? key(command_query) : key(command_info, u16_at(data, 1));
    case firmware: return key(firmware);
    case parameter_command:
        switch (u8_at(data, 0)) {
        case 0: return key(device_info);
        case 1: return key(parameter_command);
        case 2: return key(parameter_value, u16_at(data, 1));
        case 3: return key(parameter_info, u16_at(data, 1));
        }
        break;
    }
    if (!ano::may_be_acknowledged(frame.id())) return std::nullopt;
    return acknowledgement_key(frame.id(), frame.checks());
}

// The key of the question that this frame answers; std::nullopt: none.
std::optional<std::uint32_t> answered_by(ano::FrameView frame) noexcept {
    const auto data = frame.data();
    switch (frame.id()) {
    case check:
        if (data.size() < 3) return std::nullopt;
        return acknowledgement_key(data[0], {data[1], data[2]});
    case waypoint_read: return key(waypoint_read);
    case waypoint: return key(waypoint, u8_at(data, 0));
    case command_query: return key(command_query);
    case command_info: return key(command_info, u16_at(data, 0));
    case parameter_command: return key(parameter_command);
    case parameter_value: return key(parameter_value, u16_at(data, 0));
    case parameter_info: return key(parameter_info, u16_at(data, 0));
    case device_info: return key(device_info);
    case firmware: return key(firmware);
    default: return std::nullopt;
    }
}

// Whether only hosts send such frames.
bool only_hosts_say(ano::FrameView frame) noexcept {
    return is_control(frame) || frame.id() == waypoint_read || frame.id() == command_query || frame.id() == parameter_command;
}

}    // namespace

PresentAs::PresentAs(std::uint8_t address, std::size_t max_data)
    : address_{address},
      max_size_{ano::overhead + max_data},
      in_{new std::uint8_t[max_size_]},
      out_{new std::uint8_t[max_size_]},
      keys_{new std::uint32_t[capacity]},
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
    if (from != address_ && !address::is_host(from) && (devices_[from] || !only_hosts_say(frame))) return frame;
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
    const auto answered = answered_by(frame);
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
    const auto answer = answer_to(sent);
    if (!answer) return;
    if (sent.id() == firmware) sessions_[sent.destination()] = {now, original.source()};
    if (end_ - first_ == capacity) ++first_;
    const std::size_t place = end_++ % capacity;
    keys_[place] = *answer;
    questions_[place] = {now, {}, original.source(), original.destination(), original.checks()};
}

// Finds the question that a frame of `device` answers, and marks it as answered by `device`.
const PresentAs::Question* PresentAs::asked(std::uint32_t key, std::uint8_t device, ano::TimePoint now) noexcept {
    while (first_ != end_ && now - questions_[first_ % capacity].at >= memory) ++first_;
    Addresses served;    // askers that have an answer of this device to this question already
    const auto each = [&](auto visit) {
        for (std::size_t n = first_; n != end_; ++n)
            if (keys_[n % capacity] == key && reaches(questions_[n % capacity].to, device)) visit(questions_[n % capacity]);
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
    // The steps of a firmware update differ in bytes that are not part of the key: each answer is for the oldest question.
    Question* const chosen = unserved && static_cast<std::uint8_t>(key) != firmware ? unserved : open;
    if (chosen) chosen->answered_by.set(device);
    // A device may acknowledge a frame twice, and no other frame has these checks.
    return chosen || static_cast<std::uint8_t>(key) != check ? chosen : latest;
}

// The host that sent firmware to the device last: it gets answers that come in several steps.
std::optional<std::uint8_t> PresentAs::updater(std::uint8_t device, ano::TimePoint now) const noexcept {
    const Session* last = nullptr;
    for (unsigned to = 1; to <= address::broadcast; ++to)
        if (reaches(static_cast<std::uint8_t>(to), device) && (!last || sessions_[to].at > last->at)) last = &sessions_[to];
    return last && last->at != ano::TimePoint::min() && now - last->at < session ? std::optional{last->asker} : std::nullopt;
}

}    // namespace anogate
