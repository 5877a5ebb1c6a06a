// 10,000 numbered frames each way between a serial port and a UDP port of a gateway that is restarted five times meanwhile.
//     restarts DEVICE PORT COMMAND    DEVICE is the far end of the serial line, COMMAND restarts the gateway
#include <support/numbered_frames.hpp>
#include <support/process.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <optional>

namespace {

using namespace support;

constexpr std::uint8_t host = 0xFE, fc = 0xDC;
const char *device_path, *port, *command;

// The far end of a serial line; what its driver does not take at once waits here.
class Terminal {
public:
    explicit Terminal(const char* path) : fd_{::open(path, O_RDWR | O_NOCTTY | O_NONBLOCK)} {
        termios line{};
        ::tcgetattr(fd_, &line);
        ::cfmakeraw(&line);
        ::tcsetattr(fd_, TCSANOW, &line);
    }
    ~Terminal() { ::close(fd_); }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    void write(const Bytes& bytes) {
        waiting_ = std::move(waiting_) + bytes;
        const ssize_t n = ::write(fd_, waiting_.data(), waiting_.size());
        if (n > 0) waiting_.erase(waiting_.begin(), waiting_.begin() + n);
    }
    Bytes read() {
        Bytes bytes(65536);
        const ssize_t n = ::read(fd_, bytes.data(), bytes.size());
        bytes.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
        return bytes;
    }

private:
    int fd_;
    Bytes waiting_;
};

TEST(Restarts, lose_none_of_ten_thousand_frames_each_way) {
    constexpr int frames = 10'000, restarts = 5;
    Terminal device{device_path};
    UdpPeer peer;
    const anogate::Endpoint to = endpoint(std::string{"127.0.0.1:"} + port);
    Stream up{fc, host}, down{host, fc};
    Bytes rest;
    peer.send(to, frame(host, 0xFF, 0x05));    // a peer from here on
    device.write(frame(fc, 0xFF, 0x06));
    ASSERT_TRUE(wait_until([&] { return !peer.frames().empty(); }));
    int restarted = 0;
    std::optional<Shell> restarting;
    EXPECT_TRUE(wait_until(
        [&] {
            for (int i = 0; i < 20 && up.may_go_on(frames); ++i) device.write(up.next());
            for (int i = 0; i < 20 && down.may_go_on(frames); ++i) peer.send(to, down.next());
            device.write({});
            up.take(peer.frames());
            down.take(frames_of(device, rest));
            if (restarting && !restarting->is_running()) {
                EXPECT_EQ(restarting->wait(), 0) << restarting->output();
                restarting.reset();
            }
            if (!restarting && restarted < restarts && up.came() >= (restarted + 1) * frames / (restarts + 1)) {
                ++restarted;
                restarting.emplace(command);
            }
            return testing::Test::HasFailure() || (up.came() == frames && down.came() == frames && !restarting);
        },
        std::chrono::minutes{5}))
        << up.came() << " and " << down.came() << " of " << frames;
    EXPECT_EQ(restarted, restarts);
}

}    // namespace

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    if (argc != 4) return 2;
    device_path = argv[1];
    port = argv[2];
    command = argv[3];
    return RUN_ALL_TESTS();
}
