// The frames that wait for a judgement of the loop guard.
#include <ano/address.hpp>
#include <gateway/forwarder.hpp>

#include <utility>

namespace anogate {

// Frames of hosts keep their order, except sticks, which overtake.
bool Forwarder::keeps_order(ano::FrameView frame) noexcept {
    return ano::address::is_host(frame.source()) && policy_of(frame.id()).replaces == Replaces::nothing && !is_probe(frame);
}

bool Forwarder::hold(Channel& from, ano::FrameView brought, TimePoint due, Held::Repeats repeats) {
    return held_.put(from.id, brought, due, repeats, arrived_at_);
}

// Waiting frames go first when the next copy that they wait for has come, or when there is no room for another frame of a host,
// which must not overtake them.
void Forwarder::make_room_for(const Channel& from, ano::FrameView frame) {
    if (!releasing_ && held_.goes_on(from.id, frame, now_)) hurry(from.id);
    if (!releasing_ && keeps_order(frame) && held_.due(from.id) && !held_.fits(frame)) release_held_until(TimePoint::max());
}

void Forwarder::hurry(ChannelId from) {
    releasing_ = hurrying_ = true;
    while (const auto held = held_.take(from)) receive_held(*held);
    releasing_ = hurrying_ = false;
}

void Forwarder::receive_held(const Held::Frame& held) {
    Channel& from = *channels_[index(held.from)];
    const TimePoint latest = std::exchange(from.arrived_at, held.arrived_at);
    receive(from, held.view(), now_);
    from.arrived_at = latest;
}

void Forwarder::release_held_until(TimePoint due) {
    releasing_ = true;
    while (const auto held = held_.take(due)) receive_held(*held);
    releasing_ = false;
}

}    // namespace anogate
