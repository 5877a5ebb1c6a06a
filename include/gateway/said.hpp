// What tells of a frame whether it may come round.
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <gateway/claims.hpp>
#include <gateway/frame_key.hpp>
#include <gateway/queue_policy.hpp>

#include <cstdint>

namespace anogate {

/// What the guard has to know of a frame.
struct Said {
    std::uint64_t key;        // frame_key()
    bool by_host;             // others may say the very same
    bool state = false;       // a newer one of its kind replaces it: sticks, telemetry
    bool to_all = false;      // everybody is meant
    bool command = false;     // of a host, or what hosts say
    bool waited = false;      // it was told to wait, and did,
    bool hurried = false;     // until the channel brought the next of the same
    bool replayed = false;    // it was said once: who said it may say the very same now
    Speaks speaks = Speaks::somewhere;
    ano::TimePoint arrived = ano::TimePoint::max();    // where it waited to be read; else it arrived when it is judged
};
/// `key`: its frame_key().
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
