// `anoctl log` and `anoctl image`: from a running gateway, and over a link of their own.
#include <support/bytes.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

namespace anoctl_listening_tests {
namespace {

using namespace support;
using nlohmann::json;

Bytes log_line(std::uint8_t color, const std::string& text) {
    return frame(0xDC, 0xFE, 0xA0, Bytes{color} + Bytes(text.begin(), text.end()));
}
Bytes rows(std::uint16_t flag, const Bytes& pixels) {
    Bytes data{static_cast<std::uint8_t>(flag), 0, 0, 2, 0, 2, 0};
    data.resize(17);
    return frame(0xDF, 0xFE, 0xB0, data + pixels);
}

// The JSON lines in the output.
std::vector<json> told_of(const std::string& output) {
    std::vector<json> told;
    std::istringstream lines{output};
    for (std::string line; std::getline(lines, line);)
        if (line.starts_with("{")) told.push_back(json::parse(line));
    return told;
}

class AnoctlListening : public testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(gateway.until_answers()) << gateway.output(); }
    Process anoctl(std::vector<std::string> words) {
        words.insert(words.end(), {"--control", socket});
        return Process{ANOCTL, std::move(words)};
    }
    /// Sends frames until it shows something: it sees nothing before it is attached.
    bool until_shows(Process& process, const std::string& words, const Bytes& bytes) {
        return wait_until([&] {
            a.send(gateway.port("a"), bytes);
            return process.output().find(words) != std::string::npos;
        });
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    UdpPeer a;
    Daemon gateway{ANOGATED, socket, {a.link("a")}};
};

TEST_F(AnoctlListening, log_shows_lines_and_values_with_time_and_device) {
    Process log = anoctl({"log"});
    EXPECT_TRUE(until_shows(log, " 0xDC low ?battery\n",
                            log_line(1,
                                     "low \x1b"
                                     "battery\r\n")))
        << log.output();
    const Bytes value = frame(0xDC, 0xFE, 0xA1, Bytes{0xCD, 0xCC, 0xCC, 0x3D} + Bytes{'v', 'o', 'l', 't'});
    EXPECT_TRUE(until_shows(log, " 0xDC 0.1 volt\n", value)) << log.output();
    EXPECT_EQ(log.output().find("\x1b["), std::string::npos) << "no colours in a pipe";
    EXPECT_EQ(log.output()[2], ':') << "the time first: " << log.output();
    a.send(gateway.port("a"), frame(0xDC, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 1}));
    EXPECT_TRUE(until_shows(log, "the last", log_line(0, "the last")));
    EXPECT_EQ(log.output().find("euler"), std::string::npos);
    log.signal(SIGINT);
    EXPECT_EQ(log.wait(), 0);
}

TEST_F(AnoctlListening, log_prints_json_of_the_named_devices_only) {
    Process log = anoctl({"log", "--json", "--device", "0xDC"});
    ASSERT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), frame(0xDD, 0xFE, 0xA0, {0, 'x'}));
        a.send(gateway.port("a"), log_line(2, "good"));
        return log.output().find('\n') != std::string::npos;
    }));
    std::istringstream lines{log.output()};
    std::string line;
    std::getline(lines, line);
    const json first = json::parse(line);
    EXPECT_EQ(first.at("from"), 0xDC);
    EXPECT_EQ(first.at("fields").at("str"), "good");
    EXPECT_EQ(first.at("link"), "a");
    Process wrong = anoctl({"log", "--device", "nobody"});
    EXPECT_EQ(wrong.wait(), 2);
    EXPECT_NE(wrong.output().find("nobody"), std::string::npos) << wrong.output();
}

TEST_F(AnoctlListening, log_shows_colours_on_a_terminal) {
    if (std::system("tmux -V > /dev/null 2>&1") != 0) GTEST_SKIP() << "tmux is not installed";
    const auto tmux = [&](const std::string& words) {
        return std::system(("TERM=xterm tmux -S " + (dir / "tmux") + " " + words + " 2>/dev/null").c_str());
    };
    ASSERT_EQ(tmux("-f /dev/null new-session -d -x 100 -y 24 -s log '" ANOCTL " log --control " + socket + "; sleep 60'"), 0);
    const auto screen = [&] {
        Process capture{"tmux", {"-S", dir / "tmux", "capture-pane", "-p", "-e", "-t", "log"}};
        capture.wait();
        return capture.output();
    };
    std::string text;
    EXPECT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), log_line(1, "redline"));
        a.send(gateway.port("a"), log_line(2, "greenline"));
        a.send(gateway.port("a"), log_line(3, "blueline"));
        text = screen();
        return text.find("redline") != std::string::npos && text.find("greenline") != std::string::npos &&
               text.find("blueline") != std::string::npos;    // it may begin with any of them
    })) << text;
    EXPECT_NE(text.find("\x1b[31mredline"), std::string::npos) << text;
    EXPECT_NE(text.find("\x1b[32mgreenline"), std::string::npos) << text;
    EXPECT_NE(text.find("\x1b[34mblueline"), std::string::npos) << text;
    EXPECT_NE(text.find("0xDC flight controller"), std::string::npos) << text;
    tmux("kill-server");
}

