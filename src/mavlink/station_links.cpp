#include <gateway/ip.hpp>
#include <link/serial/termios.hpp>
#include <link/udp/ip_socket.hpp>
#include <log/log.hpp>
#include <log/log_line.hpp>
#include <mavlink/station_links.hpp>
#include <sys/asio.hpp>
#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <optional>
#include <utility>

namespace anogate::mavlink {
namespace {

using ano::Clock;
using Bytes = std::span<const std::uint8_t>;

constexpr std::size_t max_peers = 16, max_datagram = 2048, max_unsent = 4096, reads_at_once = 64;
constexpr ano::Duration peer_silence = std::chrono::seconds{30};

std::string error_text() { return std::strerror(errno); }
bool would_block() noexcept { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

// A descriptor whose readiness is reported until it is closed, or the call returns false.
class Readable {
public:
    Readable(asio::io_context& io, UniqueFd fd, std::function<bool()> ready)
        : stream_{io, fd.release()}, ready_{std::move(ready)} {
        wait();
    }
    int fd() { return stream_.native_handle(); }

private:
    void wait() {
        stream_.async_wait(asio::posix::stream_descriptor::wait_read, [this, alive = std::weak_ptr{alive_}](error_code ec) {
            if (ec || alive.expired()) return;
            if (ready_() && !alive.expired()) wait();
        });
    }

    asio::posix::stream_descriptor stream_;
    std::function<bool()> ready_;
    std::shared_ptr<int> alive_ = std::make_shared<int>(0);
};

EndpointSpec spec_of(const std::string& place) { return EndpointSpec::parse(place).value_or(EndpointSpec{}); }

class UdpStation final : public StationLink {
public:
    UdpStation(asio::io_context& io, MavlinkBridge& bridge, std::string place)
        : io_{io},
          bridge_{bridge},
          place_{std::move(place)},
          to_{Endpoint::parse(place_).value_or(Endpoint{})},
          connection_{bridge.open({Transport::reliable, true, true, "udp:" + place_}, Clock::now())} {
        open();
    }

    bool transmit(std::size_t connection, Bytes packet, bool& accepted) override {
        if (connection != connection_) return false;
        // A station that is not there is no reason to wait.
        accepted = !socket_ || ::send(socket_->fd(), packet.data(), packet.size(), MSG_DONTWAIT) >= 0 || !would_block();
        return true;
    }
    void on_time(ano::TimePoint) override {
        if (!socket_) open();
    }

private:
    void open() {
        const bool is_v6 = place_.front() == '[';
        auto opened = open_udp(spec_of(is_v6 ? "[::]:0" : "0.0.0.0:0"), false);
        const SocketAddress there = SocketAddress::of(to_, is_v6);
        if (!opened || ::connect(opened->get(), there.get(), there.size) != 0) {
            if (!std::exchange(told_, true)) log_warning("udp:{}: {}; trying again", place_, error_text());
            return;
        }
        told_ = false;
        socket_.emplace(io_, std::move(*opened), [this] {
            read();
            return true;
        });
    }
    void read() {
        std::array<std::uint8_t, max_datagram> bytes;
        for (std::size_t i = 0; i < reads_at_once; ++i) {
            const auto size = ::recv(socket_->fd(), bytes.data(), bytes.size(), MSG_DONTWAIT);
            if (size < 0) return;    // ECONNREFUSED, too: the station is not there yet
            bridge_.on_bytes(connection_, std::span{bytes}.first(static_cast<std::size_t>(size)), Clock::now());
        }
    }

    asio::io_context& io_;
    MavlinkBridge& bridge_;
    std::string place_;
    Endpoint to_;
    std::size_t connection_;
    std::optional<Readable> socket_;
    bool told_ = false;
};

class UdpListener final : public StationLink {
public:
    UdpListener(asio::io_context& io, MavlinkBridge& bridge, std::string place)
        : io_{io}, bridge_{bridge}, place_{std::move(place)}, is_v6_{place_.front() == '['} {
        open();
    }

    bool transmit(std::size_t connection, Bytes packet, bool& accepted) override {
        for (auto& [endpoint, peer] : peers_) {
            if (peer.connection != connection) continue;
            const SocketAddress to = SocketAddress::of(peer.endpoint, is_v6_);
            accepted = !socket_ || ::sendto(socket_->fd(), packet.data(), packet.size(), MSG_DONTWAIT, to.get(), to.size) >= 0 ||
                       !would_block();
            return true;
        }
        return false;
    }
    void on_time(ano::TimePoint now) override {
        if (!socket_) open();
        std::erase_if(peers_, [&](const auto& one) {
            const bool is_silent = now - one.second.heard_at > peer_silence;
            if (is_silent) bridge_.close(one.second.connection);
            return is_silent;
        });
    }

private:
    struct Peer {
        Endpoint endpoint;
        std::size_t connection = 0;
        ano::TimePoint heard_at{};
    };
    void open() {
        auto opened = open_udp(spec_of(place_), false);
        if (!opened) {
            if (!std::exchange(told_, true)) log_warning("udp-listen:{}: {}; trying again", place_, opened.error().text);
            return;
        }
        told_ = false;
        socket_.emplace(io_, std::move(*opened), [this] {
            read();
            return true;
        });
    }
    void read() {
        std::array<std::uint8_t, max_datagram> bytes;
        for (std::size_t i = 0; i < reads_at_once; ++i) {
            sockaddr_storage from{};
            socklen_t size_of_from = sizeof from;
            const auto size = ::recvfrom(socket_->fd(), bytes.data(), bytes.size(), MSG_DONTWAIT,
                                         reinterpret_cast<sockaddr*>(&from), &size_of_from);
            if (size < 0) return;
            receive(endpoint_of(from), std::span{bytes}.first(static_cast<std::size_t>(size)));
        }
    }
    void receive(const Endpoint& from, Bytes bytes) {
        const std::string text = from.text();
        auto found = peers_.find(text);
        if (found == peers_.end()) {
            if (peers_.size() == max_peers) return;
            const std::size_t number = bridge_.open({Transport::reliable, false, true, text}, Clock::now());
            found = peers_.emplace(text, Peer{from, number}).first;
        }
        found->second.heard_at = Clock::now();
        bridge_.on_bytes(found->second.connection, bytes, Clock::now());
    }

    asio::io_context& io_;
    MavlinkBridge& bridge_;
    std::string place_;
    bool is_v6_;
    std::optional<Readable> socket_;
    std::map<std::string, Peer> peers_;
    bool told_ = false;
};

// A stream that is read and written without waiting; what does not fit waits here, so that packets stay whole.
class Stream {
public:
    Stream(asio::io_context& io, MavlinkBridge& bridge, UniqueFd fd, std::size_t connection)
        : bridge_{bridge}, connection_{connection}, readable_{io, std::move(fd), [this] {
                                                                  read();
                                                                  return !is_lost_;
                                                              }} {}

    std::size_t connection() const noexcept { return connection_; }
    bool is_lost() const noexcept { return is_lost_; }
    bool transmit(Bytes packet) {
        write();
        if (unsent_.size() + packet.size() > max_unsent || (!unsent_.empty())) return is_lost_;
        unsent_.assign(packet.begin(), packet.end());
        write();
        return true;
    }
    void write() {
        while (!unsent_.empty() && !is_lost_) {
            const auto size = ::write(readable_.fd(), unsent_.data(), unsent_.size());
            if (size < 0) {
                is_lost_ = !would_block();
                return;
            }
            unsent_.erase(unsent_.begin(), unsent_.begin() + size);
        }
    }
    void on_time(ano::TimePoint now) {
        if (now - read_at_ > PacketParser::quiet) bridge_.on_quiet(connection_, now);
    }

private:
    void read() {
        std::array<std::uint8_t, max_datagram> bytes;
        const auto size = ::read(readable_.fd(), bytes.data(), bytes.size());
        if (size > 0) {
            read_at_ = Clock::now();
            return bridge_.on_bytes(connection_, std::span{bytes}.first(static_cast<std::size_t>(size)), read_at_);
        }
        is_lost_ = size == 0 || !would_block();
    }

    MavlinkBridge& bridge_;
    std::size_t connection_;
    bool is_lost_ = false;
    ano::TimePoint read_at_{};
    std::vector<std::uint8_t> unsent_;
    Readable readable_;
};

class TcpListener final : public StationLink {
public:
    TcpListener(asio::io_context& io, MavlinkBridge& bridge, std::string place)
        : io_{io}, bridge_{bridge}, place_{std::move(place)} {
        open();
    }

    bool transmit(std::size_t connection, Bytes packet, bool& accepted) override {
        for (const auto& stream : streams_)
            if (stream->connection() == connection) {
                accepted = stream->transmit(packet);
                return true;
            }
        return false;
    }
    void on_time(ano::TimePoint now) override {
        if (!listener_) open();
        for (const auto& stream : streams_) stream->on_time(now);
        std::erase_if(streams_, [&](const auto& stream) {
            if (stream->is_lost()) bridge_.close(stream->connection());
            return stream->is_lost();
        });
    }

private:
    void open() {
        const Endpoint at = Endpoint::parse(place_).value_or(Endpoint{});
        const bool is_v6 = place_.front() == '[';
        UniqueFd fd{::socket(is_v6 ? AF_INET6 : AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)};
        const int on = 1;
        const SocketAddress here = SocketAddress::of(at, is_v6);
        if (!fd || ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
            ::bind(fd.get(), here.get(), here.size) != 0 || ::listen(fd.get(), max_peers) != 0) {
            if (!std::exchange(told_, true)) log_warning("tcp-listen:{}: {}; trying again", place_, error_text());
            return;
        }
        told_ = false;
        listener_.emplace(io_, std::move(fd), [this] {
            accept();
            return true;
        });
    }
    void accept() {
        UniqueFd fd{::accept4(listener_->fd(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)};
        if (!fd || streams_.size() == max_peers) return;
        const int on = 1;
        ::setsockopt(fd.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        const std::size_t connection = bridge_.open({Transport::reliable, true, false, "tcp-listen:" + place_}, Clock::now());
        streams_.push_back(std::make_unique<Stream>(io_, bridge_, std::move(fd), connection));
    }

    asio::io_context& io_;
    MavlinkBridge& bridge_;
    std::string place_;
    std::optional<Readable> listener_;
    std::vector<std::unique_ptr<Stream>> streams_;
    bool told_ = false;
};

class SerialLine final : public StationLink {
public:
    SerialLine(asio::io_context& io, MavlinkBridge& bridge, std::string device, std::uint32_t baud)
        : io_{io}, bridge_{bridge}, device_{std::move(device)}, baud_{baud} {
        open();
    }

    bool transmit(std::size_t connection, Bytes packet, bool& accepted) override {
        if (!stream_ || stream_->connection() != connection) return false;
        accepted = stream_->transmit(packet);
        return true;
    }
    void on_time(ano::TimePoint now) override {
        if (stream_) stream_->on_time(now);
        if (stream_ && stream_->is_lost()) {
            log_warning("serial:{} is gone; waiting for it", device_);
            bridge_.close(stream_->connection());
            stream_.reset();
        }
        if (!stream_) open();
    }

private:
    void open() {
        UniqueFd fd{::open(device_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
        SerialSettings settings;
        settings.baud = baud_;
        const auto configured = fd ? terminal::configure(fd.get(), settings) : Expected<std::uint32_t>{Unexpected{error_text()}};
        if (!configured) {
            if (!std::exchange(told_, true)) log_warning("serial:{}: {}; trying again", device_, configured.error());
            return;
        }
        told_ = false;
        const std::size_t connection = bridge_.open({Transport::lossy, true, false, "serial:" + device_}, Clock::now());
        stream_ = std::make_unique<Stream>(io_, bridge_, std::move(fd), connection);
    }

    asio::io_context& io_;
    MavlinkBridge& bridge_;
    std::string device_;
    std::uint32_t baud_;
    std::unique_ptr<Stream> stream_;
    bool told_ = false;
};

}    // namespace

std::unique_ptr<StationLink> make_udp(asio::io_context& io, MavlinkBridge& bridge, const std::string& place) {
    return std::make_unique<UdpStation>(io, bridge, place);
}
std::unique_ptr<StationLink> make_udp_listen(asio::io_context& io, MavlinkBridge& bridge, const std::string& place) {
    return std::make_unique<UdpListener>(io, bridge, place);
}
std::unique_ptr<StationLink> make_tcp_listen(asio::io_context& io, MavlinkBridge& bridge, const std::string& place) {
    return std::make_unique<TcpListener>(io, bridge, place);
}
std::unique_ptr<StationLink> make_serial(asio::io_context& io, MavlinkBridge& bridge, const std::string& device,
                                         std::uint32_t baud) {
    return std::make_unique<SerialLine>(io, bridge, device, baud);
}

}    // namespace anogate::mavlink
