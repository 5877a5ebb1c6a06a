#include <link/feed.hpp>
#include <link/sim_link.hpp>

#include <array>
#include <utility>

namespace anogate {

SimLink::SimLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      fc_{this->settings().sim.hz, Clock::now()},
      tick_{context.alarms, [this] { tick(); }},
      answer_{context.alarms, [this] { answer(); }} {}

void SimLink::start() {
    channel_ = context_.host.open_channel(*this, settings().sim.device);
    context_.host.link_up(*this);
    tick();
}

void SimLink::stop() {
    tick_.cancel();
    answer_.cancel();
}

void SimLink::tick() {
    fc_.run(context_.host.now(), [this](ano::FrameView frame) { hear(frame.bytes()); });
    context_.host.flush();
    tick_.set(fc_.next());
}

// What it says takes the way of every byte: through the parser, counted there.
void SimLink::hear(std::span<const std::uint8_t> said) {
    channel_->arrived_at = context_.host.now();
    feed_datagram(channel_->parser, said, channel_->arrived_at,
                  [this](ano::FrameView frame) { context_.host.receive(*channel_, frame); });
}

// It hears at once; its answers leave in a turn of their own, so that two devices can't call each other without end.
void SimLink::flush(Channel& channel) {
    std::array<std::span<const std::uint8_t>, 1> next;
    while (channel.outbox.gather(next, context_.host.now()) == 1) {
        fc_.receive(ano::FrameView{next[0]}, [this](ano::FrameView answer) {
            answers_.insert(answers_.end(), answer.bytes().begin(), answer.bytes().end());
        });
        channel.outbox.sent_frame();
    }
    if (!answers_.empty()) answer_.set(context_.host.now());
}

void SimLink::answer() {
    const auto answers = std::exchange(answers_, {});    // to these there may be answers again
    if (!tick_.is_set()) return;                         // stopped meanwhile
    hear(answers);
    context_.host.flush();
}

}    // namespace anogate
