// Recordings on a disk that really hangs, as reported by the routes and the log: a file system in a file, frozen. A program that
// waits for a frozen disk can't be killed, so this runs only in the machine of tests/vm/machine.
#include <support/recorded.hpp>
#include <support/recorded_files.hpp>
#include <support/recording_gateway.hpp>

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace disks_tests {

namespace {

using namespace support;
using nlohmann::json;

// By the gateway's own clock: on a machine that computes 9 to 65 times slower, a request takes long.
constexpr char told[] = "the disk has written nothing for 1 s; frames are still forwarded, but are not recorded";

class Disks : public RecordingGateway {
protected:
    void SetUp() override {
        if (std::getenv("ANOGATE_IN_VM") == nullptr)
            GTEST_SKIP() << "a disk that hangs is for a machine of its own: tests/vm/run disks";
        std::filesystem::create_directories(folder);
        ASSERT_EQ(run("modprobe loop && modprobe ext4 && truncate -s 32M " + image + " && mkfs.ext4 -q -F " + image +
                      " && mount -o loop " + image + " " + folder),
                  0);
        is_mounted_ = true;
    }
    void TearDown() override {
        if (is_frozen_) thaw();
        gateway.reset();
        if (is_mounted_) run("umount " + folder);
    }
    void freeze() {
        ASSERT_EQ(run("fsfreeze -f " + folder), 0);
        is_frozen_ = true;
    }
    void thaw() {
        EXPECT_EQ(run("fsfreeze -u " + folder), 0);
        is_frozen_ = false;
    }
    json running() const { return gateway->status().at("recording").at("running").at(0); }
    bool until_written(int frames) const {
        return until([&](const json& all) { return all.at("running").at(0).at("frames") == frames; });
    }
    bool until_error(const std::string& words) const {
        return gateway->until([&](const json& status) {
            return status.at("recording").at("running").at(0).at("error").get<std::string>().find(words) != std::string::npos;
        });
    }
    bool is_failing() const { return ask("GET", "/metrics").body.find("\nanogate_recording_failing 1\n") != std::string::npos; }
    std::vector<int> recorded(const std::string& name) const {
        std::vector<int> numbers;
        for (const KeptItem& item : read_recording(content(name + ".pcapng")).items) numbers.push_back(number_of(item.frame));
        return numbers;
    }

    const std::string image = "/dev/shm/disk";

private:
    bool is_mounted_ = false, is_frozen_ = false;
};

TEST_F(Disks, that_hang_are_reported_within_a_second_while_forwarding_continues_and_nothing_is_lost) {
    start(R"(, "record": {"free": 0})");
    send_numbered(20);
    ASSERT_TRUE(until_written(20));
    const std::string name = running().at("name");
    freeze();
    send_numbered(50);
    ASSERT_TRUE(until_error("the disk has written nothing for "));
    EXPECT_TRUE(gateway->until_says(told)) << gateway->output();
    EXPECT_TRUE(is_failing());
    send_numbered(50);
    thaw();
    ASSERT_TRUE(until_written(120)) << running();
    EXPECT_TRUE(gateway->until([](const json& status) { return status.at("recording").at("running").at(0).at("error") == ""; }));
    EXPECT_FALSE(is_failing());
    EXPECT_EQ(end(name).at("not_written"), 0);
    EXPECT_EQ(recorded(name), numbers_to(120));
}

TEST_F(Disks, that_hang_delay_the_shutdown_only_in_the_kernel) {
    start(R"(, "record": {"free": 0})");
    send_numbered(20);
    ASSERT_TRUE(until_written(20));
    freeze();
    send_numbered(20);
    ASSERT_TRUE(until_error("the disk has written nothing for "));
    gateway->signal(SIGTERM);
    EXPECT_TRUE(gateway->until_says("the disk does not respond")) << gateway->output();
    EXPECT_TRUE(gateway->until_says("stopping (")) << gateway->output();
    thaw();    // until then the kernel blocks the thread that waits for the disk, and with it the process
    EXPECT_EQ(gateway->wait(), 0) << gateway->output();
}

}    // namespace
}    // namespace disks_tests
