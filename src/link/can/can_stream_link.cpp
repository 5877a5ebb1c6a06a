#include <gateway/can_settings.hpp>
#include <link/can/can_link.hpp>
#include <link/udp/datagram_batch.hpp>

#include <linux/can.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace anogate {

struct CanStreamLink::Batch {
    static constexpr std::size_t max_frames = CanCutter::max_pieces;

    int receive(int fd) noexcept {
        prepare(sizeof(canfd_frame));
        for (std::size_t i = 0; i < max_frames; ++i) stamps[i].prepare(messages[i].msg_hdr);
        const int count = ::recvmmsg(fd, messages.data(), max_frames, MSG_DONTWAIT, nullptr);
        return count < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : count;
    }
    std::span<const std::uint8_t> data(std::size_t i) const noexcept {
        const std::size_t room = messages[i].msg_len == CANFD_MTU ? CANFD_MAX_DLEN : CAN_MAX_DLEN;
        return {frames[i].data, std::min<std::size_t>(frames[i].len, room)};
    }

    void fill(std::span<const CanCutter::Piece> pieces, const CanSettings& can) noexcept {
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            canfd_frame& frame = frames[i];
            frame = {};
            frame.can_id = pieces[i].id | (can.extended ? CAN_EFF_FLAG : 0);
            frame.len = pieces[i].size;
            if (can.fd && can.brs) frame.flags = CANFD_BRS;
            std::memcpy(frame.data, pieces[i].bytes.data(), pieces[i].bytes.size());
        }
        prepare(can.fd ? CANFD_MTU : CAN_MTU);
    }

    void prepare(std::size_t size) noexcept {
        for (std::size_t i = 0; i < max_frames; ++i) {
            rooms[i] = {&frames[i], size};
            messages[i] = {};
            messages[i].msg_hdr.msg_iov = &rooms[i];
            messages[i].msg_hdr.msg_iovlen = 1;
        }
    }

    std::array<canfd_frame, max_frames> frames;
    std::array<iovec, max_frames> rooms;
    std::array<mmsghdr, max_frames> messages;
    std::array<Stamp, max_frames> stamps;
};

CanStreamLink::CanStreamLink(LinkId id, const LinkSettings& settings, const LinkContext& context)
    : CanLink{id, settings, context},
      batch_{new Batch},
      cutter_{settings.as<CanSettings>()},
      streams_{settings.as<CanSettings>(), settings.max_data},
      expiry_{context.alarms, [this] { expire(); }} {}

CanStreamLink::~CanStreamLink() = default;

void CanStreamLink::stop() {
    expiry_.cancel();
    CanLink::stop();
}

Opened<UniqueFd> CanStreamLink::open_wire(UniqueFd stored) { return open_can_stream(can(), std::move(stored)); }

void CanStreamLink::read() {
    const int count = batch_->receive(fd());
    if (count < 0) return fail(can_error(can(), errno));
    if (count > 0) heard_on_bus();
    const StallDetector& loop = context_.host.turn();
    const ClockReading asked = loop.before();
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        channel().arrived_at = arrival(batch_->messages[i].msg_hdr, arrival_, loop);
        streams_.receive(batch_->frames[i].can_id & CAN_EFF_MASK, batch_->data(i), loop.now(),
                         [this](ano::FrameView frame) { context_.host.receive(channel(), frame); });
    }
    if (static_cast<std::size_t>(count) < Batch::max_frames) arrival_.found_empty(asked);
    batch_ends();
}

void CanStreamLink::expire() {
    streams_.expire(context_.host.now(), [this](ano::FrameView frame) { context_.host.receive(channel(), frame); });
    batch_ends();
}

void CanStreamLink::lost() {
    expiry_.cancel();
    cutter_.reset();
    streams_.finish([this](ano::FrameView frame) { context_.host.receive(channel(), frame); });
    batch_ends();
}

void CanStreamLink::batch_ends() {
    channel().beside = streams_.received();
    if (const auto due = streams_.deadline()) expiry_.set(*due);
    context_.host.flush();
}

void CanStreamLink::write() {
    std::array<std::span<const std::uint8_t>, Batch::max_frames> frames;
    Outbox& outbox = channel().outbox;
    while (is_open()) {
        const TimePoint now = context_.host.now();
        const std::size_t budget = pacing_.budget(outbox, now);
        const std::size_t count = budget > 0 ? outbox.gather(frames, now, budget) : 0;
        if (count == 0) return;
        const auto pieces = cutter_.cut(std::span{frames}.first(count));
        batch_->fill(pieces, can());
        const int n = ::sendmmsg(fd(), batch_->messages.data(), static_cast<unsigned>(pieces.size()), MSG_DONTWAIT);
        if (n > 0) {
            const std::size_t bytes = cutter_.taken(static_cast<std::size_t>(n));
            outbox.sent(bytes);
            pacing_.sent(bytes, now);
            found_room();
        } else if (n == 0 || errno == EAGAIN) {
            return wait_for_room(true);
        } else if (errno == ENOBUFS || errno == ENOMEM) {
            return wait_for_room(false);
        } else if (errno != EINTR) {
            return fail(can_error(can(), errno));
        }
    }
}

LinkFacts CanStreamLink::facts() const {
    LinkFacts facts = CanLink::facts();
    facts.push_back({"wrong_source", static_cast<std::int64_t>(streams_.wrong_source())});
    return facts;
}

}    // namespace anogate
