#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <link/feed.hpp>
#include <link/make_link.hpp>
#include <link/sim_link.hpp>
#include <link/sim_settings.hpp>

#include <array>
#include <utility>

namespace anogate {

SimLink::SimLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      fc_{this->settings().as<SimSettings>().hz, Clock::now()},
      tick_{context.alarms, [this] { tick(); }},
      answer_{context.alarms, [this] { answer(); }} {}

void SimLink::start() {
    channel_ = context_.host.open_channel(*this, settings().as<SimSettings>().device);
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
        fc_.receive(ano::FrameView{next[0]}, context_.host.now(), [this](ano::FrameView answer) {
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

namespace {

using namespace key_rows;

constexpr Key<LinkSettings> sim_keys[] = {
    choice<own<SimSettings>, &SimSettings::device>("device", "fc", "the device to simulate") | needed,
    integer<own<SimSettings>, &SimSettings::hz>("hz", 1, 100, "attitude frames a second; slower ones keep their proportion"),
};

}    // namespace

extern const LinkKind sim_kind;    // listed in kinds.cpp
constinit const LinkKind sim_kind{
    .name = "sim",
    .address = "device",
    .example = "fc",
    .help = "a simulated flight controller (0xDC) inside the process: demo, tests, development",
    .carries = Carries::pieces,
    .devices_only = true,
    .keys = sim_keys,
    .settings = [] { return KindSettings{SimSettings{}}; },
    .make = make_link_of<SimLink>,
    .usual_name = [](const LinkSettings& link) { return link.as<SimSettings>().device; },
};

}    // namespace anogate
