// Which frames ask a device, which answer, which act on it and which write to it (protocol text, sections 3 and 4). No other file
// defines this.
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/messages.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <span>

namespace ano {

/// The effect of a frame on its receiver.
enum class Intent : std::uint8_t {
    informs,    // telemetry, answers, everything else
    asks,       // a question that a device answers with data
    acts,       // a command, sticks, or a write: it moves a vehicle or changes a device
};

/// Whether a check frame (0x00) answers, and when.
enum class Acknowledged : std::uint8_t { no, yes, as_write };

namespace conversation {

enum class Does : std::uint8_t {
    asks,
    acts,
    writes,    // acts as well; only one host at a time may write
};
using enum Does;

/// Frames of one id, or only those whose DATA begins with `first`.
struct Row {
    std::uint8_t id;
    std::uint16_t first;
    Does does;
    std::uint16_t answer;    // the id of the answer
    std::uint8_t from = 0,
                 size = 0;    // the part of DATA that the DATA of the answer begins with; for an acknowledgement see Answer
};
inline constexpr std::uint16_t other = 0x100;      // as `first`: any byte that no row above has, or no DATA
inline constexpr std::uint16_t nothing = 0x100;    // as `answer`

inline constexpr std::uint8_t check = id_of<"check">, waypoint_read = id_of<"waypoint_read">, waypoint = id_of<"waypoint">,
                              command_query = id_of<"command_query">, parameter_command = id_of<"parameter_command">,
                              parameter_value = id_of<"parameter_value">, firmware = id_of<"firmware">;

// clang-format off
inline constexpr Row rows[] = {
    {id_of<"remote_control">, other, acts, nothing},                 // section 3: a stream
    {id_of<"realtime_control">, other, acts, nothing},               // section 3: a stream
    {waypoint_read, 0xFF, asks, waypoint_read},                      // section 4, 0x60: how many
    {waypoint_read, other, asks, waypoint, 0, 1},                    // section 4, 0x60: waypoint n
    {waypoint, other, writes, check},                                // section 3; a waypoint sent to a host is an answer
    {id_of<"command">, other, acts, check},                          // section 3
    {command_query, 0, asks, command_query, 0, 1},                   // section 4, 0xC1: how many
    {command_query, 1, asks, id_of<"command_info">, 1, 2},           // section 4, 0xC1: describe command val
    {parameter_command, 0, asks, id_of<"device_info">},              // section 4, 0xE0
    {parameter_command, 1, asks, parameter_command, 0, 1},           // section 4, 0xE0: how many
    {parameter_command, 2, asks, parameter_value, 1, 2},             // section 4, 0xE0: value of val
    {parameter_command, 3, asks, id_of<"parameter_info">, 1, 2},     // section 4, 0xE0: description of val
    {parameter_command, 0x10, acts, check},                          // section 3
    {parameter_command, other, acts, nothing},                       // not in the protocol text, so it may do anything
    {parameter_value, other, writes, check},                         // section 3; a value sent to a host is an answer
    {firmware, other, writes, firmware},                             // section 3: answered by its own codes
};
// clang-format on

/// Summary of the rows of one id.
struct OfId {
    std::uint8_t first_row = 0, rows = 0;
    bool may_ask = false, may_act = false, may_be_acknowledged = false, answers = false;
    std::uint8_t repeats = 0;    // bytes with which an answer of this id begins
    std::uint8_t least = 0;      // minimum bytes of DATA; fewer are malformed
};
consteval std::array<OfId, 256> by_id() {
    std::array<OfId, 256> all{};
    for (std::size_t i = std::size(rows); i-- > 0;) {
        const Row& row = rows[i];
        OfId& of = all[row.id];
        of.first_row = static_cast<std::uint8_t>(i);
        ++of.rows;
        (row.does == asks ? of.may_ask : of.may_act) = true;
        of.may_be_acknowledged = of.may_be_acknowledged || row.answer == check;
        if (row.answer == nothing) continue;
        all[row.answer].answers = true;
        all[row.answer].repeats = row.answer == check ? std::uint8_t{3} : row.size;
    }
    for (const Message& message : messages)
        if (message.is_base()) all[message.id].least = static_cast<std::uint8_t>(message.fixed_size);
    return all;
}
inline constexpr std::array<OfId, 256> of_id = by_id();

constexpr const Row* row_of(FrameView frame) noexcept {
    const OfId& of = of_id[frame.id()];
    const auto data = frame.data();
    for (std::size_t i = of.first_row; i < std::size_t{of.first_row} + of.rows; ++i)
        if (rows[i].first == other || (!data.empty() && rows[i].first == data[0])) return &rows[i];
    return nullptr;
}

}    // namespace conversation

/// Identifies an answer: its id, and the bytes that it repeats of the frame that it answers. These are the number of a parameter,
/// command or waypoint; nothing if only one answer is possible; or, for an acknowledgement, the id and both check bytes.
struct Answer {
    std::uint32_t bits = 0;

