#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <host/firmware.hpp>
#include <host/parameter_info.hpp>

#include <algorithm>
#include <array>
#include <utility>

namespace ano::host {
namespace {

using namespace std::chrono_literals;
namespace code = firmware_code;

constexpr std::array<FaultId<>, 5> step_ids{"device_info", "image_description", "erasing", "sending", "image_check"};

// A frame is written to flash before it is answered, which takes longer than the questions with which the round trip was
// measured.
constexpr Duration write_time = 100ms;

// The upgrade does not start without an answer to its info; a bad line may lose several.
constexpr unsigned info_sends = 8;

// Sends of the info between two questions that check whether the device answers at all. The info is repeated longer than these
// take.
constexpr unsigned info_sends_before_probe = 2;
constexpr Patience for_probe{.sends = 1, .wait = 1s};

// A loader that receives "erase" twice may start it again after the first one ends, and erase what was written since: after this
// time it has ended in any case. "All sent" has no such effect, but the check takes time.
constexpr Patience for_erase{.sends = 1, .wait = 60s}, for_check{.sends = 1, .wait = 15s},
    for_check_again{.sends = 5, .wait = 3s};

// A device that sends other frames is not busy erasing: "erased" was lost.
constexpr Patience for_first_erases{.sends = 1, .wait = 60s, .if_heard = 5s};
constexpr unsigned first_erases = 2;

// Sent in both byte orders alternately: "refused" reads the same in both.
constexpr Patience for_tried_erase{.sends = 1, .wait = 5s};

}    // namespace

Firmware::Firmware(Device& device, FirmwareImage image, FirmwareOptions options)
    : Task{device}, image_{std::move(image)}, options_{std::move(options)} {
    options_.frame_len = std::max<std::size_t>(options_.frame_len, 1);
}

std::string_view Firmware::step() const noexcept { return step_ids[step_].row->english; }

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
    if (image_.bytes.empty()) return finish({Ending::invalid, {"image_empty"}, {}}, now);
    if (frames() > max_frames) return finish({Ending::invalid, {"image_too_long", options_.frame_len}, {}}, now);
    ask(question::device_info(identify), now);
}

void Firmware::identified(const Ended& ended, TimePoint now) {
    renew_identity();
    const auto& info = device().info() ? device().info() : options_.info;
    if (!options_.force && !image_.is_for_any_hardware()) {
        if (!info) return finish_without_info({step_ids[step_]}, ended.evidence, now);
        if (Fault misfit = image_.misfit(*info); !misfit.empty()) return finish({Ending::invalid, std::move(misfit), {}}, now);
    }
    ask_info(Purpose::begin, options_.frame_len, now);
}

void Firmware::ask_info(Purpose purpose, std::size_t frame_len, TimePoint now) {
    step_ = describe;
    purpose_ = purpose;
    asked_len_ = frame_len;
    described_since_ = now;
    infos_ = 0;
    is_refused_ = false;
    send_info(now);
}

void Firmware::send_info(TimePoint now) {
    Draft<"firmware", "info"> draft;
    (void)draft.set<"bin_len">(image_.bytes.size());
    (void)draft.set<"frame_len">(asked_len_);
    (void)draft.set<"bin_crc">(image_.crc);
    (void)draft.set<"bin_ver">(image_.version);
    (void)draft.set<"hw_type">(image_.hw_type);
    (void)draft.set<"hw_ver_min">(image_.hw_ver_min);
    (void)draft.set<"hw_ver_max">(image_.hw_ver_max);
    (void)draft.set<"cmd">(image_.cmd);
    const unsigned sends = purpose_ == Purpose::begin ? info_sends_before_probe : info_sends;
    ask(request(draft, describe, {.sends = sends, .at_least = write_time}), now);
}

// If two questions in a row are answered and the info between them is not, the device is not restarting now and was not when it
// received that info.
void Firmware::probed(bool answers, const Ended& ended, TimePoint now) {
    const bool answered_before = std::exchange(answers_probes_, answers);
    if (!answers || !answered_before || now - described_since_ < loader_patience) return send_info(now);
    finish({Ending::unsupported, {"no_loader", hex_of(device().address())}, ended.evidence}, now);
}

// Sends "erase" or "all sent".
void Firmware::ask_order(Step step, TimePoint now) {
    if (step_ != step) orders_ = 0;
    step_ = step;
    ++orders_;
    const auto draft = firmware_step(step == erase ? code::erase : code::all_sent, order_);
    const auto& erases = is_tried() ? for_tried_erase : orders_ <= first_erases ? for_first_erases : for_erase;
    ask(request(draft, step, step == erase ? erases : orders_ == 1 ? for_check : for_check_again), now);
}

void Firmware::ask_frame(TimePoint now) {
    if (frame_ == frames()) return ask_order(check, now);
    step_ = send_frame;
    const std::size_t at = frame_ * options_.frame_len;
    piece_.resize(std::min(options_.frame_len, image_.bytes.size() - at));
    if (!image_.bytes.read(at, piece_)) return abandon(Ending::failed, {"file_gone"}, {}, now);
    Draft<"firmware", "image"> draft;
    (void)draft.set<"frame_num">(frame_);
    (void)draft.set<"data">(Bytes{piece_});
    asked_at_ = now;
    ask(request(draft, send_frame, patience_of_frame()), now);
}

