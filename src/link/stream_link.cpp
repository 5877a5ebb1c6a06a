#include <link/stream_link.hpp>

namespace anogate {

StreamLink::StreamLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)}, StreamSession{context}, reconnect_{context, *this, [this]() -> Opened<void> {
                                                                            auto wire = open_wire();
                                                                            if (!wire) return NotOpened{std::move(wire.error())};
                                                                            open(std::move(*wire), *channel_);
                                                                            return {};
                                                                        }} {}

void StreamLink::start() {
    channel_ = context_.host.open_channel(*this, peer());
    reconnect_.start();
}

void StreamLink::opened() {
    reconnect_.came_up(context_.host.now());
    pacing().start(settings().rate != 0 ? settings().rate : line_rate(), settings().latency, settings().gap);
    resume_reading();
    came_up();
}

void StreamLink::stop_reading() {
    pause_reading();
    reconnect_.stop();
}

void StreamLink::stop() {
    reconnect_.stop();
    if (is_open()) leave_wire(fd());
    close();
}

void StreamLink::fail(LinkError why) {
    leave_wire(fd());
    close();
    end_of_input();
    reconnect_.lost(std::move(why));
}

}    // namespace anogate
