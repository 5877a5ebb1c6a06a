// Simulates faults: frames that are lost, delayed, duplicated or corrupted between a simulated device and its peers, and a device
// that is slow or stops receiving. The same seed gives the same faults.
#pragma once
#include "noise.hpp"
#include "simulated_device.hpp"
#include "vendor_parser.hpp"

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

/// The faults up to `jitter` apply to each frame in both directions, the others only to frames to the device. A restart affects
/// both.
struct Faults {
    unsigned loss = 0;         // %
    unsigned duplicate = 0;    // %
    unsigned corrupt = 0;      // %, with one wrong bit
    Duration delay{};
    Duration jitter{};                          // maximum of a random additional delay; it may reorder frames
    std::optional<Duration> deaf_after{};       // since the start: from then on the device receives nothing
    std::optional<Duration> restart_after{};    // since the start: then it restarts once, silent for FaultyLine::time_to_restart
    Duration slow{};                            // processing time of each frame; up to 20 further frames wait
    bool one_at_a_time = false;    // no frame waits: frames that arrive while it is busy are lost, as if sending blocked it
    bool vendor_parser = false;    // it has the vendor's parser, which a damaged LEN blocks

    bool is_none() const noexcept {
        return !(loss || duplicate || corrupt || delay.count() || jitter.count() || deaf_after || restart_after || slow.count() ||
                 vendor_parser);
    }
};

struct FaultCounters {
    std::uint64_t lost = 0, doubled = 0, damaged = 0;
    std::uint64_t unheard = 0;    // lost because of `deaf_after` or a restart, or because too many waited for a slow device
};

/// A simulated device behind such a line. Like the device itself, it sends the same bytes, no matter how often run() is called.
class FaultyLine {
public:
    /// Called with bytes that arrive, and the time. They are one frame, unless they are corrupted.
    using Send = std::function<void(Bytes, TimePoint)>;
    static constexpr std::size_t max_waiting = 20;    // as many as real devices queue
    static constexpr std::chrono::seconds time_to_restart{1};
    static constexpr std::size_t max_passing = 20'000;    // frames under way; further ones are lost

    FaultyLine(std::unique_ptr<SimulatedDevice> device, const Faults& faults, std::uint64_t seed, TimePoint start);

    void take(FrameView frame, TimePoint now, const Send& send) { take(frame.bytes(), now, send); }
    /// The same for bytes that are not a frame.
    void take(Bytes bytes, TimePoint now, const Send& send);
    void run(TimePoint now, const Send& send);
    TimePoint due() const noexcept;

    SimulatedDevice& device() noexcept { return *device_; }
    const FaultCounters& counters() const noexcept { return counters_; }

private:
    enum class Direction : std::uint8_t { to_host, to_device, to_slow_device };
    struct Passing {
        Direction way;
        std::vector<std::uint8_t> bytes;
    };

    void put(Bytes frame, Direction way, TimePoint at, Noise& chance);
    void arrive(const Passing& passing, TimePoint at, const Send& send);
    void wait_for_slow_device(const Passing& passing, TimePoint at);
    void receive(Bytes bytes, TimePoint at);
    void emit(Bytes frame, TimePoint at);
    void restart_if_due(TimePoint at);
    bool is_restarting(TimePoint at) const noexcept;

    std::unique_ptr<SimulatedDevice> device_;
    Faults faults_;
    Noise there_, back_;    // one for each direction, so that they are independent
    TimePoint start_;
    std::multimap<TimePoint, Passing> passing_;
    TimePoint busy_until_{};
    std::size_t waiting_ = 0;
    VendorParser parser_;
    FaultCounters counters_;
    bool has_restarted_ = false;
    const SimulatedDevice::Send emit_ = [this](Bytes frame, TimePoint at) { emit(frame, at); };
};

}    // namespace ano::world
