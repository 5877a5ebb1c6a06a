// The base of all simulated devices: a device of the library, telemetry at its rates, and a world that is simulated in steps of
// equal length. No I/O and no clock: it receives frames and a time, and returns frames. The same seed and the same frames at the
// same times give the same bytes, no matter how often run() is called.
#pragma once
#include "chinese_texts.hpp"
#include "device_forms.hpp"
#include "fill.hpp"
#include "noise.hpp"

#include <ano/address.hpp>
#include <ano/attitude.hpp>
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
    std::uint8_t id = 0;       // 0: the default id of its kind
    unsigned hz = 50;          // attitude and inertial frames per second, 1 to 100; slower telemetry is scaled with it
    std::uint64_t seed = 1;    // for sensors, noise and weather
    ParameterForm parameters = ParameterForm::typed;
    TextForm texts = TextForm::en;
    ByteOrder firmware = ByteOrder::little;    // device::Profile::firmware_order
    bool any_address = false;                  // accepts frames to every address, as the oldest devices do
    EulerSigns euler{};                        // lx: sends pitch and yaw of 0x03 with the opposite sign
};

class SimulatedDevice {
public:
    /// Called with the bytes of one frame and the time at which it was sent: in the past if run() is called late.
    using Send = std::function<void(Bytes, TimePoint)>;
    static constexpr std::chrono::milliseconds step{5};
    /// After a longer pause between calls of run(), the simulation continues from its last state without catching up.
    static constexpr std::chrono::seconds max_pause{5};

    virtual ~SimulatedDevice() = default;
    SimulatedDevice(const SimulatedDevice&) = delete;
    SimulatedDevice& operator=(const SimulatedDevice&) = delete;

    /// Whether its frames are those of the previous protocol version (ano/v7.hpp).
    virtual bool uses_v7() const noexcept { return false; }
    /// A valid frame that arrived, to any destination. A device that uses V7 ignores it.
    void take(FrameView frame, TimePoint now, const Send& send);
    /// Bytes that arrived together: a frame of the device's protocol, or one that was damaged.
    virtual void receive(Bytes bytes, TimePoint now, const Send& send);
    /// Sends all frames that are due at `now`.
    void run(TimePoint now, const Send& send);
    TimePoint due() const noexcept;
    /// Called by run() first: if `now` is more than max_pause after the last call, the simulation continues from `now`.
    void notice_pause(TimePoint now) noexcept;

    /// As after a power failure: the parameters get the values that were stored last.
    virtual void restart();

    device::Device& device() noexcept { return device_; }
    /// Its hardware id in V8.
    std::uint8_t id() const noexcept { return device_.info().id; }

protected:
    SimulatedDevice(device::Info info, const Settings& settings, TimePoint start);

    static constexpr double dt = 0.005;    // s, length of a step
    /// Simulated time since the start, s.
    double time() const noexcept { return static_cast<double>(steps_) * dt; }
    unsigned hz() const noexcept { return hz_; }
    Noise& chance() noexcept { return chance_; }
    EulerSigns euler_signs() const noexcept { return euler_; }

    /// Calls `emit` once in every `period`, first with the first step.
    void every(Duration period, std::function<void()> emit) { streams_.push_back({period, Duration::zero(), std::move(emit)}); }
    /// The period of a rate of `hz` per second; 0 counts as 1.
    static Duration at_rate(unsigned hz) noexcept { return Duration{std::chrono::seconds{1}} / std::max(hz, 1u); }
    /// Sends a message to the hosts; to be called in advance(), in heard() and in functions passed to every().
    template <Name M, Name Label>
    void emit(const Draft<M, Label>& draft) {
        std::array<std::uint8_t, overhead + device::max_sent> frame;
        const std::size_t size = draft.encode(frame, device_.info().id, address::host);
        if (size != 0) emit_bytes(std::span{frame}.first(size));
    }
    /// Sends the bytes of one frame; may be called where emit() may.
    void emit_bytes(Bytes frame) { (*send_)(frame, now_); }
    /// Carries out what is due, then calls `handle`, which may call emit_bytes().
    void handle_at(TimePoint now, const Send& send, const std::function<void()>& handle);
    /// Sends a flexible message.
    void emit_flexible(std::uint8_t id, std::span<const std::uint8_t> data);

    /// Stores the values of all parameters, like a device in its flash; returns true.
    bool store_values();
    /// Simulates one step.
    virtual void advance() = 0;
    /// Called with the frames that the library's device does not handle, such as the sticks.
    virtual void heard(FrameView) {}
    /// Whether it accepts a firmware image now.
    virtual bool may_be_upgraded() const { return true; }

private:
    struct Stream {
        Duration period, next;
        std::function<void()> emit;
    };
    TimePoint time_of_step(std::uint64_t n) const noexcept { return start_ + static_cast<std::int64_t>(n) * Duration{step}; }
    void run_step();
    void allow_images();
    void let_go(TimePoint at);
    bool is_ours(FrameView frame) const noexcept;

    device::Device device_;
    ChineseTexts texts_;
    unsigned hz_;
    EulerSigns euler_;
    Noise chance_;
    TimePoint start_;
    std::uint64_t steps_ = 0;
    std::vector<Stream> streams_;
    std::vector<device::Value> stored_;    // empty: the defaults
    const Send* send_ = nullptr;           // set during a call
    TimePoint now_;
};

}    // namespace ano::world
