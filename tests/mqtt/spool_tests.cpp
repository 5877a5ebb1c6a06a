// Records on the disk: what was written survives kill -9, a full disk loses nothing but is reported, and a damaged file is set aside.
#include <mqtt/seen_records.hpp>
#include <mqtt/spool.hpp>
#include <mqtt/spool_thread.hpp>

#include <support/loop.hpp>
#include <support/small_disk.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace spool_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

constexpr std::uint64_t now_s = 1'700'000'000;

Batch batch(std::uint64_t number, Keep keep = Keep::normal, std::size_t size = 100, std::uint64_t time_s = now_s) {
    Batch made{keep, 10, time_s, std::to_string(number) + ' '};
    made.body.resize(size, 'x');
    return made;
}

struct Disk {
    support::TempDir dir;
    std::vector<std::string> reports;

    Expected<Spool> open(const SpoolLimits& limits = {}) {
        return Spool::open(dir / "spool", limits, [this](const std::string& text) { reports.push_back(text); });
    }
    std::string file() const { return dir / "spool/spool.db"; }
};

/// The numbers of all batches, which are removed, in the order in which they would be published.
std::vector<std::uint64_t> numbers(Spool& spool) {
    std::vector<std::uint64_t> all;
    while (const auto next = spool.next()) {
        all.push_back(std::stoull(next->batch.body));
        if (!spool.write({}, std::vector{next->id}, now_s)) break;
    }
    return all;
}

using Numbers = std::vector<std::uint64_t>;

TEST(MqttSpool, returns_the_oldest_batch_of_the_highest_class_until_it_is_removed) {
    Disk disk;
    auto spool = disk.open();
    ASSERT_TRUE(spool) << spool.error();
    ASSERT_TRUE(spool->write(std::vector{batch(1, Keep::low), batch(2), batch(3), batch(4, Keep::high)}, {}, now_s));
    EXPECT_EQ(spool->records(), 40u);
    EXPECT_EQ(spool->next()->id, spool->next()->id);
    EXPECT_EQ(numbers(*spool), (Numbers{4, 2, 3, 1}));
    EXPECT_EQ(spool->records(), 0u);
    EXPECT_TRUE(disk.reports.empty());
}

