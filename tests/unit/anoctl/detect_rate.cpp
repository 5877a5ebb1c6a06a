#include <gtest/gtest.h>
#include <anoctl/ports/detect_rate.hpp>

#include <sys/file.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <sstream>
#include <string>
#include <thread>

#include <support/anoctl.hpp>
#include <support/bytes.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>

namespace detect_rate_tests {
namespace {

using support::Bytes;

const Bytes euler = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});

/// The rate set by the user of a pseudo-terminal, any integer: <termios.h> returns only the traditional rates.
std::uint32_t rate_of(int fd) {
    struct {
        std::uint32_t flags[4];
        std::uint8_t line, cc[19];
        std::uint32_t input, output;
    } settings{};
    return ::ioctl(fd, _IOC(_IOC_READ, 'T', 0x2A, sizeof settings), &settings) == 0 ? settings.output : 0;
}

/// Sends something every few milliseconds that depends on the rate set by its user.
class Speaker {
public:
    explicit Speaker(std::function<Bytes(std::uint32_t baud)> say)
        : device_{(folder_.path() / "tty").string()}, thread_{[this, say = std::move(say)] {
              while (!over_) {
                  device_.write(say(rate_of(device_.fd())));
                  std::this_thread::sleep_for(std::chrono::milliseconds{5});
              }
          }} {}
    ~Speaker() {
        over_ = true;
        thread_.join();
    }
    const std::string& path() const { return device_.path(); }

private:
    support::TempDir folder_;
    support::PtyDevice device_;
    std::atomic<bool> over_ = false;
    std::thread thread_;
};

/// Enough bytes within `moment` for a rate to be given up, so that the tests don't wait for the time limit of a rate.
const Bytes garbage(1500, 0x55);
constexpr std::chrono::milliseconds moment{60};
constexpr std::chrono::seconds until_heard{20};

struct Found {
    int exit = 0;
    std::string out, wrong;
};

Found detect(const std::string& port, bool json = false, anoctl::ListeningTime time = {until_heard, until_heard}) {
    std::ostringstream out, err;
    anoctl::Streams streams{0, out, err};
    Found found;
    try {
        found.exit = anoctl::detect_rate(port, json, streams, time);
    } catch (const anoctl::Failure& failure) {
        found = {anoctl::failed, "", failure.what()};
    }
    found.out = out.str();
    return found;
}

TEST(DetectRate, names_the_only_rate_at_which_valid_frames_arrive) {
    for (const std::uint32_t right : {500000u, 38400u, 256000u, 2400u}) {
        const Speaker speaker{[=](std::uint32_t baud) { return baud == right ? euler : garbage; }};
        const Found found = detect(speaker.path());
        EXPECT_EQ(found.exit, 0) << found.wrong;
        const std::string baud = std::to_string(right);
        EXPECT_EQ(found.out, speaker.path() + ": " + baud + " baud: valid frames from 0xDC\nLink: serial:" + speaker.path() +
                                 ",baud=" + baud + "\n");
        EXPECT_EQ(detect("serial:" + speaker.path() + ",baud=9600", true).out,
                  "{\"device\":\"" + speaker.path() + "\",\"baud\":" + baud + ",\"from\":[220],\"any_rate\":false}\n");
    }
}

TEST(DetectRate, reports_when_no_data_is_received) {
    const support::TempDir folder;
    const support::PtyDevice device{(folder.path() / "tty").string()};
    const Found found = detect(device.path(), false, {moment, moment});
    EXPECT_EQ(found.exit, 1);
    EXPECT_NE(found.wrong.find(": no data received at any of 16 rates; check that the device is powered, RX and TX are crossed"),
              std::string::npos)
        << found.wrong;
}

TEST(DetectRate, reports_data_without_valid_frames) {
    const Speaker speaker{[](std::uint32_t) { return garbage; }};
    const Found found = detect(speaker.path());
    EXPECT_EQ(found.exit, 1);
    EXPECT_NE(found.wrong.find(": data but no valid frames at any of 16 rates; check the protocol"), std::string::npos)
        << found.wrong;
}

