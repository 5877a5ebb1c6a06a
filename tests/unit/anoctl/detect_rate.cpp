#include <gtest/gtest.h>
#include <ano/hex.hpp>
#include <anoctl/own_link.hpp>
#include <anoctl/ports/detect_rate.hpp>
#include <nlohmann/json.hpp>

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
#include <support/line_rate.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>
#include <support/v7_vectors.hpp>

namespace detect_rate_tests {
namespace {

using support::Bytes;
using support::operator+;

const Bytes euler = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});

/// Sends something every few milliseconds that depends on the rate set by its user.
class Speaker {
public:
    explicit Speaker(std::function<Bytes(std::uint32_t baud)> say)
        : device_{(folder_.path() / "tty").string()}, thread_{[this, say = std::move(say)] {
              while (!over_) {
                  device_.write(say(support::rate_of(device_.fd())));
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

/// Sends V7 frames with these ids at 115200 baud, and at other rates what is no frame.
std::function<Bytes(std::uint32_t)> v7_at_115200(const Bytes& ids) {
    return [ids](std::uint32_t baud) {
        if (baud != 115200) return garbage;
        Bytes many;
        while (many.size() < garbage.size())
            for (const std::uint8_t id : ids) many = many + support::v7_frame(0xAF, id, {1, 2, 3, 4, 5, 6, 7});
        return many;
    };
}

TEST(DetectRate, proposes_the_link_of_a_device_with_the_previous_version) {
    struct Sender {
        Bytes ids;
        std::string listed, device;
    };
    for (const Sender& sender : {Sender{{0x03, 0x40, 0xFA}, "0x03, 0x40, 0xFA", "0xDD"},
                                 Sender{{0x34, 0x51, 0x01}, "0x01, 0x34, 0x51", "0xDE"}, Sender{{0xF1}, "0xF1", "0x01"}}) {
        const Speaker speaker{v7_at_115200(sender.ids)};
        const std::string link = "serial:" + speaker.path() + ",baud=115200,protocol=v7,v7_device=" + sender.device +
                                 (sender.device == "0xDD" ? ",attitude=lx" : "");
        const Found found = detect(speaker.path());
        EXPECT_EQ(found.exit, 0) << found.wrong;
        EXPECT_EQ(found.out,
                  speaker.path() + ": 115200 baud: valid frames of the older protocol V7 (0xAA), messages " + sender.listed +
                      "\nLink: " + link +
                      "\nV7 frames have no source: v7_device is a guess from the messages. Set it to the id of your device\n");
        EXPECT_NO_THROW(anoctl::link_settings_of(link)) << "the gateway accepts it";
        const auto json = nlohmann::json::parse(detect(speaker.path(), true).out);
        EXPECT_EQ(json.at("protocol"), "v7");
        EXPECT_EQ(ano::hex_byte(json.at("v7_device").get<std::uint8_t>()), sender.device);
        EXPECT_EQ(json.at("ids").size(), sender.ids.size());
    }
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
