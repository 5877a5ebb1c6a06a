// What of a recording is said again, and when. No I/O.
#pragma once
#include <ano/time.hpp>
#include <record/recording.hpp>

#include <cstdint>

namespace anogate {

/// A host said it, or it commands or changes a vehicle, or is a tunnel frame that may bring such a frame: a replay must not start a vehicle.
bool may_command(ano::FrameView frame) noexcept;

/// When each frame is due. By the clock that nobody sets, where the recording has it: otherwise by the other one, which may have been
/// set: what is earlier than the frame before is due with it.
class ReplayClock {
public:
    /// `rate` times as fast as it was; greater than 0.
    explicit ReplayClock(double rate) noexcept : rate_{rate} {}

    /// Since the first frame; of each frame once, in their order.
    ano::Duration due(const RecordedFrame& frame) noexcept;

private:
    double rate_;
    std::uint64_t last_time_ = 0, last_boottime_ = 0;
    bool begun_ = false;
    std::uint64_t elapsed_ns_ = 0;    // at rate 1
};

}    // namespace anogate