TEST(MqttSpool, keeps_its_batches_over_a_restart) {
    Disk disk;
    {
        auto spool = disk.open();
        ASSERT_TRUE(spool->write(std::vector{batch(1), batch(2, Keep::high, 60'000)}, {}, now_s));
        EXPECT_FALSE(disk.open()) << "another program uses it";
    }
    auto spool = disk.open();
    ASSERT_TRUE(spool);
    EXPECT_EQ(spool->records(), 20u);
    const auto next = spool->next();
    EXPECT_EQ(next->batch.body.size(), 60'000u);
    EXPECT_EQ(next->batch.keep, Keep::high);
    EXPECT_EQ(next->batch.records, 10u);
    EXPECT_EQ(next->batch.time_s, now_s);
}

TEST(MqttSpool, drops_the_oldest_of_the_lowest_class_when_it_is_full_and_counts_them) {
    Disk disk;
    auto spool = disk.open({.bytes = 1 << 20});
    ASSERT_TRUE(spool);
    std::uint64_t number = 0;
    for (int i = 0; i < 10; ++i)
        ASSERT_TRUE(
            spool->write(std::vector{batch(++number, Keep::high, 10'000), batch(++number, Keep::low, 10'000)}, {}, now_s));
    for (int i = 0; i < 100; ++i) {
        ASSERT_TRUE(spool->write(std::vector{batch(++number, Keep::normal, 20'000)}, {}, now_s));
        EXPECT_LE(spool->bytes(), 1u << 20);
    }
    EXPECT_LE(std::filesystem::file_size(disk.file()), (1u << 20) + (128u << 10));
    const std::uint64_t dropped = spool->dropped();
    const Numbers left = numbers(*spool);
    EXPECT_EQ((left.size() + dropped / 10), 120u);
    EXPECT_EQ((Numbers{left.begin(), left.begin() + 10}), (Numbers{1, 3, 5, 7, 9, 11, 13, 15, 17, 19})) << "the highest class";
    EXPECT_EQ(left.back(), number) << "the newest";
    EXPECT_GE(left[10], 21u) << "none of the lowest class";
}

TEST(MqttSpool, drops_what_is_too_old) {
    Disk disk;
    auto spool = disk.open({.age_s = 3600});
    ASSERT_TRUE(
        spool->write(std::vector{batch(1, Keep::high, 100, now_s - 3601), batch(2), batch(3, Keep::low, 100, 60)}, {}, now_s));
    EXPECT_EQ(spool->dropped(), 10u);
    EXPECT_EQ(numbers(*spool), (Numbers{2, 3})) << "3 was written before the clock was set";
}

TEST(MqttSpool, a_batch_that_was_dropped_while_it_was_in_flight_removes_no_other) {
    Disk disk;
    auto spool = disk.open({.age_s = 3600});
    ASSERT_TRUE(spool->write(std::vector{batch(1)}, {}, now_s));
    const std::int64_t in_flight = spool->next()->id;
    ASSERT_TRUE(spool->write({}, {}, now_s + 3601));
    ASSERT_TRUE(spool->write(std::vector{batch(2, Keep::normal, 100, now_s + 3601)}, {}, now_s + 3601));
    spool->remove_later(in_flight);
    ASSERT_TRUE(spool->write({}, {}, now_s + 3601));
    EXPECT_EQ(numbers(*spool), Numbers{2});
}

TEST(MqttSpool, a_damaged_file_is_set_aside_and_reported) {
    for (const bool is_open : {false, true}) {
        Disk disk;
        auto spool = disk.open();
        for (std::uint64_t i = 0; i < 50; ++i) ASSERT_TRUE(spool->write(std::vector{batch(i, Keep::normal, 20'000)}, {}, now_s));
        spool = Unexpected{""};
        if (is_open) spool = disk.open();
        {
            std::fstream file{disk.file(), std::ios::in | std::ios::out | std::ios::binary};
            for (int page = is_open ? 1 : 0; page < 40; ++page) file.seekp(page * 4096) << std::string(4000, 'D');
        }
        if (is_open) {
            for (int i = 0; i < 100 && disk.reports.empty(); ++i)
                if (const auto next = spool->next()) spool->remove_later(next->id);
        } else {
            spool = disk.open();
        }
        ASSERT_EQ(disk.reports.size(), 1u) << is_open;
        EXPECT_NE(disk.reports[0].find("was damaged"), std::string::npos);
        ASSERT_TRUE(spool);
        ASSERT_TRUE(spool->write(std::vector{batch(7)}, {}, now_s));
        EXPECT_EQ(numbers(*spool), Numbers{7});
        const bool is_kept = std::any_of(std::filesystem::directory_iterator{disk.dir / "spool"}, {}, [](const auto& entry) {
            return entry.path().filename().string().starts_with("damaged-");
        });
        EXPECT_TRUE(is_kept);
    }
}

TEST(MqttSpool, a_file_that_is_no_database_is_set_aside) {
    Disk disk;
    std::filesystem::create_directories(disk.dir / "spool");
    disk.dir.write("spool/spool.db", std::string(100'000, 'x'));
    auto spool = disk.open();
    ASSERT_TRUE(spool) << spool.error();
    EXPECT_EQ(disk.reports.size(), 1u);
}

TEST(MqttSpool, a_request_is_begun_once_even_over_a_restart) {
    Disk disk;
    {
        auto spool = disk.open();
        EXPECT_TRUE(spool->begin_request("shore/a", now_s).value());
        EXPECT_FALSE(spool->begin_request("shore/a", now_s).value());
        EXPECT_TRUE(spool->begin_request("shore/b", now_s).value());
        EXPECT_TRUE(spool->end_request("shore/b", "{}"));
    }
    auto spool = disk.open();
    EXPECT_EQ(spool->requests(), (std::vector<KnownRequest>{{"shore/a", ""}, {"shore/b", "{}"}}));
    ASSERT_TRUE(spool->write({}, {}, now_s + 3 * 3600));
    EXPECT_TRUE(spool->requests().empty());
}

/// Writes batches in a child process that reports the number of each on a pipe once it is written, and kills it after `time`. Returns
/// the last number.
std::uint64_t write_and_kill(const std::string& folder, std::uint64_t first, std::chrono::microseconds time) {
    int pipe[2];
    if (::pipe2(pipe, O_CLOEXEC) != 0) return 0;
    const pid_t child = ::fork();
    if (child == 0) {
        auto spool = Spool::open(folder, {}, [](auto) {});
        if (!spool) ::_exit(1);
        for (std::uint64_t number = first;; ++number) {
            if (!spool->write(std::vector{batch(number, Keep::normal, 500 + number * 7919 % 5000)}, {}, now_s)) ::_exit(1);
            if (::write(pipe[1], &number, sizeof number) < 0) ::_exit(1);
        }
    }
    ::close(pipe[1]);
    std::uint64_t last = 0;
    if (::read(pipe[0], &last, sizeof last) == sizeof last) std::this_thread::sleep_for(time);
    ::kill(child, SIGKILL);
    while (::read(pipe[0], &last, sizeof last) == sizeof last) {}
    ::close(pipe[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
    return last;
}

TEST(MqttSpool, kill_at_any_moment_loses_nothing_that_was_written) {
    Disk disk;
    std::mt19937 random{7};
    std::uint64_t next = 1;
    for (int round = 0; round < 30; ++round) {
        const std::uint64_t last = write_and_kill(disk.dir / "spool", next, std::chrono::microseconds{random() % 20'000});
        ASSERT_GE(last, next);
        auto spool = disk.open();
        ASSERT_TRUE(spool) << spool.error();
        const Numbers found = numbers(*spool);
        for (std::uint64_t number = next; number <= last; ++number) ASSERT_EQ(found.at(number - next), number);
        ASSERT_LE(found.size(), last - next + 2);    // one may have been written and not reported
        next = next + found.size();
    }
    EXPECT_TRUE(disk.reports.empty());
}

TEST(MqttSpool, a_full_disk_is_an_error_and_loses_nothing_that_was_written) {
    support::TempDir dir;
    const support::SmallDisk small{dir.path().string(), "1m"};
    if (!small.why_not().empty()) GTEST_SKIP() << small.why_not();
    auto spool = Spool::open(dir / "spool", {}, [](auto) {});
    ASSERT_TRUE(spool) << spool.error();
    std::uint64_t written = 0;
    Expected<void> result;
    while ((result = spool->write(std::vector{batch(written + 1, Keep::normal, 20'000)}, {}, now_s)) && written < 200) ++written;
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().find("full"), std::string::npos) << result.error();
    EXPECT_GE(written, 10u);
    EXPECT_EQ(spool->records(), written * 10);
    std::filesystem::remove(dir / "spool/spool.db-shm");
    spool = Unexpected{""};
    spool = Spool::open(dir / "spool", {}, [](auto) {});
    ASSERT_TRUE(spool) << spool.error();
    EXPECT_EQ(spool->records(), written * 10);
}

TEST(MqttSpool, fifty_thousand_frames_per_second_are_written_at_twice_their_size_or_less) {
    Disk disk;
    auto spool = disk.open();
    std::vector<Record> records;
    std::uint64_t json = 0;
    std::mt19937 random{7};
    for (std::uint64_t i = 0; i < 50'000; ++i) {
        std::string text = R"({"gateway":"drone-1","stream":"0123456789abcdef","seq":)" + std::to_string(i) +
                           R"(,"time":1700000000.)" + std::to_string(random() % 1'000'000) +
                           R"(,"link":"fc","device":"fc-05","from":5,"to":254,"id":3,"name":"euler","fields":{"rol":)" +
                           std::to_string(random() % 18000) + R"(,"pit":)" + std::to_string(random() % 18000) + "}}";
        json += text.size();
        records.push_back({i + 1, Keep::normal, {}, now_s * 1'000'000'000, "t", std::move(text)});
    }
    const auto begin = std::chrono::steady_clock::now();
    const auto cpu = std::clock();
    BatchPacker packer;
    ASSERT_TRUE(spool->write(packer.pack(records), {}, now_s));
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    const double used = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    EXPECT_LT(used, 1.0) << "CPU seconds for a second's frames";
    const auto written = std::filesystem::file_size(disk.file()) + std::filesystem::file_size(disk.file() + "-wal");
    EXPECT_LE(written, 2 * json);
    std::cout << "50000 frames: " << time.count() << " s, " << used << " s CPU, " << written / 1024 << " KiB written for "
              << json / 1024 << " KiB of JSON\n";
}

struct Threaded {
    support::TempDir dir;
    support::Loop loop;
    std::vector<SpooledBatch> batches;
    SpoolState state;
    std::vector<std::string> reports;
    std::vector<KnownRequest> known;
    bool is_open = false;
    SpoolThread spool;

    explicit Threaded(const std::string& folder)
        : spool{loop.io,
                folder,
                {},
                {.next = [this](SpooledBatch one) { batches.push_back(std::move(one)); },
                 .state = [this](const SpoolState& now) { state = now; },
                 .report = [this](const std::string& text) { reports.push_back(text); },
                 .requests = [this](std::vector<KnownRequest> requests) { known = std::move(requests), is_open = true; }}} {
        spool.start();
    }
};

std::vector<Record> some_records(std::size_t count) {
    const std::uint64_t time_ns = static_cast<std::uint64_t>(std::time(nullptr)) * 1'000'000'000;
    std::vector<Record> records;
    for (std::size_t i = 0; i < count; ++i)
        records.push_back({i + 1, Keep::normal, {}, time_ns, "t", "{\"seq\":" + std::to_string(i) + "}"});
    return records;
}

TEST(MqttSpoolThread, stores_returns_and_removes) {
    support::TempDir dir;
    Threaded t{dir / "s"};
    t.spool.store(some_records(100));
    t.spool.ask_next(0);
    ASSERT_TRUE(t.loop.until([&] { return t.batches.size() == 1; }));
    EXPECT_TRUE(t.is_open);
    EXPECT_EQ(t.batches[0].batch.records, 100u);
    EXPECT_EQ(t.state.waiting, 100u);
    EXPECT_EQ(t.state.stored, 100u);
    t.spool.ask_next(t.batches[0].id);
    t.spool.store({});
    ASSERT_TRUE(t.loop.until([&] { return t.batches.size() == 2; }));
    EXPECT_EQ(t.batches[1].id, 0) << "the spool is empty";
    ASSERT_TRUE(t.loop.until([&] { return t.state.waiting == 0; }));
    std::vector<bool> begun;
    for (int i = 0; i < 2; ++i) t.spool.begin_request("a", [&](bool is_new) { begun.push_back(is_new); });
    ASSERT_TRUE(t.loop.until([&] { return begun.size() == 2; }));
    EXPECT_EQ(begun, (std::vector{true, false}));
    t.spool.store(some_records(10));
    EXPECT_TRUE(t.spool.stop(support::patience));
    EXPECT_EQ(Spool::open(dir / "s", {}, [](auto) {})->records(), 10u) << "what was given before the end";
}

TEST(MqttSpoolThread, without_a_folder_records_are_counted_as_dropped) {
    Threaded t{""};
    t.spool.store(some_records(100));
    ASSERT_TRUE(t.loop.until([&] { return t.state.dropped == 100; }));
}

TEST(MqttSpoolThread, a_full_disk_is_reported_once_and_memory_is_bounded) {
    support::TempDir dir;
    const support::SmallDisk small{dir.path().string(), "512k"};
    if (!small.why_not().empty()) GTEST_SKIP() << small.why_not();
    Threaded t{dir / "s"};
    std::vector<Record> noise;
    std::mt19937 random{7};
    for (std::uint64_t i = 0; i < 20; ++i) {
        noise.push_back(
            {i, Keep::normal, {}, static_cast<std::uint64_t>(std::time(nullptr)) * 1'000'000'000, "t", std::string(50'000, ' ')});
        for (char& c : noise.back().json) c = static_cast<char>(random());
    }
    for (int i = 0; i < 10; ++i) t.spool.store(noise);    // 10 MB
    ASSERT_TRUE(t.loop.until([&] { return t.state.dropped > 0; }));
    EXPECT_EQ(t.reports.size(), 1u);
    EXPECT_TRUE(t.spool.stop(support::patience));
}

}    // namespace
}    // namespace spool_tests
