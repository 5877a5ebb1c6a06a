#include <gateway/pack.hpp>
#include <link/udp/datagram_sender.hpp>
#include <link/udp/error_queue.hpp>

#include <algorithm>
#include <cerrno>

namespace anogate {
namespace {

constexpr int max_reported = 16;    // failures caused by earlier datagrams, after which the rest waits for no_memory_pause

}    // namespace

// Frames that are contiguous in the outbox become one iovec.
unsigned DatagramSender::fill(std::size_t frames, const SocketAddress* to, std::size_t mtu) noexcept {
    auto rest = std::span{std::as_const(room_->frames)}.first(frames);
    std::size_t pieces = 0;
    std::size_t datagrams = 0;
    while (!rest.empty() && datagrams < max_datagrams) {
        const std::size_t count = frames_in_datagram(rest, mtu);
        const std::size_t first = pieces;
        for (const auto frame : rest.first(count)) {
            iovec* last = pieces > first ? &room_->pieces[pieces - 1] : nullptr;
            if (last && static_cast<std::uint8_t*>(last->iov_base) + last->iov_len == frame.data()) last->iov_len += frame.size();
            else room_->pieces[pieces++] = {const_cast<std::uint8_t*>(frame.data()), frame.size()};
        }
        mmsghdr& message = room_->messages[datagrams];
        message = {};
        message.msg_hdr.msg_iov = &room_->pieces[first];
        message.msg_hdr.msg_iovlen = pieces - first;
        if (to) {
            message.msg_hdr.msg_name = const_cast<sockaddr_storage*>(&to->storage);
            message.msg_hdr.msg_namelen = to->size;
        }
        room_->frames_in[datagrams++] = count;
        rest = rest.subspan(count);
    }
    return static_cast<unsigned>(datagrams);
}

SendReport DatagramSender::send_all(const Path& way, Outbox& outbox, Pacing& pacing, ano::TimePoint now) {
    SendReport report;
    const auto stop = [&report](SendResult result) {
        report.result = result;
        return report;
    };
    std::size_t mtu = way.mtu;
    int failures = 0;    // of one datagram. Each is tried twice, because an error may belong to an earlier one
    int reported = 0;
    std::size_t spent = 0;
    while (!outbox.empty()) {
        const std::size_t paced = pacing.budget(outbox, now);
        if (paced == 0) return stop(SendResult::paced);
        const std::size_t budget = std::min(paced, way.max_bytes - spent);
        const std::size_t frames = outbox.gather(std::span{room_->frames}.first(mtu > 0 ? max_frames : max_datagrams), now,
                                                 budget);
        if (frames == 0) break;
        const unsigned datagrams = fill(frames, way.to, mtu);
        const int sent = ::sendmmsg(way.fd, room_->messages.data(), datagrams, MSG_DONTWAIT);
        std::size_t frame = 0;
        for (std::size_t datagram = 0; static_cast<int>(datagram) < sent; ++datagram) {
            for (std::size_t i = 0; i < room_->frames_in[datagram]; ++i, ++frame) {
                spent += room_->frames[frame].size();
                if (way.tap) [[unlikely]]
                    way.tap->sent(room_->frames[frame]);
                pacing.sent(room_->frames[frame].size(), pacing.pauses() ? ano::Clock::now() : now);
                outbox.sent_frame();
            }
        }
        if (sent > 0) failures = 0;
        if (sent >= 0) continue;
        const auto abandon = [&](std::uint64_t SendCounters::*cause) {
            failures = 0;
            for (std::size_t i = 0; i < room_->frames_in[0]; ++i) outbox.drop_frame(cause);
        };
        report.error = errno;
        if (way.read_reports && may_be_reported(report.error) && (*way.read_reports)()) {
            if (++reported < max_reported) continue;    // the error belongs to an earlier datagram; this one was not sent
            outbox.set_congested();
            return stop(SendResult::no_memory);
        }
        switch (report.error) {
        case EINTR: break;
        case EAGAIN: outbox.set_congested(); return stop(SendResult::full);
        case ENOBUFS:
        case ENOMEM: outbox.set_congested(); return stop(SendResult::no_memory);
        case EMSGSIZE:
            if (room_->frames_in[0] > 1) mtu = 0;    // datagrams of one frame each may be small enough
            else if (++failures == 2) abandon(&SendCounters::too_big);
            break;
        case ECONNREFUSED:
            ++report.refused;
            if (++failures == 2) abandon(&SendCounters::send_failed);
            break;
        case ENETUNREACH:
            if (!way.to) return stop(SendResult::broken);    // connected from an address that was removed: can't recover
            [[fallthrough]];
        default:
            if (!way.read_reports || ++failures == 2) abandon(&SendCounters::send_failed);
            break;
        case EBADF:
        case EINVAL:
        case ENODEV:
        case ENETDOWN:
        case EADDRNOTAVAIL:
        case ENOTCONN: return stop(SendResult::broken);
        }
    }
    return report;
}

}    // namespace anogate
