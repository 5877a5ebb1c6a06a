#include <ano/address.hpp>
#include <device/device.hpp>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace ano::device {
namespace {

constexpr std::uint8_t cmd_info = 0;    // of 0xE0

// Calls `f` with the message; a frame without its layout is malformed.
template <Name M, Name Label = "", class F>
Outcome with(FrameView frame, F&& f) {
    const auto view = as<M, Label>(frame);
    return view ? f(*view) : Outcome::malformed;
}

}    // namespace

Device::Device(Info info, const Profile& profile) : info_{std::move(info)}, profile_{profile} {
    if (info_.id == address::unassigned || info_.id == address::host || info_.id == address::broadcast)
        throw std::invalid_argument{"the id of a device is 1 to 253"};
    if (info_.name.size() > max_name) throw std::invalid_argument{"the name of a device has at most 20 bytes: " + info_.name};
}

void Device::take(FrameView frame, TimePoint now, Link link) {
    run(now);
    const std::uint8_t from = frame.source();
    const bool is_ours = profile_.any_address || frame.destination() == info_.id || frame.destination() == address::broadcast;
    if (!is_ours) ++counters_.not_ours;
    else if (from == address::unassigned || from == address::broadcast || from == info_.id) ++counters_.from_nobody;
    else if (frame.data().size() > profile_.max_data) ++counters_.too_long;
    else if (crashed()) ++counters_.crashed;
    else if (profile_.queue != 0) enqueue(frame, now, link);
    else handle(frame, now, link);
}

void Device::enqueue(FrameView frame, TimePoint now, Link link) {
    if (queue_.size() >= profile_.queue) {
        ++counters_.queue_full;
        return;
    }
    const TimePoint begin = queue_.empty() ? now : std::max(now, queue_.back().due);
    queue_.push_back({{frame.bytes().begin(), frame.bytes().end()}, link, begin + profile_.handling});
}

// Performs the work in the order in which it is due, even if run() is called late.
void Device::run(TimePoint now) {
    for (auto at = due(); at && *at <= now; at = due()) {
        if (firmware_.due() == at) end_firmware_step(*at);
        else handle_first();
    }
}

void Device::handle_first() {
    const Waiting first = std::move(queue_.front());
    queue_.pop_front();
    if (crashed()) ++counters_.crashed;
    else handle(FrameView{first.bytes}, first.due, first.link);
}

std::optional<TimePoint> Device::due() const noexcept {
    const auto step = firmware_.due();
    if (queue_.empty()) return step;
    return step ? std::min(*step, queue_.front().due) : queue_.front().due;
}

void Device::handle(FrameView frame, TimePoint now, Link link) {
    Reply reply{frame, link, info_.id, out_};
    count(dispatch(frame, now, reply));
    counters_.answers_lost += reply.lost();
}

Outcome Device::dispatch(FrameView frame, TimePoint now, Reply& reply) {
    switch (frame.id()) {
    case id_of<"parameter_command">: return parameter_command(frame, reply);
    case id_of<"parameter_value">:
        return with<"parameter_value">(frame, [&](const auto& written) { return parameters_.process(written, reply); });
    case id_of<"command">: return with<"command">(frame, [&](const auto& command) { return commands_.process(command, reply); });
    case id_of<"command_query">:
        return with<"command_query">(frame, [&](const auto& question) { return commands_.process(question, reply); });
    case id_of<"waypoint_read">:
        return with<"waypoint_read">(frame, [&](const auto& question) { return waypoints_.process(question, reply); });
    case id_of<"waypoint">:
        return with<"waypoint">(frame, [&](const auto& written) { return waypoints_.process(written, reply); });
    case id_of<"firmware">: return firmware_step(frame, now, reply);
    default: return Outcome::unanswered;
    }
}

// A firmware frame to all devices is refused: it would erase every device.
Outcome Device::firmware_step(FrameView frame, TimePoint now, Reply& reply) {
    if (frame.destination() == address::broadcast) return Outcome::refused;
    if (const auto info = as<"firmware", "info">(frame)) return firmware_.process(*info, reply);
    if (const auto image = as<"firmware", "image">(frame)) return firmware_.process(*image, reply);
    const auto code = firmware_code_in(frame);
    if (!code) return Outcome::malformed;
    if (code->is_of_frame) return Outcome::unanswered;    // an answer of the loader of another device
    return firmware_.process(*code, now, reply);
}

void Device::end_firmware_step(TimePoint now) {
    const auto late = firmware_.run(now);
    if (!late) return;
    if (!send(late->answer, late->asker.address, late->asker.link)) ++counters_.answers_lost;
}

Outcome Device::parameter_command(FrameView frame, Reply& reply) {
    if (const auto action = as<"parameter_command", "action">(frame)) return parameters_.process(*action, reply);
    return with<"parameter_command">(frame, [&](const auto& question) {
        return question.template get<"cmd">() == cmd_info ? send_info(reply) : parameters_.process(question, reply);
    });
}

Outcome Device::send_info(Reply& reply) const {
    Draft<"device_info"> answer;
    const bool all = answer.set<"dev_id">(info_.id) && answer.set<"hw_ver">(info_.hw_ver) && answer.set<"sw_ver">(info_.sw_ver) &&
                     answer.set<"bl_ver">(info_.bl_ver) && answer.set<"pt_ver">(info_.pt_ver) &&
                     answer.set<"name">(std::string_view{info_.name});
    return all ? reply.send(answer) : Outcome::unknown;
}

bool Device::log(std::string_view text, LogColor color, std::uint8_t destination) noexcept {
    Draft<"log"> line;
    return line.set<"color">(static_cast<std::uint8_t>(color)) && line.set<"str">(what_fits(text, line.data_size())) &&
           send(line, destination);
}

bool Device::log(float value, std::string_view text, std::uint8_t destination) noexcept {
    Draft<"log_value"> line;
    return line.set<"val">(value) && line.set<"str">(what_fits(text, line.data_size())) && send(line, destination);
}

void Device::count(Outcome outcome) noexcept {
    switch (outcome) {
    case Outcome::answered:
    case Outcome::later: ++counters_.answered; break;
    case Outcome::unanswered: ++counters_.unanswered; break;
    case Outcome::unknown: ++counters_.unknown; break;
    case Outcome::malformed: ++counters_.malformed; break;
    case Outcome::refused: ++counters_.refused; break;
    }
}

}    // namespace ano::device
