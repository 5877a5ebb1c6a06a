#include <ano/address.hpp>
#include <ano/firmware_codes.hpp>
#include <ano/typed.hpp>
#include <host/expectation.hpp>

namespace ano::host {

bool may_be_of(std::uint8_t source, std::uint8_t asked) noexcept {
    if (address::is_host(source) || source == address::unassigned || source == address::broadcast) return false;
    return source == asked || address::is_port_id(asked);
}

std::optional<Expectation> Expectation::of(FrameView request) noexcept {
    const auto answer = answer_to(request);
    if (!answer || !is_whole(request)) return std::nullopt;
    return answer->id() == id_of<"firmware"> ? of_firmware(request) : Expectation{request, Kind::answer, *answer};
}

std::optional<Expectation> Expectation::of_firmware(FrameView request) noexcept {
    const Answer any{id_of<"firmware">, {}};
    if (as<"firmware", "info">(request)) return Expectation{request, Kind::firmware_info, any};
    if (const auto image = as<"firmware", "image">(request))
        return Expectation{request, Kind::firmware_frame, any, image->get<"frame_num">()};
    const auto step = firmware_code_in(request);
    if (!step) return std::nullopt;
    if (step->code == firmware_code::erase) return Expectation{request, Kind::firmware_erase, any};
    if (step->code == firmware_code::all_sent) return Expectation{request, Kind::firmware_check, any};
    return std::nullopt;
}

bool Expectation::is_for_it(FrameView frame) const noexcept {
    const bool for_us = frame.destination() == asker_ || frame.destination() == address::broadcast;
    if (!for_us || may_be_of(frame.source(), asked_)) return for_us;
    // Some devices acknowledge with the address of the port at which the request arrived. The check bytes show that it is the
    // same request.
    return is_acknowledgement() && address::is_port_id(frame.source()) && !address::is_port_id(asked_) && fits(frame);
}

bool Expectation::is_met_by(FrameView frame) const noexcept { return is_for_it(frame) && fits(frame); }

bool Expectation::is_missed_by(FrameView frame) const noexcept {
    if (!is_for_it(frame) || fits(frame)) return false;
    if (kind_ != Kind::answer) return frame.id() == id_of<"firmware">;
    const auto check = as<"check">(frame);
    return is_acknowledgement() && check && check->get<"id_get">() == id_;
}

bool Expectation::fits(FrameView frame) const noexcept {
    return kind_ == Kind::answer ? answer_in(frame) == answer_ && is_whole(frame) : fits_firmware(frame);
}

bool Expectation::fits_firmware(FrameView frame) const noexcept {
    using namespace firmware_code;
    const auto answer = firmware_code_in(frame);
    if (!answer) return false;
    if (answer->is_of_frame) return kind_ == Kind::firmware_frame && answer->frame_num == frame_num_;
    const std::uint16_t code = answer->code;
    switch (kind_) {
    case Kind::firmware_info: return code == info_refused || code == info_accepted;
    case Kind::firmware_erase: return code == erase_failed || code == erased;
    case Kind::firmware_check: return code == check_failed || code == check_passed;
    default: return false;
    }
}

}    // namespace ano::host