TEST(DetectRate, recognizes_frames_of_the_previous_version) {
    const Bytes v7 = support::hex("AA FF 03 07 7B 00 00 00 00 00 01 2F 40");
    const Speaker speaker{[&](std::uint32_t baud) {
        Bytes frame{v7.begin(), v7.end() - 2};
        std::uint8_t sum = 0, add = 0;
        for (const std::uint8_t byte : frame)
            add = static_cast<std::uint8_t>(add + (sum = static_cast<std::uint8_t>(sum + byte)));
        frame.push_back(sum);
        frame.push_back(add);
        if (baud != 115200) return garbage;
        Bytes many;
        while (many.size() + frame.size() < garbage.size()) many.insert(many.end(), frame.begin(), frame.end());
        return many;
    }};
    const Found found = detect(speaker.path());
    EXPECT_NE(found.wrong.find(": older V7 frames (0xAA) at 115200 baud: switch the device to protocol V8"), std::string::npos)
        << found.wrong;
}

TEST(DetectRate, does_not_touch_a_port_that_is_in_use) {
    const support::TempDir folder;
    const support::PtyDevice device{(folder.path() / "tty").string()};
    const support::PortUser user{device.path()};
    ASSERT_EQ(::flock(user.fd(), LOCK_EX | LOCK_NB), 0);
    const Found found = detect(device.path());
    EXPECT_EQ(found.exit, 1);
    EXPECT_NE(found.wrong.find(" is in use by "), std::string::npos) << found.wrong;
    EXPECT_NE(found.wrong.find("(pid " + std::to_string(::getpid()) + ")"), std::string::npos) << found.wrong;
}

TEST(DetectRate, reports_a_path_that_is_not_a_serial_port) {
    EXPECT_EQ(detect("/nowhere/tty").wrong, "/nowhere/tty not found; to list the ports: anoctl ports");
    EXPECT_NE(detect("/dev/null").wrong.find("this is not a serial port"), std::string::npos) << detect("/dev/null").wrong;
    EXPECT_EQ(support::anoctl({"ports", "--detect", "/nowhere/tty"}).exit, 1);
    EXPECT_EQ(support::anoctl({"ports", "--detect"}).exit, 2);
}

TEST(DetectRate, tries_the_rates_of_v8_devices_first_and_each_once) {
    const auto rates = anoctl::usual_rates();
    EXPECT_EQ(rates[0], 500000u);
    EXPECT_EQ(rates[1], 115200u);
    for (std::size_t i = 0; i < rates.size(); ++i)
        for (std::size_t k = 0; k < i; ++k) EXPECT_NE(rates[i], rates[k]);
}

// A flight controller's telemetry at 2400 baud: 13 to 21 bytes per frame, the first one incomplete.
TEST(DetectRate, listens_longer_at_a_slow_rate) {
    const anoctl::ListeningTime time;
    EXPECT_EQ(time.at(500000), time.for_frames);
    EXPECT_EQ(time.at(9600), time.for_frames);
    EXPECT_GE(time.at(2400), std::chrono::milliseconds{1600});
}

TEST(DetectRate, rejects_a_rate_with_only_one_frame_among_noise) {
    anoctl::HeardAtRate heard;
    EXPECT_FALSE(heard.is_right());
    heard.counters.bytes_in = 400;
    heard.counters.skipped_bytes = 385;
    heard.counters.frames_in = 1;
    EXPECT_FALSE(heard.is_right());
    heard.counters.frames_in = 2;
    EXPECT_TRUE(heard.is_right());
    heard.counters = {.frames_in = 1, .bytes_in = 20, .skipped_bytes = 5};
    EXPECT_TRUE(heard.is_right());
}

}    // namespace
}    // namespace detect_rate_tests
