#include <link/can/can_link.hpp>
#include <link/feed.hpp>
#include <link/udp/datagram_batch.hpp>
#include <sys/errors.hpp>
#include <sys/thread_signals.hpp>

#include <fcntl.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace anogate {
namespace {

constexpr std::size_t max_pdu = 4095;    // without the escape of ISO 15765-2:2016, which few devices know

// Errors of an earlier transfer: the socket returns them from the next call, read or write.
bool is_of_transfer(int error) {
    return error == ECOMM || error == ETIMEDOUT || error == EILSEQ || error == EBADMSG || error == EMSGSIZE;
}

}    // namespace

CanIsotpLink::CanIsotpLink(LinkId id, const LinkSettings& settings, const LinkContext& context)
    : CanLink{id, settings, context} {}

Opened<UniqueFd> CanIsotpLink::open_wire(UniqueFd stored) {
    trouble_ = {};
    return open_can_isotp(can(), std::move(stored));
}

// close() waits until the current transfer ends: up to a second if the peer does not answer.
void CanIsotpLink::close_wire() noexcept {
    if (!is_open()) return;
    const int copy = ::fcntl(fd(), F_DUPFD_CLOEXEC, 0);
    descriptor_.close();
    if (copy < 0) return;
    try {
        begin_thread([copy] { ::close(copy); }).detach();
    } catch (const std::system_error&) {
        ::close(copy);
    }
}

void CanIsotpLink::read() {
    const int count = context_.batch.receive(fd());
    if (count < 0) {
        const int error = errno;
        if (error == ENETDOWN || error == ENODEV || error == ENXIO || error == EBADF) return fail(can_error(can(), error));
        return transfer_failed(error);
    }
    const StallDetector& loop = context_.host.turn();
    const ClockReading asked = loop.before();
    const auto on_frame = [this](ano::FrameView frame) { context_.host.receive(channel(), frame); };
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        channel().arrived_at = context_.batch.arrived_at(i, arrival_, loop);
        feed_datagram(channel().parser, context_.batch.datagram(i), loop.now(), on_frame);
        channel().parser.finish();    // a PDU is a whole frame or none
        while (const auto frame = channel().parser.next()) on_frame(*frame);
        trouble_ = {};
    }
    if (static_cast<std::size_t>(count) < DatagramBatch::max_datagrams) arrival_.found_empty(asked);
    context_.host.flush();
}

void CanIsotpLink::transfer_failed(int error) {
    ++transfer_errors_;
    trouble_ = error == ECOMM || error == ETIMEDOUT
                   ? LinkError{"no_answer",
                               "the peer does not answer: check that it is running and that tx and rx are swapped on its side",
                               {}}
                   : LinkError{"a transfer failed: " + error_text(error)};
}

void CanIsotpLink::write() {
    std::array<std::span<const std::uint8_t>, 1> frame;
    Outbox& outbox = channel().outbox;
    while (is_open()) {
        const TimePoint now = context_.host.now();
        const std::size_t budget = pacing_.budget(outbox, now);
        if (budget == 0 || outbox.gather(frame, now, budget) == 0) return;
        if (frame[0].size() > max_pdu) {
            outbox.drop_frame(&SendCounters::too_big);
            continue;
        }
        if (::send(fd(), frame[0].data(), frame[0].size(), MSG_DONTWAIT) >= 0) {
            pacing_.sent(frame[0].size(), now);
            outbox.sent_frame();
            found_room();
        } else if (errno == EAGAIN) {
            return wait_for_room(true);
        } else if (errno == ENOBUFS || errno == ENOMEM) {
            return wait_for_room(false);
        } else if (is_of_transfer(errno)) {
            transfer_failed(errno);
        } else if (errno != EINTR) {
            return fail(can_error(can(), errno));
        }
    }
}

LinkFacts CanIsotpLink::facts() const {
    LinkFacts facts = CanLink::facts();
    facts.push_back({"transfer_errors", transfer_errors_});
    return facts;
}

LinkError CanIsotpLink::trouble() const {
    if (LinkError trouble = CanLink::trouble(); !trouble.text.empty()) return trouble;
    return trouble_;
}

}    // namespace anogate
