// 10,000 numbered frames each way between a serial port and a UDP port of a gateway that is restarted five times meanwhile.
//     restarts DEVICE PORT COMMAND    DEVICE is the far end of the serial line, COMMAND restarts the gateway
#include <support/numbered_frames.hpp>
#include <support/process.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <iostream>
#include <optional>
#include <vector>

namespace {

using namespace support;

constexpr std::uint8_t host = 0xFE, fc = 0xDC;
const char *device_path, *port, *command;

// The far end of a serial line; bytes that its driver does not accept at once wait here.
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

/// A stream of numbered frames: counts those that are missing, duplicated, or late.
class LossyStream {
public:
    static constexpr int max_under_way = 100;

    LossyStream(std::uint8_t from, std::uint8_t to) : from_{from}, to_{to} {}
    bool may_go_on() const { return sent() - next_ < max_under_way; }
    Bytes next() {
        came_.push_back(false);
        return numbered(from_, to_, sent() - 1);
    }
    void take(const std::vector<Bytes>& frames) {
        for (const Bytes& f : frames) {
            if (f[1] != from_ || f[3] != 0xF1) continue;
            const int number = f[6] | f[7] << 8 | f[8] << 16 | f[9] << 24;
            ASSERT_LT(number, sent());
            if (came_[static_cast<std::size_t>(number)]) twice_.push_back(number);
            else if (number < next_) late_.push_back(number);
            came_[static_cast<std::size_t>(number)] = true;
            next_ = std::max(next_, number + 1);
        }
    }
    int sent() const { return static_cast<int>(came_.size()); }
    int came() const { return next_; }
    int missing() const { return static_cast<int>(std::count(came_.begin(), came_.begin() + next_, false)); }
    const std::vector<int>& twice() const { return twice_; }
    const std::vector<int>& late() const { return late_; }

private:
    std::uint8_t from_, to_;
    std::vector<bool> came_;
    std::vector<int> twice_, late_;
    int next_ = 0;
};

// An emulated machine may not send within half a second the bytes passed to its driver: those are lost, and nothing else.
TEST(Restarts, lose_only_frames_in_transit_of_ten_thousand) {
    constexpr int frames = 10'000, restarts = 5, behind_the_last = 500;
    stay_on_one_processor();
    Terminal device{device_path};
    UdpPeer peer;
    const anogate::Endpoint to = endpoint(std::string{"127.0.0.1:"} + port);
    LossyStream up{fc, host}, down{host, fc};
    Bytes rest;
    peer.send(to, frame(host, 0xFF, 0x05));    // registered as a peer from here on
    device.write(frame(fc, 0xFF, 0x06));
    ASSERT_TRUE(wait_until([&] { return !peer.frames().empty(); }));
    int restarted = 0, end = INT_MAX;
    std::optional<Shell> restarting;
    const auto begin_or_end_restart = [&] {
        if (restarting && !restarting->is_running()) {
            EXPECT_EQ(restarting->wait(), 0) << restarting->output();
            restarting.reset();
            if (restarted == restarts) end = std::max({frames, up.sent(), down.sent()}) + behind_the_last;
        }
        if (restarting || restarted == restarts || up.came() < (restarted + 1) * frames / (restarts + 1)) return;
        ++restarted;
        restarting.emplace(command);
    };
    EXPECT_TRUE(wait_until(
        [&] {
            for (int i = 0; i < 20 && up.may_go_on(); ++i) device.write(up.next());
            for (int i = 0; i < 20 && down.may_go_on(); ++i) peer.send(to, down.next());
            device.write({});
            up.take(peer.frames());
            down.take(frames_of(device, rest));
            begin_or_end_restart();
            return testing::Test::HasFailure() || (up.came() >= end && down.came() >= end);
        },
        std::chrono::minutes{5}))
        << up.came() << " and " << down.came() << " of " << end;
    EXPECT_EQ(restarted, restarts);
    std::cout << "lost from the device: " << up.missing() << ", to it: " << down.missing() << " of " << up.sent() << " each\n";
    for (const auto* stream : {&up, &down}) {
        const char* which = stream == &up ? "from the device" : "to the device";
        EXPECT_LE(stream->missing(), restarts * LossyStream::max_under_way) << which;
        EXPECT_EQ(stream->twice(), std::vector<int>{}) << which;
        EXPECT_EQ(stream->late(), std::vector<int>{}) << which;
    }
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
