#include <ano/typed.hpp>
#include <host/firmware.hpp>
#include <host/firmware_codes.hpp>
#include <host/parameter_info.hpp>

#include <algorithm>
#include <array>
#include <utility>

namespace ano::host {
namespace {

using namespace std::chrono_literals;
namespace code = firmware_code;

constexpr std::array<std::string_view, 5> step_words{"device info", "description of the image", "erasing", "sending",
                                                     "check of the image"};

// A frame is written to flash before it is answered, which takes longer than the questions by which the round trip was measured.
constexpr Duration write_time = 100ms;

std::uint16_t code_in(const Ended& ended) noexcept {
    if (const auto of_frame = as<"firmware", "written">(*ended.answer)) return of_frame->get<"code">();
    const auto answer = as<"firmware">(*ended.answer);
    return answer ? answer->get<"code">() : std::uint16_t{0};
}

}    // namespace

Firmware::Firmware(Device& device, FirmwareImage image, FirmwareOptions options)
    : Task{device}, image_{std::move(image)}, options_{std::move(options)} {
    options_.frame_len = std::max<std::size_t>(options_.frame_len, 1);
}

std::string_view Firmware::step() const noexcept { return step_words[step_]; }

Progress Firmware::progress() const noexcept {
    return {std::min(frame_ * options_.frame_len, image_.bytes.size()), image_.bytes.size()};
}

double Firmware::bytes_a_second(TimePoint now) const noexcept {
    if (!frames_since_ || now <= *frames_since_) return 0;
    return static_cast<double>(progress().done) / std::chrono::duration<double>(now - *frames_since_).count();
}

std::optional<Duration> Firmware::time_left(TimePoint now) const noexcept {
    const double rate = bytes_a_second(now);
    if (rate <= 0) return std::nullopt;
    const auto [done, total] = progress();
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(static_cast<double>(total - done) / rate));
}

void Firmware::start(TimePoint now) {
    if (image_.bytes.empty()) return finish({Ending::invalid, "the image is empty", {}}, now);
    if (frames() > max_frames)
        return finish(
            {Ending::invalid, "the image has more than 65536 frames of " + std::to_string(options_.frame_len) + " bytes", {}},
            now);
    ask(question::device_info(identify), now);
}

void Firmware::identified(const Ended& ended, TimePoint now) {
    const auto& info = device().info() ? device().info() : options_.info;
    if (!options_.force && !image_.is_for_any_hardware()) {
        if (!info) return finish_silent(step(), ended.evidence, now, "what is sent to it probably does not arrive");
        if (auto misfit = image_.misfit(*info)) return finish({Ending::invalid, std::move(*misfit), {}}, now);
    }
    ask_info(now);
}

void Firmware::ask_info(TimePoint now) {
    step_ = describe;
    Draft<"firmware", "info"> draft;
    (void)draft.set<"bin_len">(image_.bytes.size());
    (void)draft.set<"frame_len">(options_.frame_len);
    (void)draft.set<"bin_crc">(image_.crc);
    (void)draft.set<"bin_ver">(image_.version);
    (void)draft.set<"hw_type">(image_.hw_type);
    (void)draft.set<"hw_ver_min">(image_.hw_ver_min);
    (void)draft.set<"hw_ver_max">(image_.hw_ver_max);
    (void)draft.set<"cmd">(image_.cmd);
    ask(request(draft, describe, {.at_least = write_time}), now);
}

void Firmware::ask_step(Step step, std::uint16_t code, Duration wait, TimePoint now) {
    step_ = step;
    Draft<"firmware"> draft;
    (void)draft.set<"code">(code);
    ask(request(draft, step, {.sends = 1, .wait = wait}), now);
}

void Firmware::ask_frame(TimePoint now) {
    if (frame_ == frames()) return ask_step(check, code::all_sent, 30s, now);
    step_ = send_frame;
    const std::size_t at = frame_ * options_.frame_len;
    piece_.resize(std::min(options_.frame_len, image_.bytes.size() - at));
    if (!image_.bytes.read(at, piece_)) return give_up(Ending::failed, "the file can no longer be read", {}, now);
    Draft<"firmware", "image"> draft;
    (void)draft.set<"frame_num">(frame_);
    (void)draft.set<"data">(Bytes{piece_});
    ask(request(draft, send_frame, {.at_least = write_time}), now);
}

void Firmware::ended(const Ended& ended, TimePoint now) {
    if (ended.tag == identify) return identified(ended, now);
    if (ended.outcome != Outcome::answered) {
        const std::string what = hex_of(device().address()) + " fell silent: " + std::string{step()};
        return give_up(Ending::timeout, what, ended.evidence, now);
    }
    switch (ended.tag) {
    case describe:
        if (code_in(ended) == code::info_refused)
            return finish({Ending::refused, hex_of(device().address()) + " does not want this image", ended.evidence}, now);
        erasing_ = true;
        return ask_step(erase, code::erase, 60s, now);
    case erase:
        if (code_in(ended) == code::erase_failed)
            return give_up(Ending::failed, "the device could not erase", ended.evidence, now);
        frames_since_ = now;
        return ask_frame(now);
    case send_frame: return frame_ended(ended, now);
    default:
        if (code_in(ended) == code::check_failed)
            return give_up(Ending::failed, "the image did not pass the device's check", ended.evidence, now);
        finish({Ending::done, {}, ended.evidence}, now);
    }
}

void Firmware::frame_ended(const Ended& ended, TimePoint now) {
    repeats_ += ended.evidence.sent - 1;
    if (code_in(ended) == code::frame_written) {
        ++frame_;
        failures_ = 0;
        return ask_frame(now);
    }
    ++repeats_;
    if (++failures_ == max_failures)
        return give_up(Ending::failed, "the device could not write frame " + std::to_string(frame_), ended.evidence, now);
    ask_frame(now);
}

void Firmware::give_up(Ending ending, const std::string& what, const Evidence& evidence, TimePoint now) {
    finish({ending, what + std::string{half_done()}, evidence}, now);
}

void Firmware::cancel(TimePoint now) {
    give_up(Ending::cancelled, erasing_ ? "cancelled" : "cancelled, nothing was changed", {}, now);
}

}    // namespace ano::host
