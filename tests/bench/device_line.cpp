#include "device_line.hpp"

#include "traffic_ends.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>

namespace bench {

using namespace std::chrono_literals;

namespace {

constexpr auto between_hellos = 200ms;    // it is registered before it is asked

}    // namespace

DeviceLine::DeviceLine(Wire wire, support::LineFaults faults, std::size_t parameters) : faults_{faults} {
    fake_.make_parameters(parameters);
    fake_.instead = [this](ano::FrameView frame) { return loader_.take(fake_, frame); };
    if (wire == Wire::pty) {
        fd_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
        must(fd_ >= 0 && ::grantpt(fd_) == 0 && ::unlockpt(fd_) == 0, "a pseudo-terminal");
        const std::string path = ::ptsname(fd_);
        other_end_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
        termios raw{};
        ::cfmakeraw(&raw);
        ::tcsetattr(other_end_, TCSANOW, &raw);
        link_ = "serial:" + path + ",baud=" + std::to_string(faults.baud) + ",name=line";
    } else {
        fd_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        auto* const generic = reinterpret_cast<sockaddr*>(&address);
        must(::bind(fd_, generic, size) == 0 && ::getsockname(fd_, generic, &size) == 0, "a UDP socket");
        port_ = ntohs(address.sin_port);
        link_ = "udp:127.0.0.1:" + std::to_string(port_) + ",hello=on,name=line";
    }
    thread_ = std::thread{[this] { run(); }};
}

DeviceLine::~DeviceLine() {
    stop_ = true;
    thread_.join();
    if (other_end_ >= 0) ::close(other_end_);
    ::close(fd_);
}

void DeviceLine::run() {
    auto hello_at = Clock::now();
    while (!stop_) {
        if (Clock::now() >= hello_at && there_.bytes == 0) {
            hello_at = Clock::now() + between_hellos;
            send_hello();
        }
        const auto next = std::min(events_.empty() ? Clock::time_point::max() : events_.begin()->first, Clock::now() + 20ms);
        const auto left = std::max<Clock::duration>(next - Clock::now(), 0ns);
        const timespec wait{left / 1s, (left % 1s).count()};
        pollfd in{fd_, POLLIN, 0};
        ::ppoll(&in, 1, &wait, nullptr);
        if (in.revents != 0) read();
        while (!events_.empty() && events_.begin()->first <= Clock::now()) {
            const Event event = std::move(events_.begin()->second);
            events_.erase(events_.begin());
            arrive(event);
        }
    }
}

void DeviceLine::send_hello() {
    if (other_end_ >= 0) arrive({false, support::frame(fake_.address, 0xFF, 0x01, support::Bytes(13))});
}

void DeviceLine::read() {
    while (true) {
        const auto room = parser_.prepare();
        sockaddr_in from{};
        socklen_t size = sizeof from;
        const ssize_t n = other_end_ >= 0
                              ? ::read(fd_, room.data(), room.size())
                              : ::recvfrom(fd_, room.data(), room.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
        if (n <= 0) return;
        const auto* const bytes = reinterpret_cast<const std::uint8_t*>(&from);
        if (other_end_ < 0) sender_.assign(bytes, bytes + size);
        parser_.commit(static_cast<std::size_t>(n), {});
        while (const auto frame = parser_.next()) put(true, {frame->bytes().begin(), frame->bytes().end()});
    }
}

void DeviceLine::put(bool to_device, const support::Bytes& frame) {
    Direction& way = to_device ? there_ : back_;
    way.bytes += frame.size();
    const auto on_wire = faults_.baud == 0 ? 0ns : std::chrono::nanoseconds{frame.size() * 10'000'000'000 / faults_.baud};
    way.free_at = std::max(way.free_at, Clock::now()) + on_wire;
    if (static_cast<double>(random_.below(1'000'000u)) < faults_.loss * 1e6) return;
    events_.emplace(way.free_at + std::chrono::duration_cast<Clock::duration>(faults_.delay), Event{to_device, frame});
}

void DeviceLine::arrive(const Event& event) {
    if (event.to_device) {
        for (const support::Bytes& answer : fake_.take(ano::FrameView{event.frame})) put(false, answer);
        return;
    }
    if (other_end_ >= 0) (void)!::write(fd_, event.frame.data(), event.frame.size());
    else if (!sender_.empty())
        ::sendto(fd_, event.frame.data(), event.frame.size(), 0, reinterpret_cast<const sockaddr*>(sender_.data()),
                 static_cast<socklen_t>(sender_.size()));
}

}    // namespace bench
