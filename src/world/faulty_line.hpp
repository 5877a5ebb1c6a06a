// A bad day on demand: what is lost, late, doubled or damaged between a simulated device and who talks to it, and a device that is
// slow or deaf. The same seed, the same faults.
#pragma once
#include "noise.hpp"
#include "simulated_device.hpp"

#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace ano::world {

/// Of each frame, both ways; the last two of what the device hears alone.
struct Faults {
    unsigned loss = 0;         // %
    unsigned duplicate = 0;    // %
    unsigned corrupt = 0;      // %, of which one bit is another one
    Duration delay{};
    Duration jitter{};                       // up to so much more, so that one may overtake another
    std::optional<Duration> deaf_after{};    // since the start: from then on it hears nothing
    Duration slow{};                         // it takes so long over each frame; further ones wait, 20 of them

    bool is_none() const noexcept {
        return !(loss || duplicate || corrupt || delay.count() || jitter.count() || deaf_after || slow.count());
    }
};

struct FaultCounters {
    std::uint64_t lost = 0, doubled = 0, damaged = 0;
    std::uint64_t unheard = 0;    // for `deaf_after`, or because too many waited for a slow device
};

/// A simulated device behind such a line. As the device: the same bytes, however often run() is called.
class FaultyLine {
public:
    /// Bytes that arrive, a frame as a rule: damaged ones are none. And when.
    using Send = std::function<void(Bytes, TimePoint)>;
    static constexpr std::size_t max_waiting = 20;        // as devices in the field queue
    static constexpr std::size_t max_passing = 20'000;    // frames under way; further ones are lost

    FaultyLine(std::unique_ptr<SimulatedDevice> device, const Faults& faults, std::uint64_t seed, TimePoint start);

    void take(FrameView frame, TimePoint now, const Send& send);
    void run(TimePoint now, const Send& send);
    TimePoint due() const noexcept;

    SimulatedDevice& device() noexcept { return *device_; }
    const FaultCounters& counters() const noexcept { return counters_; }

private:
    enum class Way : std::uint8_t { to_host, to_device, to_slow_device };
    struct Passing {
        Way way;
        std::vector<std::uint8_t> bytes;
    };

    void put(Bytes frame, Way way, TimePoint at, Noise& chance);
    void arrive(const Passing& passing, TimePoint at, const Send& send);
    void wait_for_slow_device(const Passing& passing, TimePoint at);
    void hear(Bytes bytes, TimePoint at);

    std::unique_ptr<SimulatedDevice> device_;
    Faults faults_;
    Noise there_, back_;    // of each way, so that one does not depend on the other
    TimePoint start_;
    std::multimap<TimePoint, Passing> passing_;
    TimePoint busy_until_{};
    std::size_t waiting_ = 0;
    FaultCounters counters_;
    const SimulatedDevice::Send say_ = [this](FrameView frame, TimePoint at) { put(frame.bytes(), Way::to_host, at, back_); };
};

}    // namespace ano::world
