#include <link/errors.hpp>
#include <link/stream_link.hpp>

#include <array>

namespace anogate {
namespace {

constexpr std::size_t frames_per_write = 64;
constexpr int reads_per_turn = 16;    // then the other links have theirs

}    // namespace

StreamLink::StreamLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      descriptor_{context.io},
      retry_{context.alarms, [this] { try_open(); }, retry_slack},
      expiry_{context.alarms,
              [this] {
                  if (channel_->parser.expire(context_.host.now())) deliver();
                  if (const auto due = channel_->parser.deadline()) expiry_.set(*due);
              }},
      pacing_{context.alarms, [this] { write(); }} {}

void StreamLink::start() {
    channel_ = context_.host.open_channel(*this, peer());
    try_open();
}

void StreamLink::stop() {
    retry_.cancel();
    expiry_.cancel();
    pacing_.stop();
    if (descriptor_.is_open()) leave_wire(descriptor_.fd());
    descriptor_.close();
}

void StreamLink::try_open() {
    Opened opened = open_wire();
    const TimePoint now = context_.host.now();
    if (!opened.fd) {
        context_.host.link_down(*this, std::move(opened.error));
        retry_.set(backoff_.retry_at(now));
        return;
    }
    backoff_.came_up(now);
    descriptor_.open(std::move(opened.fd));
    arrival_.found_empty(context_.host.turn().clocks());
    pacing_.start(settings().rate != 0 ? settings().rate : line_rate(), settings().latency);
    resume_reading();
    came_up();
}

void StreamLink::resume_reading() {
    descriptor_.read_with([this] { read(); });
}

void StreamLink::end_of_input() {
    expiry_.cancel();
    channel_->parser.finish();
    deliver();
}

void StreamLink::fail(std::string why) {
    leave_wire(descriptor_.fd());
    descriptor_.close();
    pacing_.stop();
    end_of_input();
    context_.host.link_down(*this, std::move(why));
    retry_.set(backoff_.retry_at(context_.host.now()));
}

void StreamLink::read() {
    for (int i = 0; i < reads_per_turn; ++i) {
        const auto room = channel_->parser.prepare();
        const ssize_t n = ::read(descriptor_.fd(), room.data(), room.size());
        const int error = n < 0 ? errno : 0;
        if (error == EINTR) break;
        if (n <= 0) arrival_.found_empty(context_.host.turn().before());
        if (error == EAGAIN) break;
        if (n <= 0) return wire_ended(error);
        const LoopWatch& loop = context_.host.turn();
        channel_->arrived_at = arrival_.unstamped(loop);
        channel_->parser.commit(static_cast<std::size_t>(n), loop.now());
        deliver();
        if (!descriptor_.is_open()) return;
        if (static_cast<std::size_t>(n) < room.size() && !arrival_.is_behind()) break;    // a terminal gives by 4 KB what waits
    }
    if (const auto due = channel_->parser.deadline()) expiry_.set(*due);
}

void StreamLink::deliver() {
    while (const auto frame = channel_->parser.next()) context_.host.receive(*channel_, *frame);
    context_.host.flush();
}

void StreamLink::flush(Channel&) { write(); }

ssize_t StreamLink::write_some(std::span<const iovec> pieces) {
    return ::writev(descriptor_.fd(), pieces.data(), static_cast<int>(pieces.size()));
}

void StreamLink::write() {
    std::array<std::span<const std::uint8_t>, frames_per_write> frames;
    std::array<iovec, frames_per_write> pieces;
    Outbox& outbox = channel_->outbox;
    while (descriptor_.is_open() && !outbox.empty()) {
        const TimePoint now = context_.host.now();
        const std::size_t budget = pacing_.budget(outbox, now);
        if (budget == 0) return;
        const std::size_t count = outbox.gather(frames, now, budget);
        for (std::size_t i = 0; i < count; ++i) pieces[i] = {const_cast<std::uint8_t*>(frames[i].data()), frames[i].size()};
        if (count == 0) return;
        const ssize_t n = write_some(std::span{pieces}.first(count));
        if (n > 0) {
            outbox.sent(static_cast<std::size_t>(n));
            pacing_.sent(static_cast<std::size_t>(n), now);
            if (pacing_.is_on()) pacing_.correct(held_by_driver(), now);
        } else if (n == 0 || errno == EAGAIN) {
            outbox.set_congested();
            descriptor_.when_writable([this] { write(); });
            return;
        } else if (errno != EINTR) {
            return fail(gone_text(errno));
        }
    }
}

}    // namespace anogate
