// Which frame asks a device, which one answers, and which one acts on it (protocol text, sections 3 and 4).
#pragma once
#include <ano/address.hpp>
#include <ano/control.hpp>
#include <ano/frame.hpp>
#include <ano/messages.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace ano {

/// What a frame does to its receiver.
enum class Intent : std::uint8_t {
    informs,    // telemetry, answers, everything else
    asks,       // a question that a device answers with data
    acts,       // a command, sticks, or a write: it moves a vehicle or changes a device
};

/// A question that a device answers with data: who is asked, and how the answer is recognised.
struct Question {
    std::uint8_t asked = 0;    // 0xFF and port ids stand for any device
    std::uint8_t answer_id = 0;
    std::uint16_t about = 0;    // the number of a parameter, command or waypoint; 0 where only one answer is possible
    friend constexpr bool operator==(Question, Question) noexcept = default;
};

namespace conversation {

/// A question of the id `asks` whose DATA begins with `first`, and how it is answered.
struct Row {
    std::uint8_t asks, first;
    std::uint8_t answer;
    std::uint8_t about_at = 0;      // where DATA of the question has the number that the answer repeats; 0: there is none
    bool like_an_answer = false;    // an answer of a device may look the same
};
inline constexpr std::uint8_t waypoint_read = id_of<"waypoint_read">, command_query = id_of<"command_query">,
                              parameter_command = id_of<"parameter_command">;
inline constexpr std::uint8_t how_many = 0xFF;    // waypoints; any other number asks for the waypoint of that number

inline constexpr Row rows[] = {
    {waypoint_read, how_many, waypoint_read, 0, true},  {command_query, 0, command_query, 0, true},
    {command_query, 1, id_of<"command_info">, 1},       {parameter_command, 0, id_of<"device_info">},
    {parameter_command, 1, parameter_command, 0, true}, {parameter_command, 2, id_of<"parameter_value">, 1},
    {parameter_command, 3, id_of<"parameter_info">, 1},
};

consteval std::array<bool, 256> asking_ids() {
    std::array<bool, 256> all{};
    for (const Row& row : rows) all[row.asks] = true;
    return all;
}
inline constexpr std::array<bool, 256> may_ask = asking_ids();

constexpr std::uint16_t number_at(std::span<const std::uint8_t> data, std::size_t at) noexcept {
    return static_cast<std::uint16_t>(data[at] | data[at + 1] << 8);
}

constexpr const Row* row_of(FrameView frame) noexcept {
    const auto data = frame.data();
    if (data.size() < (frame.id() == waypoint_read ? 1u : 3u)) return nullptr;
    for (const Row& row : rows)
        if (row.asks == frame.id() && row.first == data[0]) return &row;
    return nullptr;
}

}    // namespace conversation

/// The question that `frame` asks: 0x60, 0xC1, and 0xE0 with the commands 0 to 3. std::nullopt for any other frame: a write or a
/// command is not a question, and a frame to a host is an answer, which in 0x60, 0xC1 and 0xE0 1 looks the same.
constexpr std::optional<Question> question_in(FrameView frame) noexcept {
    namespace c = conversation;
    const std::uint8_t to = frame.destination();
    if (!c::may_ask[frame.id()] || address::is_host(to)) return std::nullopt;
    if (const c::Row* row = c::row_of(frame))
        return Question{to, row->answer, row->about_at == 0 ? std::uint16_t{0} : c::number_at(frame.data(), row->about_at)};
    if (frame.id() == c::waypoint_read && !frame.data().empty()) return Question{to, id_of<"waypoint">, frame.data()[0]};
    return std::nullopt;
}

/// Whether DATA of `frame` answers `question`, whoever sent it.
constexpr bool answers_data_of(FrameView frame, Question question) noexcept {
    namespace c = conversation;
    const auto data = frame.data();
    if (frame.id() != question.answer_id) return false;
    switch (frame.id()) {
    case id_of<"device_info">:
    case c::waypoint_read: return true;
    case id_of<"waypoint">: return !data.empty() && data[0] == question.about;
    case c::command_query: return !data.empty() && data[0] == 0;
    case c::parameter_command: return !data.empty() && data[0] == 1;
    default: return data.size() >= 2 && c::number_at(data, 0) == question.about;
    }
}

/// Whether `source` may answer for the address that was asked.
constexpr bool may_answer_for(std::uint8_t source, std::uint8_t asked) noexcept {
    return source == asked || asked == address::broadcast || address::is_port_id(asked);
}

constexpr bool answers(FrameView frame, Question question) noexcept {
    return may_answer_for(frame.source(), question.asked) && answers_data_of(frame, question);
}

/// Frames to a host never ask or act: there the same ids are answers.
constexpr Intent intent_of(FrameView frame) noexcept {
    const bool may_act = table::controls_of[frame.id()] != Controls::no;
    if (!may_act && !conversation::may_ask[frame.id()]) return Intent::informs;
    if (address::is_host(frame.destination())) return Intent::informs;
    if (may_act && is_control(frame)) return Intent::acts;
    return question_in(frame) ? Intent::asks : Intent::informs;
}

/// A question that can't be an answer: only hosts send it, whatever their address is.
constexpr bool is_of_a_host(FrameView frame) noexcept {
    if (!conversation::may_ask[frame.id()] || frame.id() == conversation::waypoint_read) return false;
    const conversation::Row* row = conversation::row_of(frame);
    return row != nullptr && !row->like_an_answer;
}

}    // namespace ano
