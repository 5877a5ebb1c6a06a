// The recorder of a gateway: frames are taken by the loop, files are written by its thread; the disk works, is full, is
// read-only, or hangs.
#include <record/recording_repair.hpp>
#include <recording/recorder.hpp>
#include <sys/thread_queue.hpp>
#include <watch/frame_watch.hpp>

#include <support/failing_disk_calls.hpp>
#include <support/recorded_files.hpp>
#include <support/running_gateway.hpp>
#include <support/small_disk.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace recorder_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
namespace fs = std::filesystem;
using support::Bytes;
using support::failing_disk;

TEST(ThreadQueue, passes_all_items_in_order_between_two_threads) {
    ThreadQueue<std::shared_ptr<int>> queue{8};
    constexpr int all = 20'000;
    std::thread other{[&] {
        for (int n = 0; n < all;) {
            if (queue.push(std::make_shared<int>(n))) ++n;
            else std::this_thread::yield();
        }
    }};
    for (int n = 0; n < all;) {
        const auto item = queue.pop();
        if (!item) {
            std::this_thread::yield();
            continue;
        }
        ASSERT_EQ(**item, n);
        ++n;
    }
    other.join();
}

/// A numbered frame with additional bytes.
Bytes large(int number) {
    Bytes data(1000, 0x55);
    for (int i = 0; i < 4; ++i) data[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(number >> 8 * i);
    return support::frame(0xDC, 0xFF, 0xF1, data);
}

class RecorderTest : public testing::Test {
protected:
    RecorderTest() {
        settings.folder = dir / "recordings";
        settings.name = "flight";
        settings.keep_free = 0;
        settings.filter.directions = {true, false, false};
    }
    void SetUp() override { ASSERT_TRUE(gateway.until_up("a") && gateway.until_up("b")); }

    Recorder& start() {
        recorder = std::make_unique<Recorder>(gateway.gateway(), watch, settings, [this] { ++changes; });
        EXPECT_TRUE(gateway.until([&] { return !recorder->report().file.empty() || !recorder->report().fault.empty(); }));
        return *recorder;
    }
    /// Sends frames, several with each datagram.
    void send(int frames, bool are_large = false) {
        for (const int end = sent + frames; sent < end;) {
            Bytes datagram;
            for (int i = 0; i < 30 && sent < end; ++i, ++sent)
                datagram = support::operator+(std::move(datagram), are_large ? large(sent) : support::numbered(0xDC, 0xFF, sent));
            a.send(gateway.port("a"), datagram);
            ASSERT_TRUE(gateway.until([&] { return gateway.count("a", "frames_in") == static_cast<std::uint64_t>(sent); }));
        }
    }
    bool until_ended() {
        return gateway.until([&] { return recorder->report().is_ended; });
    }
    bool until_written(int frames) {
        return gateway.until([&] { return recorder->report().frames == static_cast<std::uint64_t>(frames); });
    }
    bool until_error(const std::string& text, ano::Duration limit = support::patience) {
        return gateway.until([&] { return recorder->report().fault.text().find(text) != std::string::npos; }, limit);
    }
    bool until_well() {
        return gateway.until([&] { return recorder->report().fault.empty(); });
    }
    support::RecordedFiles files() const { return support::recorded_files(settings.folder, settings.name); }

    const support::TempDir dir;
    const support::WellAgain well_again{};
    support::UdpPeer a, b;
    support::RunningGateway gateway{support::settings_of_texts({a.link("a"), b.link("b")})};
    FrameWatch watch{gateway.gateway()};
    RecorderSettings settings;
    std::unique_ptr<Recorder> recorder;
    int sent = 0;
    int changes = 0;
};
using RecorderOfGateway = RecorderTest;

TEST_F(RecorderOfGateway, writes_all_frames_received_until_it_is_ended) {
    start();
    send(500);
    recorder->end();
    send(100);
    ASSERT_TRUE(until_ended());
    const auto written = files();
    EXPECT_EQ(written.numbers, support::numbers_to(500));
    EXPECT_TRUE(written.are_whole());
    ASSERT_FALSE(written.files.at(0).items.empty());
    const support::KeptItem& first = written.files[0].items.front();
    EXPECT_EQ(first.link + " " + first.description, "a udp");
    EXPECT_NE(first.peer, "");
    const RecorderReport report = recorder->report();
    EXPECT_EQ(report.file, settings.folder + "/flight.pcapng");
    EXPECT_EQ(report.frames, 500u);
    EXPECT_EQ(report.files, 1u);
    EXPECT_EQ(report.bytes, fs::file_size(report.file));
    EXPECT_EQ(report.not_written, 0u);
    EXPECT_EQ(report.fault.text(), "");
    EXPECT_TRUE(gateway.until([&] { return changes >= 2; })) << "a file began, and all is ended";
}

TEST_F(RecorderOfGateway, a_frame_is_written_to_the_file_soon_and_before_the_recording_ends) {
    start();
    send(1);
    ASSERT_TRUE(until_written(1));
    EXPECT_EQ(files().numbers, support::numbers_to(1));
    EXPECT_FALSE(files().are_whole());
}

TEST_F(RecorderOfGateway, loses_nothing_when_the_next_file_begins) {
    settings.rotate_bytes = 50'000;
    start();
    send(12'000);
    recorder->end();
    ASSERT_TRUE(until_ended());
    EXPECT_EQ(files().numbers, support::numbers_to(12'000));
    EXPECT_TRUE(files().are_whole());
    EXPECT_GE(files().files.size(), 2u);
    EXPECT_EQ(recorder->report().files, files().files.size());
}

TEST_F(RecorderOfGateway, counts_a_file_when_its_name_is_known) {
    recorder = std::make_unique<Recorder>(gateway.gateway(), watch, settings, [] {});
    ASSERT_TRUE(support::wait_until([&] { return recorder->report().bytes > 0; })) << "the loop did not hear of it yet";
    EXPECT_EQ(recorder->report().files, recorder->report().file.empty() ? 0u : 1u);
    ASSERT_TRUE(gateway.until([&] { return recorder->report().files == 1; }));
    EXPECT_EQ(recorder->report().file, settings.folder + "/flight.pcapng");
}

TEST_F(RecorderOfGateway, can_be_destroyed_by_its_callback_at_the_end) {
    recorder = std::make_unique<Recorder>(gateway.gateway(), watch, settings, [this] {
        if (recorder->report().is_ended) recorder.reset();
    });
    send(10);
    recorder->end();
    EXPECT_TRUE(gateway.until([&] { return !recorder; }));
    EXPECT_EQ(files().numbers, support::numbers_to(10));
}

TEST_F(RecorderOfGateway, writes_waiting_frames_when_it_is_destroyed) {
    start();
    send(200);
    recorder.reset();
    EXPECT_EQ(files().numbers, support::numbers_to(200));
    EXPECT_TRUE(files().are_whole());
}

TEST_F(RecorderOfGateway, its_thread_has_a_lower_priority_than_the_loop_and_blocks_signals) {
    ::setpriority(PRIO_PROCESS, 0, 0);    // if the test runs nice and may not change that, it proves nothing
    start();
    std::string found;
    for (const auto& task : fs::directory_iterator{"/proc/self/task"}) {
        if (support::file_text(task.path() / "comm") != "recorder\n") continue;
        found = support::file_text(task.path() / "status");
        EXPECT_GE(::getpriority(PRIO_PROCESS, static_cast<id_t>(std::stoi(task.path().filename().string()))), 5);
    }
    const auto at = found.find("SigBlk:");
    ASSERT_NE(at, std::string::npos);
    const auto blocked = std::stoull(found.substr(at + 7), nullptr, 16);
    for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGUSR1, SIGXFSZ}) EXPECT_TRUE(blocked >> (signal - 1) & 1) << signal;
}

TEST_F(RecorderOfGateway, a_disk_that_hangs_is_reported_within_a_second_and_delays_no_frame) {
    start();
    send(30);
    ASSERT_TRUE(until_written(30));
    failing_disk.hangs = true;
    const auto begin = ano::Clock::now();
    const int changes_before = changes;
    send(30);
    ASSERT_TRUE(until_error("the disk has written nothing for 1 s", 5s));
    EXPECT_LT(ano::Clock::now() - begin, 2s) << "a second, and what a busy machine needs";
    EXPECT_TRUE(gateway.until([&] { return changes > changes_before; }));
    b.forget();
    send(60);
    EXPECT_TRUE(gateway.until([&] { return !b.heard().empty(); }));
    failing_disk.hangs = false;
    ASSERT_TRUE(until_well());
    ASSERT_TRUE(until_written(120)) << recorder->report().frames;
    EXPECT_EQ(files().numbers, support::numbers_to(120));
    EXPECT_EQ(recorder->report().not_written, 0u);
}

TEST_F(RecorderOfGateway, frames_that_do_not_fit_while_a_disk_hangs_are_counted_and_reported_in_the_file) {
    start();
    failing_disk.hangs = true;
    send(25'000, true);    // 25 MB, while 17 MiB can be queued
    const std::uint64_t lost = recorder->report().not_written;
    EXPECT_GT(lost, 5000u);
    EXPECT_LT(lost, 10'000u);
    failing_disk.hangs = false;
    ASSERT_TRUE(until_written(sent - static_cast<int>(lost))) << recorder->report().frames << " " << lost;
    send(300, true);
    recorder->end();
    ASSERT_TRUE(until_ended());
    const auto written = files();
    EXPECT_EQ(written.lost, lost);
    EXPECT_EQ(written.names, "flexible1 " + std::to_string(lost));
    EXPECT_EQ(recorder->report().not_written, lost);
    EXPECT_EQ(recorder->report().frames, static_cast<std::uint64_t>(sent) - lost);
    EXPECT_TRUE(written.are_whole());
    std::vector<int> wanted = support::numbers_to(sent);    // one range is missing
    const auto gap = wanted.begin() + (sent - 300 - static_cast<int>(lost));
    wanted.erase(gap, gap + static_cast<int>(lost));
    EXPECT_EQ(written.numbers, wanted);
}

TEST_F(RecorderOfGateway, a_disk_that_is_too_slow_is_reported_and_missing_frames_are_counted) {
    start();
    failing_disk.slowness = 200;
    const int changes_before = changes;
    while (recorder->report().not_written == 0 && sent < 60'000) send(300, true);
    const auto begin = ano::Clock::now();
    ASSERT_TRUE(until_error("the disk is too slow; frames are being lost", 5s)) << recorder->report().fault.text();
    EXPECT_LT(ano::Clock::now() - begin, 2s);
    EXPECT_TRUE(recorder->report().is_slow && recorder->report().loses);
    EXPECT_TRUE(gateway.until([&] { return changes > changes_before; }));
    b.forget();
    send(30);
    EXPECT_TRUE(gateway.until([&] { return !b.heard().empty(); }));
    failing_disk.slowness = 0;
    recorder->end();
    ASSERT_TRUE(until_ended());
    const RecorderReport report = recorder->report();
    EXPECT_EQ(report.fault.text(), "");
    EXPECT_GT(report.not_written, 0u);
    EXPECT_EQ(report.frames + report.not_written, static_cast<std::uint64_t>(sent));
    const auto written = files();
    EXPECT_EQ(written.lost, report.not_written);
    EXPECT_EQ(written.numbers.size(), report.frames);
    EXPECT_TRUE(std::is_sorted(written.numbers.begin(), written.numbers.end()));
}

TEST_F(RecorderOfGateway, a_disk_a_second_late_is_reported_before_a_frame_is_lost) {
    start();
    failing_disk.slowness = 600;    // less than the time after which a disk is reported as hanging
    const auto begin = ano::Clock::now();
    while (recorder->report().fault.empty() && ano::Clock::now() - begin < 20s) send(3);
    EXPECT_EQ(recorder->report().fault.text(), "the disk is too slow; frames are waiting");
    EXPECT_TRUE(recorder->report().is_slow);
    EXPECT_FALSE(recorder->report().loses);
    EXPECT_GT(recorder->report().waiting, 0u);
    EXPECT_EQ(recorder->report().not_written, 0u);
    failing_disk.slowness = 0;
    recorder->end();
    ASSERT_TRUE(until_ended());
    EXPECT_EQ(recorder->report().frames, static_cast<std::uint64_t>(sent));
    EXPECT_EQ(recorder->report().waiting, 0u);
}

TEST_F(RecorderOfGateway, a_refused_recording_leaves_no_file_even_if_the_disk_works_again) {
    dir.write("recordings", "a file where the folder belongs");
    start();
    ASSERT_NE(recorder->report().fault.text(), "");
    fs::remove(dir / "recordings");
    recorder->refuse();
    ASSERT_TRUE(until_ended());
    EXPECT_EQ(recorder->report().files, 0u);
    EXPECT_FALSE(fs::exists(dir / "recordings"));
}

TEST_F(RecorderOfGateway, a_disk_that_hangs_does_not_delay_the_end) {
    start();
    failing_disk.hangs = true;
    send(30);
    ASSERT_TRUE(gateway.until([&] { return failing_disk.hanging > 0; }));
    auto begin = ano::Clock::now();
    recorder.reset();
    EXPECT_LT(ano::Clock::now() - begin, 1s);
    EXPECT_GE(ano::Clock::now() - begin, 400ms) << "it might have been slow";
    start();
    ASSERT_TRUE(until_error("the disk has written nothing"));
    begin = ano::Clock::now();
    recorder.reset();
    EXPECT_LT(ano::Clock::now() - begin, 200ms) << "it is known to hang";
    start();
    recorder->end();
    ASSERT_TRUE(until_error("the disk has written nothing"));
    EXPECT_FALSE(recorder->report().is_ended);
    recorder.reset();
    EXPECT_LT(gateway.stop(), 2s);
    failing_disk.hangs = false;
    EXPECT_TRUE(support::wait_until([&] {
        const auto left = files();
        return left.are_whole() && left.files.size() == 3;
    })) << "who was left behind ends the file";
}

TEST_F(RecorderOfGateway, a_full_disk_is_reported_and_waiting_frames_are_written_when_there_is_space) {
    fs::create_directories(settings.folder);
    const support::SmallDisk disk{settings.folder, "64m"};
    if (!disk.why_not().empty()) GTEST_SKIP() << disk.why_not();
    start();
    send(30);
    ASSERT_TRUE(until_written(30));
    {
        std::ofstream filler{settings.folder + "/filler"};
        while (filler << std::string(65536, '.') << std::flush) {}
        filler.clear();
        while (filler << std::string(512, '.') << std::flush) {}    // uses the rest of the space
    }
    const auto begin = ano::Clock::now();
    const int changes_before = changes;
    while (recorder->report().fault.empty() && ano::Clock::now() - begin < 10s) send(30);
    EXPECT_TRUE(until_error("flight.pcapng: No space left on device"));
    EXPECT_TRUE(gateway.until([&] { return changes > changes_before; }));
    EXPECT_FALSE(files().numbers.empty());
    EXPECT_EQ(files().files.at(0).unfinished, 0u) << "no half frame";
    b.forget();
    send(30);
    EXPECT_TRUE(gateway.until([&] { return !b.heard().empty(); }));
    fs::remove(settings.folder + "/filler");
    ASSERT_TRUE(until_well());
    recorder->end();
    ASSERT_TRUE(until_ended());
    EXPECT_EQ(files().numbers, support::numbers_to(sent));
    EXPECT_EQ(files().files.size(), 1u);
    EXPECT_TRUE(files().are_whole());
    EXPECT_EQ(recorder->report().not_written, 0u);
}

TEST_F(RecorderOfGateway, a_lack_of_memory_is_reported_and_waiting_frames_are_written_afterwards) {
    start();
    send(100);
    ASSERT_TRUE(until_written(100));
    failing_disk.lacks_memory = true;
    send(100);
    ASSERT_TRUE(until_error("out of memory")) << recorder->report().fault.text();
    failing_disk.lacks_memory = false;
    ASSERT_TRUE(until_well());
    recorder->end();
    ASSERT_TRUE(until_ended());
    EXPECT_EQ(files().numbers, support::numbers_to(200));
    EXPECT_EQ(recorder->report().not_written, 0u);
}

TEST_F(RecorderOfGateway, keeps_some_of_the_disk_free) {
    fs::create_directories(settings.folder);
    const support::SmallDisk disk{settings.folder, "16m"};
    if (!disk.why_not().empty()) GTEST_SKIP() << disk.why_not();
    settings.keep_free = 8'000'000;
    start();
    while (recorder->report().fault.empty() && sent < 20'000) send(300, true);
    EXPECT_TRUE(until_error("of disk space is free, and recording needs 13.2 MB: "));
    const std::string error = recorder->report().fault.text();
    send(3000, true);
    recorder->end();
    ASSERT_TRUE(until_ended());
    EXPECT_GE(fs::space(settings.folder).available, settings.keep_free);
    EXPECT_GT(recorder->report().frames, 1000u) << error;
    EXPECT_EQ(recorder->report().frames + recorder->report().not_written, static_cast<std::uint64_t>(sent));
    EXPECT_EQ(files().numbers, support::numbers_to(static_cast<int>(recorder->report().frames)));
    EXPECT_TRUE(files().are_whole()) << "what was to stay free is enough to end it";
}

TEST_F(RecorderOfGateway, a_read_only_disk_is_reported_and_retried) {
    fs::create_directories(settings.folder);
    const support::SmallDisk disk{settings.folder, "1m"};
    if (!disk.why_not().empty() || !disk.read_only(true)) GTEST_SKIP() << disk.why_not();
    start();
    EXPECT_EQ(recorder->report().fault.text(), settings.folder + "/flight.pcapng: Read-only file system");
    send(60);
    ASSERT_TRUE(disk.read_only(false));
    ASSERT_TRUE(until_well());
    ASSERT_TRUE(until_written(60));
    recorder->end();
    ASSERT_TRUE(until_ended());
    EXPECT_EQ(files().numbers, support::numbers_to(60));
}

TEST_F(RecorderOfGateway, a_folder_that_is_removed_is_made_again_for_the_next_file) {
    start();
    send(30);
    ASSERT_TRUE(until_written(30));
    fs::remove_all(settings.folder);
    ASSERT_TRUE(gateway.until([&] { return recorder->report().file == settings.folder + "/flight-2.pcapng"; }));
    send(30);
    recorder->end();
    ASSERT_TRUE(until_ended());
    const auto next = support::read_pcapng(support::file_text(settings.folder + "/flight-2.pcapng"));
    ASSERT_FALSE(next.items.empty());
    EXPECT_EQ(support::number_of(next.items.back().frame), 59);
}

TEST_F(RecorderOfGateway, frames_that_waited_during_a_fault_do_not_count_as_a_sign_of_a_slow_disk) {
    std::ofstream{settings.folder} << "no folder";
    start();
    ASSERT_NE(recorder->report().fault.text(), "");
    const auto send_for = [&](ano::Duration time, const auto& look) {
        for (const auto end = ano::Clock::now() + time; ano::Clock::now() < end;) {
            ASSERT_NO_FATAL_FAILURE(send(3));
            gateway.until([] { return false; }, 10ms);
            ASSERT_NO_FATAL_FAILURE(look());
        }
    };
    ASSERT_NO_FATAL_FAILURE(send_for(1500ms, [] {}));
    fs::remove(settings.folder);
    ASSERT_NO_FATAL_FAILURE(send_for(2s, [&] { ASSERT_FALSE(recorder->report().is_slow); }));
    EXPECT_EQ(recorder->report().fault.text(), "");
    recorder->end();
    ASSERT_TRUE(until_ended());
    EXPECT_EQ(files().numbers, support::numbers_to(sent));
}

/// A process with a gateway that records the frames received on the port that it reports.
class OtherProcess {
public:
    explicit OtherProcess(const std::string& folder) {
        int ends[2];
        if (::pipe(ends) != 0 || (pid_ = ::fork()) < 0) throw std::runtime_error{"no process"};
        if (pid_ == 0) record(folder, ends[1]);
        ::close(ends[1]);
        if (::read(ends[0], &port, sizeof port) != sizeof port) throw std::runtime_error{"it did not start"};
        ::close(ends[0]);
    }
    ~OtherProcess() { kill(); }
    OtherProcess(const OtherProcess&) = delete;
    OtherProcess& operator=(const OtherProcess&) = delete;
    void kill() {
        if (pid_ <= 0) return;
        ::kill(pid_, SIGKILL);
        ::waitpid(std::exchange(pid_, 0), nullptr, 0);
    }

    std::uint16_t port = 0;

private:
    [[noreturn]] static void record(const std::string& folder, int tell) {
        support::RunningGateway gateway{support::settings_of_texts({"udp-listen:127.0.0.1:0,name=a"})};
        FrameWatch watch{gateway.gateway()};
        RecorderSettings settings;
        settings.folder = folder;
        settings.name = "flight";
        settings.keep_free = 0;
        settings.filter.directions = {true, false, false};
        const Recorder recorder{gateway.gateway(), watch, settings, [] {}};
        gateway.until([&] { return gateway.up("a") && !recorder.report().file.empty(); });
        const std::uint16_t port = gateway.port("a");
        if (::write(tell, &port, sizeof port) == sizeof port) gateway.until([] { return false; }, 60s);
        ::_exit(0);
    }

    pid_t pid_ = 0;
};

TEST(RecorderOfProcess, that_is_killed_has_written_all_but_the_last_second) {
    const support::TempDir dir;
    OtherProcess other{dir / "recordings"};
    support::UdpPeer peer;
    std::vector<ano::TimePoint> sent;
    for (const auto end = ano::Clock::now() + 1500ms; ano::Clock::now() < end; std::this_thread::sleep_for(2ms)) {
        peer.send(other.port, support::numbered(0xDC, 0xFF, static_cast<int>(sent.size())));
        sent.push_back(ano::Clock::now());
    }
    const auto killed = ano::Clock::now();
    other.kill();
    const std::string path = dir / "recordings/flight.pcapng";
    const auto written = support::recorded_files(dir / "recordings", "flight");
    const auto must = std::count_if(sent.begin(), sent.end(), [&](auto at) { return at < killed - 1s; });
    EXPECT_GT(must, 50);
    EXPECT_GE(static_cast<std::ptrdiff_t>(written.numbers.size()), must);
    EXPECT_EQ(written.numbers, support::numbers_to(static_cast<int>(written.numbers.size())));
    RecordingRepair repair{RecordingFormat::pcapng};
    repair.feed(support::file_text(path));
    const auto repaired = repair.finish();
    EXPECT_TRUE(repaired.is_recording);
    EXPECT_FALSE(repaired.is_whole);
    EXPECT_GE(repaired.frames, written.numbers.size());
}

}    // namespace
}    // namespace recorder_tests