// On a bad line nearly every frame is repeated, and the round trip can't be measured any more: then the time of a frame that was
// sent once is used. Now and then one frame gets a longer wait, in case frames take longer now.
Patience Firmware::patience_of_frame() const noexcept {
    if (!frame_wait_) return {.sends = 2, .at_least = write_time};
    if (repeated_in_a_row_ == repeated_enough) return {.sends = 2, .wait = RoundTrip::ceiling};
    return {.wait = frame_wait_};
}

void Firmware::measure(const Evidence& evidence, bool answered, TimePoint now) {
    repeats_ += evidence.sent - (answered ? 1 : 0);
    sends_ += evidence.sent;
    if (!answered || evidence.sent > 1) {
        repeated_in_a_row_ = repeated_in_a_row_ == repeated_enough ? 0 : repeated_in_a_row_ + 1;
        return;
    }
    repeated_in_a_row_ = 0;
    frame_wait_ = std::clamp(2 * (now - asked_at_), write_time, RoundTrip::ceiling);
}

void Firmware::not_meant(const Ended&, TimePoint now) {
    finish_another({}, now, erasing_ ? Fault{"previous_in_loader"} : Fault{});
}

void Firmware::on_unfit_answer(FrameView frame) {
    odd_reply_ = hex_of(device().address()) + " sent 0xF0 with " + spaced_hex(frame.data()) + ", which is not a valid answer";
}

void Firmware::ended(const Ended& ended, TimePoint now) {
    if (ended.outcome == Outcome::answered) odd_reply_.clear();
    if (ended.tag == identify) return identified(ended, now);
    if (ended.tag == probe) return probed(ended.outcome == Outcome::answered, ended, now);
    if (ended.outcome != Outcome::answered) return unanswered(ended, now);
    answered_at_ = now;
    const FirmwareCode answer = firmware_code_in(*ended.answer).value_or(FirmwareCode{});
    switch (ended.tag) {
    case describe: return described(answer, ended, now);
    case erase: return erased(answer, ended, now);
    case send_frame: return frame_ended(answer.code, ended, now);
    default:
        if (answer.code == code::check_failed) return check_failed(ended.evidence, now);
        finish({Ending::done, remark_, ended.evidence}, now);
    }
}

// `answer`: std::nullopt: none. A device that refuses a second info keeps the one it accepted before.
void Firmware::described(std::optional<FirmwareCode> answer, const Ended& ended, TimePoint now) {
    const bool accepted = answer && answer->code == code::info_accepted;
    infos_ += ended.evidence.sent;
    const bool may_restart = !answer && purpose_ != Purpose::shorten && ended.evidence.unfit.empty();
    if (may_restart && now - described_since_ < patience) {
        if (purpose_ != Purpose::begin) return send_info(now);
        Request any = question::device_info(probe);
        any.patience = for_probe;
        return ask(any, now);
    }
    if (!accepted && purpose_ == Purpose::shorten) {
        may_shorten_ = false;
        return ask_frame(now);
    }
    const bool is_begun_again = purpose_ == Purpose::begin_again || purpose_ == Purpose::begin_after_check;
    if (!answer && is_begun_again) return abandon(lost_ending_, lost_because_, ended.evidence, now);
    if (!answer) return abandon(Ending::timeout, silence(ended.evidence), ended.evidence, now);
    if (!accepted) {
        is_refused_ = true;
        const bool fits = !options_.force && !image_.is_for_any_hardware();    // identified() has compared them
        return (infos_ > 1 && fits) || is_begun_again ? begin_erasing(now) : refused(ended.evidence, now);
    }
    order_ = answer->order;
    if (purpose_ == Purpose::shorten) remark_.add({"shorter_frames", asked_len_});
    if (purpose_ == Purpose::begin_again) remark_.add({"begun_again", frame_, hex_of(device().address())});
    if (purpose_ == Purpose::begin_after_check) remark_.add({"begun_again_shorter", asked_len_, lost_because_});
    options_.frame_len = asked_len_;
    erasing_ = true;
    begin_erasing(now);
}

void Firmware::begin_erasing(TimePoint now) {
    frame_wait_.reset();
    frame_ = failures_ = sends_ = judged_frames_ = judged_sends_ = 0;
    ask_order(erase, now);
}

void Firmware::refused(const Evidence& evidence, TimePoint now) {
    if (purpose_ != Purpose::begin) return abandon(lost_ending_, {"not_accepted_again", lost_because_}, evidence, now);
    const std::string who = hex_of(device().address());
    const bool is_first = infos_ == 1 || step_ != describe;
    finish({Ending::refused, is_first ? Fault{"image_refused", who} : Fault{"image_refused_again", who}, evidence}, now);
}

