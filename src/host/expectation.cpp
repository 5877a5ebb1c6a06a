#include <ano/address.hpp>
#include <ano/firmware_codes.hpp>
#include <ano/messages.hpp>
#include <ano/reading.hpp>
#include <ano/typed.hpp>
#include <host/expectation.hpp>

namespace ano::host {
namespace {

constexpr std::uint8_t how_many_waypoints = 0xFF;

// Frames of a host only: a message that is acknowledged "as a write" is a write then.
bool is_acknowledged(FrameView request) noexcept {
    const Message* row = select_layout(layouts_of(request.id()), request.data());
    return row != nullptr && row->acknowledged != Acknowledged::no;
}

// Whether `field` of the answer is `number`.
template <Name M, Name F>
bool has_number(FrameView frame, std::uint16_t number) noexcept {
    const auto view = as<M>(frame);
    return view && view->template get<F>() == number;
}

// The same for a description of a parameter, whose layouts all begin with its id.
bool describes(FrameView frame, std::uint16_t parameter) noexcept {
    using Info = View<"parameter_info">;
    return frame.id() == Info::message().id && frame.data().size() >= Info::message().fixed_size &&
           Info{frame.data()}.get<"par_id">() == parameter;
}

}    // namespace

bool may_be_of(std::uint8_t source, std::uint8_t asked) noexcept {
    if (address::is_host(source) || source == address::unassigned || source == address::broadcast) return false;
    return source == asked || address::is_port_id(asked);
}

std::optional<Expectation> Expectation::of(FrameView request) noexcept {
    if (is_acknowledged(request)) {
        Expectation e{request, Kind::acknowledgement, request.id()};
        e.checks_ = request.checks();
        return e;
    }
    if (const auto query = as<"waypoint_read">(request)) {
        const std::uint8_t num = query->get<"num">();
        return num == how_many_waypoints ? Expectation{request, Kind::waypoint_count} : Expectation{request, Kind::waypoint, num};
    }
    if (const auto query = as<"command_query">(request)) {
        if (query->get<"cmd">() == 0) return Expectation{request, Kind::command_count};
        if (query->get<"cmd">() == 1) return Expectation{request, Kind::command_info, query->get<"val">()};
        return std::nullopt;
    }
    if (const auto query = as<"parameter_command">(request)) {
        switch (query->get<"cmd">()) {
        case 0: return Expectation{request, Kind::device_info};
        case 1: return Expectation{request, Kind::parameter_count};
        case 2: return Expectation{request, Kind::parameter_value, query->get<"val">()};
        case 3: return Expectation{request, Kind::parameter_info, query->get<"val">()};
        default: return std::nullopt;
        }
    }
    return of_firmware(request);
}

std::optional<Expectation> Expectation::of_firmware(FrameView request) noexcept {
    if (as<"firmware", "info">(request)) return Expectation{request, Kind::firmware_info};
    if (const auto image = as<"firmware", "image">(request))
        return Expectation{request, Kind::firmware_frame, image->get<"frame_num">()};
    const auto step = firmware_code_in(request);
    if (!step) return std::nullopt;
    if (step->code == firmware_code::erase) return Expectation{request, Kind::firmware_erase};
    if (step->code == firmware_code::all_sent) return Expectation{request, Kind::firmware_check};
    return std::nullopt;
}

bool Expectation::is_for_it(FrameView frame) const noexcept {
    const bool for_us = frame.destination() == asker_ || frame.destination() == address::broadcast;
    if (!for_us || may_be_of(frame.source(), asked_)) return for_us;
    // Some devices acknowledge as the port by which the request came. The check bytes show that it is the same request.
    return kind_ == Kind::acknowledgement && address::is_port_id(frame.source()) && !address::is_port_id(asked_) && fits(frame);
}

bool Expectation::is_met_by(FrameView frame) const noexcept { return is_for_it(frame) && fits(frame); }

bool Expectation::is_missed_by(FrameView frame) const noexcept {
    if (!is_for_it(frame) || fits(frame)) return false;
    if (kind_ >= Kind::firmware_info) return frame.id() == id_of<"firmware">;
    const auto check = as<"check">(frame);
    return kind_ == Kind::acknowledgement && check && check->get<"id_get">() == about_;
}

bool Expectation::may_be_met_by(std::uint8_t id) noexcept {
    return id == id_of<"check"> || id == id_of<"parameter_value"> || id == id_of<"parameter_info"> ||
           id == id_of<"device_info"> || id == id_of<"parameter_command"> || id == id_of<"command_query"> ||
           id == id_of<"command_info"> || id == id_of<"waypoint_read"> || id == id_of<"waypoint"> || id == id_of<"firmware">;
}

bool Expectation::fits(FrameView frame) const noexcept {
    switch (kind_) {
    case Kind::acknowledgement: {
        const auto check = as<"check">(frame);
        return check && check->get<"id_get">() == about_ && check->get<"sc_get">() == checks_.sum &&
               check->get<"ac_get">() == checks_.add;
    }
    case Kind::device_info: return as<"device_info">(frame).has_value();
    case Kind::parameter_count: return has_number<"parameter_command", "cmd">(frame, 1);
    case Kind::parameter_value: return has_number<"parameter_value", "par_id">(frame, about_);
    case Kind::parameter_info: return describes(frame, about_);
    case Kind::command_count: return has_number<"command_query", "cmd">(frame, 0);
    case Kind::command_info: return has_number<"command_info", "cmd_id">(frame, about_);
    case Kind::waypoint_count: return as<"waypoint_read">(frame).has_value();
    case Kind::waypoint: return has_number<"waypoint", "num">(frame, about_);
    default: return fits_firmware(frame);
    }
}

bool Expectation::fits_firmware(FrameView frame) const noexcept {
    using namespace firmware_code;
    const auto answer = firmware_code_in(frame);
    if (!answer) return false;
    if (answer->is_of_frame) return kind_ == Kind::firmware_frame && answer->frame_num == about_;
    const std::uint16_t code = answer->code;
    switch (kind_) {
    case Kind::firmware_info: return code == info_refused || code == info_accepted;
    case Kind::firmware_erase: return code == erase_failed || code == erased;
    case Kind::firmware_check: return code == check_failed || code == check_passed;
    default: return false;
    }
}

}    // namespace ano::host
