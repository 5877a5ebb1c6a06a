#include <link/hid/hid_report.hpp>
#include <link/hid/hid_writer.hpp>
#include <sys/errors.hpp>
#include <sys/thread_signals.hpp>

#include <fcntl.h>
#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <system_error>

namespace anogate {
namespace {

// As few as the kernel permits, a few kilobytes: urgent frames overtake those in the outbox, not those in the socket.
constexpr int socket_buffer = 1;

// A report to a device without report ids begins with the number 0 (Documentation/hid/hidraw.rst of Linux).
constexpr std::size_t report_number = 1;

// Runs in a thread.
void write_reports(const UniqueFd& stream, const UniqueFd& device, std::size_t report_size, std::atomic<std::uint64_t>& failed) {
    for (;;) {
        std::array<std::uint8_t, report_number + hid::max_report> report{};
        const ssize_t n = ::read(stream.get(), report.data() + report_number + 1, hid::bytes_per_report(report_size));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return;
        report[report_number] = static_cast<std::uint8_t>(n);
        if (::write(device.get(), report.data(), report_number + report_size) >= 0) continue;
        ++failed;
        if (errno == ENODEV) return;
    }
}

}    // namespace

HidWriter::HidWriter(asio::io_context& io) : stream_{io} {}

Expected<void> HidWriter::open(int device, std::size_t report_size) try {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return Unexpected{error_text("socketpair", errno)};
    UniqueFd ours{ends[0]}, threads{ends[1]}, copy{::fcntl(device, F_DUPFD_CLOEXEC, 0)};
    if (!copy) return Unexpected{error_text("dup", errno)};
    ::setsockopt(ours.get(), SOL_SOCKET, SO_SNDBUF, &socket_buffer, sizeof socket_buffer);
    if (::fcntl(ours.get(), F_SETFL, O_NONBLOCK) != 0) return Unexpected{error_text("fcntl", errno)};
    begin_thread([stream = std::move(threads), to = std::move(copy), report_size, failed = failed_reports_] {
        write_reports(stream, to, report_size, *failed);
    }).detach();
    stream_.open(std::move(ours));
    return {};
} catch (const std::system_error& why) {
    return Unexpected{std::string{"can't start a thread: "} + why.what()};
}

ssize_t HidWriter::write_some(std::span<const iovec> pieces) {
    msghdr message{};
    message.msg_iov = const_cast<iovec*>(pieces.data());
    message.msg_iovlen = pieces.size();
    return ::sendmsg(stream_.fd(), &message, MSG_NOSIGNAL);
}

bool HidWriter::has_unsent() const noexcept {
    int unread = 0;
    return stream_.is_open() && ::ioctl(stream_.fd(), SIOCOUTQ, &unread) == 0 && unread > 0;
}

}    // namespace anogate
