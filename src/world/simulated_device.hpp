// What all simulated devices are: a device of the library, telemetry at its rates, and a world that goes on in steps of one length.
// No I/O and no clock: frames and a time in, frames out. The same seed, the same frames at the same times: the same bytes, however
// often run() is called.
#pragma once
#include "fill.hpp"
#include "noise.hpp"

#include <ano/address.hpp>
#include <ano/time.hpp>
#include <device/device.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace ano::world {

struct Settings {
    std::uint8_t id = 0;       // 0: the usual one of its kind
    unsigned hz = 50;          // attitude and inertial frames a second, 1 to 100; slower ones keep their proportion
    std::uint64_t seed = 1;    // of its sensors, noise and weather
};

class SimulatedDevice {
public:
    /// A frame, and when it was said: in the past where run() comes late.
    using Send = std::function<void(FrameView, TimePoint)>;
    static constexpr std::chrono::milliseconds step{5};
    /// After a longer pause the world goes on from where it was: nothing is made up for.
    static constexpr std::chrono::seconds max_pause{5};

    virtual ~SimulatedDevice() = default;
    SimulatedDevice(const SimulatedDevice&) = delete;
    SimulatedDevice& operator=(const SimulatedDevice&) = delete;

    /// A good frame came in, for whomever.
    void take(FrameView frame, TimePoint now, const Send& send);
    /// Says all that is due at `now`.
    void run(TimePoint now, const Send& send);
    TimePoint due() const noexcept;
    /// run() does it first: where `now` is long after it was called last, the world goes on from here.
    void notice_pause(TimePoint now) noexcept;

    device::Device& device() noexcept { return device_; }

protected:
    SimulatedDevice(device::Info info, const Settings& settings, TimePoint start);

    static constexpr double dt = 0.005;    // s, of a step
    /// s, since it was started.
    double time() const noexcept { return static_cast<double>(steps_) * dt; }
    unsigned hz() const noexcept { return hz_; }
    Noise& chance() noexcept { return chance_; }

    /// Every so often; first with the first step.
    void every(Duration period, std::function<void()> say) { streams_.push_back({period, Duration::zero(), std::move(say)}); }
    /// `hz` times a second; once where that is less.
    static Duration at_rate(unsigned hz) noexcept { return Duration{std::chrono::seconds{1}} / std::max(hz, 1u); }
    /// To the hosts, now: in advance(), heard() and in what every() does.
    template <Name M, Name Label>
    void say(const Draft<M, Label>& draft) {
        std::array<std::uint8_t, overhead + device::max_sent> frame;
        const std::size_t size = draft.encode(frame, device_.info().id, address::host);
        if (size != 0) (*send_)(FrameView{std::span{frame}.first(size)}, now_);
    }
    /// One of the messages that the user lays out.
    void say_flexible(std::uint8_t id, std::span<const std::uint8_t> data);

    /// The world goes on by one step.
    virtual void advance() = 0;
    /// What is no question to the device: the sticks, for instance.
    virtual void heard(FrameView) {}
    /// Whether it takes an image now.
    virtual bool may_be_upgraded() const { return true; }

private:
    struct Stream {
        Duration period, next;
        std::function<void()> say;
    };
    TimePoint time_of_step(std::uint64_t n) const noexcept { return start_ + static_cast<std::int64_t>(n) * Duration{step}; }
    void take_step();
    void allow_images();
    void let_go(TimePoint at);
    bool is_ours(FrameView frame) const noexcept;

    device::Device device_;
    unsigned hz_;
    Noise chance_;
    TimePoint start_;
    std::uint64_t steps_ = 0;
    std::vector<Stream> streams_;
    const Send* send_ = nullptr;    // during a call
    TimePoint now_;
};

}    // namespace ano::world