    constexpr Answer() noexcept = default;
    constexpr Answer(std::uint8_t id, std::span<const std::uint8_t> repeats) noexcept : bits{id} {
        for (std::size_t i = 0; i < repeats.size(); ++i) bits |= std::uint32_t{repeats[i]} << (8 + 8 * i);
    }
    constexpr std::uint8_t id() const noexcept { return static_cast<std::uint8_t>(bits); }
    constexpr bool is_acknowledgement() const noexcept { return id() == conversation::check; }
    friend constexpr bool operator==(Answer, Answer) noexcept = default;
};

/// Whether DATA is at least as long as the fixed part of the base layout: a shorter one is malformed (protocol text, section 4).
constexpr bool is_whole(FrameView frame) noexcept { return frame.data().size() >= conversation::of_id[frame.id()].least; }

namespace conversation {

constexpr std::optional<Answer> answer_by(const Row* row, FrameView frame) noexcept {
    if (row == nullptr || row->answer == nothing || (row->does == asks && !is_whole(frame))) return std::nullopt;
    if (row->answer != check) return Answer{static_cast<std::uint8_t>(row->answer), frame.data().subspan(row->from, row->size)};
    const std::uint8_t repeats[] = {frame.id(), frame.checks().sum, frame.checks().add};
    return Answer{check, repeats};
}

}    // namespace conversation

/// The answer to `frame`, which is for a device; std::nullopt: it is not answered, or is a malformed question.
constexpr std::optional<Answer> answer_to(FrameView frame) noexcept {
    return conversation::answer_by(conversation::row_of(frame), frame);
}

/// The answer that `frame`, which is from a device, contains; std::nullopt: it is no answer.
constexpr std::optional<Answer> answer_in(FrameView frame) noexcept {
    const conversation::OfId& of = conversation::of_id[frame.id()];
    if (!of.answers || frame.data().size() < of.repeats) return std::nullopt;
    return Answer{frame.id(), frame.data().first(of.repeats)};
}

/// Whether frames of this id may be answers.
constexpr bool may_answer(std::uint8_t id) noexcept { return conversation::of_id[id].answers; }
/// Whether frames of this id may ask or act. To a host they are answers, or have no effect.
constexpr bool is_for_devices(std::uint8_t id) noexcept { return conversation::of_id[id].rows != 0; }
/// Whether a device may answer frames of this id with a check frame (0x00).
constexpr bool may_be_acknowledged(std::uint8_t id) noexcept { return conversation::of_id[id].may_be_acknowledged; }

/// A question that a device answers with data: the address that is asked, and the expected answer.
struct Question {
    std::uint8_t asked = 0;    // 0xFF and port ids mean any device
    Answer answer{};
    friend constexpr bool operator==(Question, Question) noexcept = default;
};

/// The question in `frame`: 0x60, 0xC1, and 0xE0 with the commands 0 to 3. std::nullopt for any other frame. A write or a command
/// is not a question. A frame to a host is an answer, which for 0x60, 0xC1 and 0xE0 1 looks the same.
constexpr std::optional<Question> question_in(FrameView frame) noexcept {
    if (!conversation::of_id[frame.id()].may_ask || address::is_host(frame.destination())) return std::nullopt;
    const conversation::Row* row = conversation::row_of(frame);
    if (row == nullptr || row->does != conversation::asks) return std::nullopt;
    const auto answer = conversation::answer_by(row, frame);
    return answer ? std::optional{Question{frame.destination(), *answer}} : std::nullopt;
}

/// Whether `source` may answer for the address that was asked.
constexpr bool may_answer_for(std::uint8_t source, std::uint8_t asked) noexcept {
    return source == asked || asked == address::broadcast || address::is_port_id(asked);
}

constexpr bool answers(FrameView frame, Question question) noexcept {
    return may_answer_for(frame.source(), question.asked) && answer_in(frame) == question.answer;
}

/// A frame that commands or changes a vehicle: remote and realtime control, a command, a parameter or waypoint write, firmware,
/// and 0xE0 unless it is one of the listed questions. The destination is not considered, although the same ids to a host are
/// answers.
constexpr bool is_control(FrameView frame) noexcept {
    const conversation::OfId& of = conversation::of_id[frame.id()];
    if (!of.may_ask) return of.may_act;
    const conversation::Row* row = conversation::row_of(frame);
    return row != nullptr && row->does != conversation::asks;
}

/// Parameters, waypoints or firmware for a device.
constexpr bool writes(FrameView frame) noexcept {
    const conversation::Row* row = conversation::row_of(frame);
    return row != nullptr && row->does == conversation::writes && !address::is_host(frame.destination());
}

/// The intent of a frame. Frames to a host never ask or act: the same ids to a host are answers.
constexpr Intent intent_of(FrameView frame) noexcept {
    const conversation::OfId& of = conversation::of_id[frame.id()];
    if (of.rows == 0 || address::is_host(frame.destination())) return Intent::informs;
    if (!of.may_ask) return Intent::acts;
    const conversation::Row* row = conversation::row_of(frame);
    if (row == nullptr) return Intent::informs;
    if (row->does != conversation::asks) return Intent::acts;
    return is_whole(frame) ? Intent::asks : Intent::informs;
}

/// A question that can't be an answer: only hosts send it, even if their address is not a host address.
constexpr bool is_of_a_host(FrameView frame) noexcept {
    if (!conversation::of_id[frame.id()].may_ask || frame.id() == conversation::waypoint_read) return false;
    const conversation::Row* row = conversation::row_of(frame);
    return row != nullptr && row->does == conversation::asks && row->answer != row->id && is_whole(frame);
}

/// Whether frames of this layout are acknowledged.
constexpr Acknowledged acknowledged(const Message& layout) noexcept {
    for (const conversation::Row& row : conversation::rows) {
        if (row.id != layout.id || row.answer != conversation::check) continue;
        if (row.first != conversation::other && layout.fields()[0].selects.value_or(Only{0, 0}).first != row.first) continue;
        return row.does == conversation::writes ? Acknowledged::as_write : Acknowledged::yes;
    }
    return Acknowledged::no;
}

}    // namespace ano