void Firmware::erased(const FirmwareCode& answer, const Ended& ended, TimePoint now) {
    if (answer.code == code::erase_failed && is_refused_) return refused(ended.evidence, now);
    if (answer.code == code::erase_failed) return abandon(Ending::failed, {"erase_failed"}, ended.evidence, now);
    if (is_refused_) order_ = answer.order;
    erasing_ = true;
    frames_since_ = now;
    ask_frame(now);
}

void Firmware::check_failed(const Evidence& evidence, TimePoint now) {
    lost_because_ = {"image_check_failed"};
    lost_ending_ = Ending::failed;
    if (repeats_ == 0 || checks_failed_ == max_checks_failed) return abandon(lost_ending_, lost_because_, evidence, now);
    ++checks_failed_;
    const std::size_t shortest = std::min(options_.frame_len, least_len);
    ask_info(Purpose::begin_after_check, frames_of(shortest) <= max_frames ? shortest : options_.frame_len, now);
}

void Firmware::frame_ended(std::uint16_t answer, const Ended& ended, TimePoint now) {
    measure(ended.evidence, true, now);
    if (answer == code::frame_written) {
        ++frame_;
        // A second info discards the written frames, so late in an upgrade it is not worthwhile.
        const std::size_t shorter = shorter_len();
        const bool pays = is_hard() && may_shorten_ && shorter < options_.frame_len && 2 * frame_ < frames();
        failures_ = sends_ = 0;
        return pays ? ask_info(Purpose::shorten, shorter, now) : ask_frame(now);
    }
    ++repeats_;
    if (++failures_ < max_failures) return ask_frame(now);
    begin_again({"frame_not_written", frame_}, Ending::failed, ended.evidence, now);
}

bool Firmware::is_hard() noexcept {
    judged_sends_ += std::min(sends_, most_sends);
    if (++judged_frames_ < judged) return false;
    judged_frames_ = 0;
    return std::exchange(judged_sends_, 0u) >= hard;
}

std::size_t Firmware::shorter_len() const noexcept {
    const std::size_t len = std::min(options_.frame_len, std::max(options_.frame_len / 3, least_len));
    return frames_of(len) <= max_frames ? len : options_.frame_len;
}

void Firmware::unanswered(const Ended& ended, TimePoint now) {
    if (ended.tag == send_frame) return frame_unanswered(ended, now);
    if (ended.tag == describe) return described(std::nullopt, ended, now);
    if (ended.tag == check) return check_unanswered(ended, now);
    if (is_tried()) order_ = order_ == ByteOrder::little ? ByteOrder::big : ByteOrder::little;
    if (orders_ < max_erases) return ask_order(erase, now);
    if (is_refused_) return refused(ended.evidence, now);
    abandon(Ending::timeout, silence(ended.evidence), ended.evidence, now);
}

void Firmware::check_unanswered(const Ended& ended, TimePoint now) {
    if (orders_ < 2) return ask_order(check, now);
    if (!ended.evidence.unfit.empty()) return abandon(Ending::timeout, silence(ended.evidence), ended.evidence, now);
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(check_patience).count();
    finish({Ending::timeout, {"image_not_reported", hex_of(device().address()), frames(), seconds}, ended.evidence}, now);
}

void Firmware::frame_unanswered(const Ended& ended, TimePoint now) {
    measure(ended.evidence, false, now);
    // The answer to the question for its device info does not count.
    const bool is_heard = device().heard_at() && *device().heard_at() > std::max(answered_at_, device().identified_at());
    if (now - answered_at_ < (is_heard ? patience : patience_unheard)) return ask_frame(now);
    begin_again(silence(ended.evidence), Ending::timeout, ended.evidence, now);
}

// If even the first frame is never received, shorter ones may be.
void Firmware::begin_again(const Fault& why, Ending or_else, const Evidence& evidence, TimePoint now) {
    if (lost_frame_ == frame_ || restarts_ == max_restarts) return abandon(or_else, why, evidence, now);
    lost_frame_ = frame_;
    lost_because_ = why;
    lost_ending_ = or_else;
    ++restarts_;
    device().doubt();
    ask_info(Purpose::begin_again, frame_ == 0 && or_else == Ending::timeout ? shorter_len() : options_.frame_len, now);
}

// Why there is no answer. "Stopped answering" only if no frame of the device was received.
Fault Firmware::silence(const Evidence& evidence) const {
    const std::string who = hex_of(device().address());
    const Fault doing{step_ids[step_]};
    if (!evidence.unfit.empty()) return {"invalid_answer", who, spaced_hex(evidence.unfit), doing};
    return evidence.is_heard ? Fault{"online_but_silent", who, doing} : Fault{"stopped_answering", who, doing};
}

void Firmware::abandon(Ending ending, Fault fault, const Evidence& evidence, TimePoint now) {
    finish({ending, std::move(fault.add(half_done())), evidence}, now);
}

void Firmware::cancel(TimePoint now) {
    abandon(Ending::cancelled, erasing_ || step_ == erase ? Fault{"cancelled"} : Fault{"nothing_changed"}, {}, now);
}

}    // namespace ano::host
