// The properties of a frame by which the loop guard judges it.
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/claims.hpp>
#include <gateway/frame_key.hpp>
#include <gateway/queue_policy.hpp>

#include <cstdint>

namespace anogate {

/// What the loop guard must know of a frame.
struct Said {
    std::uint64_t key;        // frame_key()
    bool by_host;             // other hosts may send the same bytes
    bool state = false;       // a newer one of its kind replaces it: sticks, telemetry
    bool to_all = false;      // a broadcast
    bool command = false;     // not a state; sent by a host, or urgent
    bool waited = false;      // it was judged `waits`, and has waited
    bool hurried = false;     // its wait ended because the channel brought more of the same
    bool replayed = false;    // from a recording: its sender may send the same bytes now
    Speaks speaks = Speaks::somewhere;
    ano::TimePoint arrived = ano::TimePoint::max();    // set if it waited to be read; otherwise it arrived when it is judged
};
/// `key` is frame_key(frame).
inline Said said_by(ano::FrameView frame, std::uint64_t key) noexcept {
    const QueuePolicy policy = policy_of(frame.id());
    const bool host = ano::address::is_host(frame.source()), state = policy.replaces != Replaces::nothing;
    return {.key = key,
            .by_host = host,
            .state = state,
            .to_all = frame.destination() == ano::address::broadcast,
            .command = !state && (host || policy.traffic == TrafficClass::urgent)};
}
inline Said said_by(ano::FrameView frame) noexcept { return said_by(frame, frame_key(frame)); }

}    // namespace anogate
