#include <link/asio.hpp>
#include <link/feed.hpp>
#include <link/sim_link.hpp>

#include <array>

namespace anogate {

SimLink::SimLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)}, context_{context}, fc_{this->settings().sim.hz, Clock::now()}, tick_{context.alarms, [this] {
                                                                                                              tick();
                                                                                                          }} {}

void SimLink::start() {
    channel_ = context_.host.open_channel(*this, settings().sim.device);
    context_.host.link_up(*this);
    tick();
}

void SimLink::tick() {
    const TimePoint now = context_.host.now();
    fc_.run(now, [this](ano::FrameView frame) { say(frame); });
    deliver();
    tick_.set(fc_.next());
}

// What it says takes the way of every byte: through the parser, counted there.
void SimLink::say(ano::FrameView frame) {
    channel_->arrived_at = context_.host.now();
    feed_datagram(channel_->parser, frame.bytes(), channel_->arrived_at,
                  [this](ano::FrameView f) { context_.host.receive(*channel_, f); });
}

void SimLink::deliver() { context_.host.flush(); }

// It hears at once; its answers leave in a turn of their own, so that two devices can't call each other without end.
void SimLink::flush(Channel& channel) {
    std::array<std::span<const std::uint8_t>, 1> next;
    while (channel.outbox.gather(next, context_.host.now()) == 1) {
        fc_.receive(ano::FrameView{next[0]}, [this](ano::FrameView answer) {
            asio::post(context_.io, [this, bytes = std::vector(answer.bytes().begin(), answer.bytes().end())] {
                if (!tick_.is_set()) return;    // stopped meanwhile
                say(ano::FrameView{bytes});
                deliver();
            });
        });
        channel.outbox.sent_frame();
    }
}

}    // namespace anogate
