#include "simulated_device.hpp"

#include <algorithm>
#include <utility>

namespace ano::world {
namespace {

device::Profile profile_of(const Settings& settings) {
    device::Profile profile;
    profile.old_layouts = settings.parameters == ParameterForm::minmax;
    profile.scaled_values = settings.parameters == ParameterForm::scaled;
    profile.firmware_order = settings.firmware;
    profile.any_address = settings.any_address;
    return profile;
}

}    // namespace

SimulatedDevice::SimulatedDevice(device::Info info, const Settings& settings, TimePoint start)
    : device_{std::move(info), profile_of(settings)},
      texts_{settings.texts},
      hz_{settings.hz},
      euler_{settings.euler},
      chance_{settings.seed},
      start_{start},
      now_{start} {
    allow_images();
}

// An image is accepted and reported as installed, but has no effect.
void SimulatedDevice::allow_images() {
    using namespace std::chrono_literals;
    device::Flash flash;
    flash.max_size = std::size_t{1} << 20;
    flash.accept = [this](const device::ImageInfo&) { return may_be_upgraded(); };
    flash.install = [this](const device::Image&) {
        device_.log("new firmware", device::LogColor::green);
        return true;
    };
    flash.erase_time = 1s;
    flash.check_time = 200ms;
    device_.firmware().allow(std::move(flash));
}

void SimulatedDevice::take(FrameView frame, TimePoint now, const Send& send) {
    if (uses_v7()) return;
    handle_at(now, send, [&] {
        device_.take(frame, now_);
        if (is_ours(frame)) heard(frame);
        let_go(now_);
    });
}

void SimulatedDevice::receive(Bytes bytes, TimePoint now, const Send& send) {
    const auto frame = frame_at(bytes);
    if (frame && frame->bytes().size() == bytes.size()) take(*frame, now, send);
}

void SimulatedDevice::handle_at(TimePoint now, const Send& send, const std::function<void()>& handle) {
    run(now, send);
    send_ = &send;
    handle();
    send_ = nullptr;
}

bool SimulatedDevice::store_values() {
    const auto& parameters = device_.parameters();
    stored_.clear();
    for (std::size_t i = 0; i < parameters.count(); ++i) stored_.push_back(parameters[i].get());
    return true;
}

void SimulatedDevice::restart() {
    const auto& parameters = device_.parameters();
    for (std::size_t i = 0; i < parameters.count(); ++i)
        if (parameters[i].set) (void)parameters[i].set(i < stored_.size() ? stored_[i] : parameters[i].initial);
}

bool SimulatedDevice::is_ours(FrameView frame) const noexcept {
    const std::uint8_t to = frame.destination(), from = frame.source();
    return (to == device_.info().id || to == address::broadcast || device_.profile().any_address) && from != device_.info().id &&
           from != address::unassigned && from != address::broadcast;
}

// Steps and answers are carried out in the order in which they are due, even if run() is called late.
void SimulatedDevice::run(TimePoint now, const Send& send) {
    send_ = &send;
    notice_pause(now);
    for (;;) {
        const TimePoint next = time_of_step(steps_ + 1);
        const auto answer = device_.due();
        if (answer && *answer <= std::min(now, next)) {
            now_ = std::max(now_, *answer);
            device_.run(*answer);
        } else if (next <= now) {
            now_ = next;
            run_step();
        } else {
            break;
        }
        let_go(now_);
    }
    now_ = std::max(now_, now);
    send_ = nullptr;
}

void SimulatedDevice::notice_pause(TimePoint now) noexcept {
    const TimePoint last = time_of_step(steps_);
    if (now - last > max_pause) start_ += (now - last) / step * Duration{step} - Duration{step};
}

void SimulatedDevice::run_step() {
    ++steps_;
    advance();
    const Duration world = static_cast<std::int64_t>(steps_) * Duration{step};
    for (Stream& stream : streams_) {
        if (world < stream.next) continue;
        stream.emit();
        stream.next = std::max(stream.next, Duration{step}) + stream.period;
    }
}

void SimulatedDevice::let_go(TimePoint at) {
    while (const auto out = device_.next()) (*send_)(texts_.of(out->frame).bytes(), at);
}

TimePoint SimulatedDevice::due() const noexcept {
    Duration next = Duration::max();
    for (const Stream& stream : streams_) next = std::min(next, stream.next);
    const auto steps = static_cast<std::uint64_t>((next + Duration{step} - Duration{1}) / step);
    const TimePoint next_step = time_of_step(std::max(steps, steps_ + 1));
    const auto answer = device_.due();
    return answer ? std::min(next_step, *answer) : next_step;
}

void SimulatedDevice::emit_flexible(std::uint8_t id, std::span<const std::uint8_t> data) {
    std::array<std::uint8_t, overhead + device::max_sent> frame;
    const std::size_t size = encode(frame, device_.info().id, address::host, id, data);
    if (size != 0) emit_bytes(std::span{frame}.first(size));
}

}    // namespace ano::world