// It may start to listen in the middle of a picture, so a part of the first one may be missing.
TEST_F(AnoctlListening, image_writes_whole_pictures_and_reports_missing_rows) {
    Process image = anoctl({"image", dir / "pictures", "--json"});
    std::uint8_t flag = 0;
    EXPECT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), rows(++flag, {1, 2}));
        a.send(gateway.port("a"), rows(flag, {3, 4}));
        return image.output().find("\"whole\":true") != std::string::npos;
    })) << image.output();
    EXPECT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), rows(++flag, {1, 2}));
        const std::string output = image.output();    // incomplete, but not the one in which it started
        return output.find("\"whole\":false", output.find("\"whole\":true")) != std::string::npos;
    })) << image.output();
    image.signal(SIGINT);
    EXPECT_EQ(image.wait(), 0) << image.output();
    const std::vector<json> told = told_of(image.output());
    for (const json& picture : told) {
        const std::string file = picture.at("file");
        EXPECT_TRUE(file.starts_with(dir / "pictures/0xDF-00")) << picture;
        EXPECT_EQ(file.ends_with("-part.png"), !picture.at("whole").get<bool>()) << picture;
        EXPECT_EQ(picture.at("rows"), picture.at("whole").get<bool>() ? 2 : 1) << picture;
        EXPECT_TRUE(std::filesystem::exists(file)) << picture;
    }
    const bool is_joined = !told.front().at("whole").get<bool>();
    EXPECT_NE(image.output().find("anoctl: " + std::to_string(told.size() - is_joined) + " pictures, "), std::string::npos)
        << image.output();
}

TEST_F(AnoctlListening, image_ends_after_the_requested_number_of_pictures) {
    Process image = anoctl({"image", dir / "pictures", "--json", "--count", "2"});
    std::uint8_t flag = 0;
    EXPECT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), rows(++flag, {1, 2, 3, 4}));
        return !image.is_running();
    })) << image.output();
    EXPECT_EQ(image.wait(), 0) << image.output();
    const std::vector<json> told = told_of(image.output());
    ASSERT_EQ(told.size(), 2u) << image.output();
    EXPECT_EQ(told[0].at("file"), dir / "pictures/0xDF-0001.png");
    EXPECT_EQ(told[1].at("file"), dir / "pictures/0xDF-0002.png");
    EXPECT_NE(image.output().find("anoctl: 2 pictures\n"), std::string::npos) << image.output();
}

TEST_F(AnoctlListening, image_reports_the_received_pictures_when_it_is_interrupted) {
    Process image = anoctl({"image", dir.path().string()});
    std::uint8_t flag = 0;
    EXPECT_TRUE(wait_until([&] {
        a.send(gateway.port("a"), rows(++flag, {1, 2}));
        return image.output().find("0xDF-0001-part.png: 0xDF 2x2 grey, 1 of 2 rows received\n") != std::string::npos;
    })) << image.output();
    image.signal(SIGINT);
    EXPECT_EQ(image.wait(), 0);
    EXPECT_NE(image.output().find(" of them incomplete"), std::string::npos) << image.output();
}

TEST_F(AnoctlListening, image_reports_why_it_cannot_write) {
    Process image = anoctl({"image", dir.write("file", "") + "/pictures"});
    EXPECT_EQ(image.wait(), 1);
    EXPECT_NE(image.output().find("cannot create"), std::string::npos) << image.output();
    Process missing = anoctl({"image"});
    EXPECT_EQ(missing.wait(), 2);
}

TEST(AnoctlOwnLink, log_and_image_receive_over_a_link_without_a_gateway) {
    TempDir dir;
    PtyDevice device{dir / "tty"};
    {
        Process log{ANOCTL, {"log", "--link", "serial:" + device.path() + ",encoding=gbk"}};
        ASSERT_TRUE(log.until_says(" is up"));
        device.write(frame(0xDC, 0xFE, 0xA0, {0, 0xC4, 0xA3}));    // in GBK one character, in UTF-8 another
        EXPECT_TRUE(log.until_says(" 0xDC 模\n")) << log.output();
        log.signal(SIGINT);
        EXPECT_EQ(log.wait(), 0) << log.output();
    }
    Process image{ANOCTL, {"image", dir / "pictures", "--count", "1", "--link", "serial:" + device.path()}};
    ASSERT_TRUE(image.until_says(" is up"));
    device.write(rows(1, {1, 2, 3, 4}));
    EXPECT_EQ(image.wait(), 0);
    EXPECT_TRUE(std::filesystem::exists(dir / "pictures/0xDF-0001.png")) << image.output();
    Process nowhere{ANOCTL, {"log", "--link", "sim:fc,bad=1"}};
    EXPECT_EQ(nowhere.wait(), 2);
}

TEST(AnoctlOwnLink, image_does_not_count_a_picture_whose_beginning_it_missed) {
    TempDir dir;
    PtyDevice device{dir / "tty"};
    std::filesystem::create_directory(dir / "pictures");
    dir.write("pictures/0xDF-0001-part.png", "old");
    dir.write("pictures/0xDF-0003.png", "old");
    Process image{ANOCTL, {"image", dir / "pictures", "--count", "1", "--link", "serial:" + device.path()}};
    ASSERT_TRUE(image.until_says(" is up"));
    device.write(rows(1, {3, 4}) + rows(2, {1, 2}) + rows(2, {3, 4}));
    EXPECT_EQ(image.wait(), 0);
    const auto contains = [&](const std::string& words) { return image.output().find(words) != std::string::npos; };
    EXPECT_TRUE(contains(dir / "pictures/0xDF-0002-part.png: 0xDF 2x2 grey, 1 of 2 rows received\n")) << image.output();
    EXPECT_TRUE(contains(dir / "pictures/0xDF-0004.png: 0xDF 2x2 grey\n")) << image.output();
    EXPECT_TRUE(contains("anoctl: 1 picture; and the end of 1 picture that probably started earlier\n")) << image.output();
}

}    // namespace
}    // namespace anoctl_listening_tests
