// The work of a recorder's thread, on a disk that works and on one that fails.
#include <recording/disk_writer.hpp>

#include <support/failing_disk_calls.hpp>
#include <support/recorded_files.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <new>
#include <string>

namespace disk_writer_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
namespace fs = std::filesystem;
using support::failing_disk;
using support::recorded_files;

class DiskWriterTest : public testing::Test {
protected:
    DiskWriterTest() {
        settings.folder = dir / "a/b";
        settings.name = "flight";
        settings.keep_free = 0;
    }
    DiskWriter& disk() {
        if (!disk_) disk_ = std::make_unique<DiskWriter>(settings, progress);
        return *disk_;
    }
    /// A batch of numbered frames, as passed by the loop.
    void add(int frames) {
        auto batch = std::make_shared<std::string>();
        for (int i = 0; i < frames; ++i) {
            const support::Bytes bytes = support::numbered(1, 2, next_++);
            append(*batch, {std::uint64_t(next_), 7, 0, Direction::in, 0, 1, ano::FrameView{bytes}});
        }
        progress.in_flight += batch->size();
        disk().add({.batch = batch});
    }
    void turn(ano::Duration later = {}) { disk().turn(now += later); }
    void finish() { disk().finish(now); }
    support::RecordedFiles files() const { return recorded_files(settings.folder, settings.name); }
    std::string path(const std::string& name) const { return settings.folder + "/" + name; }

    const support::TempDir dir;
    const support::WellAgain well_again{};
    RecorderSettings settings;
    DiskProgress progress;
    ano::TimePoint now{1h};
    int next_ = 0;

private:
    std::unique_ptr<DiskWriter> disk_;
};
using DiskWriters = DiskWriterTest;

TEST_F(DiskWriters, writes_the_frames_with_their_names_and_finishes_the_file) {
    turn();
    ASSERT_TRUE(disk().accepts_more());
    disk().add({.names = std::make_shared<const RecordedNames>(RecordedNames{{"fc"}, {"serial"}, {"", "/dev/ttyS0"}})});
    add(1);
    auto batch = std::make_shared<std::string>();
    const support::Bytes bytes = support::frame(3, 4, 3, {1});
    append(*batch, {10, 7, 0, Direction::dropped, 1, FrameRecord::no_channel, ano::FrameView{bytes}});
    disk().add({.batch = batch});
    finish();
    EXPECT_EQ(disk().fault().text(), "");
    const auto written = files();
    ASSERT_EQ(written.files.size(), 1u);
    EXPECT_TRUE(written.are_whole());
    EXPECT_TRUE(written.files[0].head.program.starts_with("anogated ")) << written.files[0].head.program;
    ASSERT_EQ(written.files[0].items.size(), 2u);
    const support::KeptItem &in = written.files[0].items[0], &dropped = written.files[0].items[1];
    EXPECT_EQ(in.link + " " + in.description + " " + in.peer, "fc serial /dev/ttyS0");
    EXPECT_EQ(in.channel, 1);
    EXPECT_EQ(dropped.direction, Direction::dropped);
    EXPECT_EQ(dropped.cause, frame_causes()[1]);
    EXPECT_EQ(dropped.channel, std::nullopt);
    EXPECT_EQ(progress.frames, 2u);
    EXPECT_EQ(progress.files, 1u);
    EXPECT_EQ(progress.bytes, fs::file_size(path("flight.pcapng")));
}

TEST_F(DiskWriters, a_turn_writes_all_accepted_frames_into_the_file) {
    turn();
    add(100);
    turn();
    EXPECT_EQ(files().numbers, support::numbers_to(100));
    EXPECT_EQ(progress.frames, 100u);
    EXPECT_TRUE(disk().has_work()) << "it is not on the disk for sure";
    EXPECT_GT(progress.in_flight, 0u);
    turn(DiskWriter::sync_time);
    EXPECT_FALSE(disk().has_work());
    EXPECT_EQ(progress.in_flight, 0u);
}

TEST_F(DiskWriters, files_are_accessible_to_user_and_group_under_any_umask_and_locked_while_written) {
    const mode_t before = ::umask(0077);
    turn();
    ::umask(before);
    struct stat file {
    }, folder{};
    ASSERT_EQ(::stat(path("flight.pcapng").c_str(), &file), 0);
    ASSERT_EQ(::stat(settings.folder.c_str(), &folder), 0);
    EXPECT_EQ(file.st_mode & 07777, 0640u);
    EXPECT_EQ(folder.st_mode & 0027, 0u);
    const UniqueFd other{::open(path("flight.pcapng").c_str(), O_RDONLY | O_CLOEXEC)};
    EXPECT_NE(::flock(other.get(), LOCK_EX | LOCK_NB), 0);
    finish();
    EXPECT_EQ(::flock(other.get(), LOCK_EX | LOCK_NB), 0);
}

TEST_F(DiskWriters, existing_files_are_never_overwritten) {
    fs::create_directories(settings.folder);
    fs::create_symlink(dir / "elsewhere", path("flight-2.pcapng"));
    dir.write("a/b/flight.pcapng", "mine");
    turn();
    add(3);
    finish();
    EXPECT_EQ(disk().file(), path("flight-3.pcapng"));
    EXPECT_EQ(support::file_text(path("flight.pcapng")), "mine");
    EXPECT_FALSE(fs::exists(dir / "elsewhere"));
    EXPECT_EQ(support::read_pcapng(support::file_text(path("flight-3.pcapng"))).items.size(), 3u);
}

TEST_F(DiskWriters, a_file_name_cannot_leave_its_folder) {
    settings.name = "../flight";
    turn();
    EXPECT_NE(disk().fault().text().find("is not a valid file name"), std::string::npos) << disk().fault().text();
    EXPECT_FALSE(fs::exists(dir / "a/flight.pcapng"));
}

TEST_F(DiskWriters, the_counts_of_the_current_file_are_reported_besides_the_totals) {
    settings.rotate_bytes = 10'000;
    turn();
    for (int i = 0; i < 50; ++i) {
        add(20);
        turn(1ms);
    }
    add(3);
    turn(1s);
    EXPECT_EQ(progress.frames, 1003u);
    EXPECT_EQ(progress.file_bytes, fs::file_size(disk().file()));
    EXPECT_LT(progress.file_bytes, progress.bytes);
    std::uint64_t before = 0;
    const auto written = files();
    for (std::size_t i = 0; i + 1 < written.files.size(); ++i) before += written.files[i].items.size();
    EXPECT_GT(before, 0u);
    EXPECT_EQ(progress.file_frames, 1003u - before);
    finish();
    EXPECT_EQ(progress.file_frames, 0u) << "there is none that is written";
    EXPECT_EQ(progress.file_bytes, 0u);
}

TEST_F(DiskWriters, the_next_file_begins_when_one_is_large_enough_and_nothing_is_lost) {
    settings.rotate_bytes = 10'000;
    turn();
    for (int i = 0; i < 50; ++i) {
        add(20);
        turn(1ms);
    }
    finish();
    const auto written = files();
    EXPECT_EQ(written.numbers, support::numbers_to(1000));
    EXPECT_TRUE(written.are_whole());
    EXPECT_GT(written.files.size(), 5u);
    EXPECT_EQ(progress.files, written.files.size());
    std::uint64_t bytes = 0;
    for (unsigned n = 1; n <= written.files.size(); ++n) {
        const std::uint64_t size = fs::file_size(path(recording_file_name("flight", n, RecordingFormat::pcapng)));
        if (n < written.files.size()) {
            EXPECT_GE(size, settings.rotate_bytes);
        }
        bytes += size;
    }
    EXPECT_EQ(progress.bytes, bytes);
}

TEST_F(DiskWriters, the_next_file_begins_when_one_is_old_enough_and_has_frames) {
    settings.rotate_time = 60s;
    turn();
    turn(100s);
    EXPECT_EQ(files().files.size(), 1u) << "it has no frames";
    add(5);
    turn();
    EXPECT_EQ(files().files.size(), 2u);
    turn(100s);
    EXPECT_EQ(files().files.size(), 2u) << "nor has the second";
    disk().finish(now);
}

TEST_F(DiskWriters, the_age_of_a_file_counts_from_its_beginning) {
    settings.rotate_time = 60s;
    turn();
    add(5);
    turn(60s);
    EXPECT_EQ(files().files.size(), 2u);
    add(5);
    turn(59s);
    EXPECT_EQ(files().files.size(), 2u);
    turn(1s);
    finish();
    EXPECT_EQ(files().files.size(), 3u);
    EXPECT_TRUE(files().are_whole());
    EXPECT_EQ(files().numbers, support::numbers_to(10));
}

TEST_F(DiskWriters, on_a_full_disk_the_file_stays_complete_and_continues_when_there_is_room) {
    turn();
    add(10);
    turn();
    const auto size = fs::file_size(path("flight.pcapng"));
    failing_disk.write_error = ENOSPC;
    failing_disk.room = 100;
    add(10);
    turn(1ms);
    EXPECT_EQ(disk().fault().text(), path("flight.pcapng") + ": No space left on device");
    EXPECT_FALSE(disk().accepts_more());
    EXPECT_EQ(fs::file_size(path("flight.pcapng")), size) << "no half frame";
    failing_disk.write_error = 0;
    turn(DiskWriter::try_again_after - 1ms);
    EXPECT_NE(disk().fault().text(), "") << "it is not asked all the time";
    turn(1ms);
    EXPECT_EQ(disk().fault().text(), "");
    add(10);
    finish();
    EXPECT_EQ(files().numbers, support::numbers_to(30));
    EXPECT_EQ(files().files.size(), 1u);
    EXPECT_TRUE(files().are_whole());
    EXPECT_EQ(progress.not_written, 0u);
}

TEST_F(DiskWriters, frames_that_a_full_disk_does_not_accept_at_the_end_are_counted) {
    turn();
    add(10);
    turn();
    failing_disk.write_error = ENOSPC;
    add(7);
    finish();
    EXPECT_NE(disk().fault().text(), "");
    EXPECT_EQ(progress.frames, 10u);
    EXPECT_EQ(progress.not_written, 7u);
    EXPECT_EQ(files().numbers, support::numbers_to(10));
}

TEST_F(DiskWriters, a_file_that_cannot_be_synced_is_abandoned_and_no_frame_is_written_twice) {
    turn();
    add(10);
    turn(DiskWriter::sync_time);
    add(10);
    turn(1ms);
    EXPECT_EQ(files().numbers, support::numbers_to(20));
    failing_disk.sync_error = EIO;
    add(10);
    turn(DiskWriter::sync_time);
    EXPECT_EQ(disk().fault().text(), path("flight-2.pcapng") + ": Input/output error");
    EXPECT_EQ(files().numbers, support::numbers_to(10)) << "what is there for sure";
    EXPECT_EQ(files().files.size(), 1u) << "no file without anything in it";
    EXPECT_EQ(progress.frames, 20u) << "it does not go back";
    failing_disk.sync_error = 0;
    turn(DiskWriter::try_again_after);
    EXPECT_EQ(disk().fault().text(), "");
    add(10);
    finish();
    EXPECT_EQ(files().numbers, support::numbers_to(40));
    EXPECT_EQ(files().files.size(), 2u);
    EXPECT_EQ(progress.bytes, fs::file_size(path("flight.pcapng")) + fs::file_size(path("flight-2.pcapng")));
    EXPECT_EQ(progress.files, 2u);
    EXPECT_EQ(progress.frames, 40u);
    EXPECT_EQ(progress.not_written, 0u);
}

TEST_F(DiskWriters, frames_that_a_disk_accepted_and_lost_for_lack_of_room_are_written_again) {
    turn();
    add(10);
    turn(DiskWriter::sync_time);
    failing_disk.sync_error = ENOSPC;    // as reported by a network file system
    add(10);
    turn(DiskWriter::sync_time);
    failing_disk.sync_error = 0;
    turn(DiskWriter::try_again_after);
    finish();
    EXPECT_EQ(files().numbers, support::numbers_to(20));
    EXPECT_EQ(files().files.size(), 2u);
}

TEST_F(DiskWriters, every_file_maps_link_numbers_as_when_the_frame_was_received) {
    const auto named = [](const char* name) {
        return RecorderItem{.names = std::make_shared<const RecordedNames>(RecordedNames{{name}, {"udp"}, {}})};
    };
    const auto links = [&] {
        std::string all;
        for (const auto& file : files().files)
            for (const auto& item : file.items) all += item.link + " ";
        return all;
    };
    turn();
    disk().add(named("a"));
    add(1);
    turn(DiskWriter::sync_time);
    add(1);
    disk().add(named("b"));
    add(1);
    failing_disk.sync_error = EIO;
    turn(DiskWriter::sync_time);
    EXPECT_EQ(links(), "a ");
    failing_disk.sync_error = 0;
    turn(DiskWriter::try_again_after);
    EXPECT_EQ(links(), "a a b ");
    add(1);
    finish();
    EXPECT_EQ(links(), "a a b b ");
}

TEST_F(DiskWriters, frames_that_no_file_accepts_at_the_end_are_counted) {
    turn();
    add(10);
    turn(DiskWriter::sync_time);
    add(10);
    turn(1ms);
    failing_disk.sync_error = EIO;
    finish();
    EXPECT_EQ(progress.frames, 10u);
    EXPECT_EQ(progress.not_written, 10u);
}

TEST_F(DiskWriters, frames_not_written_for_lack_of_memory_are_in_the_next_file) {
    turn();
    add(10);
    turn(DiskWriter::sync_time);
    failing_disk.lacks_memory = true;
    add(10);
    EXPECT_THROW(turn(), std::bad_alloc);
    disk().lacks_memory(now);
    EXPECT_EQ(disk().fault().text(), "out of memory");
    EXPECT_FALSE(disk().accepts_more());
    EXPECT_EQ(files().numbers, support::numbers_to(10)) << "what is there for sure";
    failing_disk.lacks_memory = false;
    turn(DiskWriter::try_again_after - 1ms);
    EXPECT_EQ(disk().fault().text(), "out of memory");
    turn(1ms);
    EXPECT_EQ(disk().fault().text(), "");
    add(10);
    finish();
    EXPECT_EQ(files().numbers, support::numbers_to(30));
    EXPECT_EQ(files().files.size(), 2u);
    EXPECT_EQ(progress.frames, 30u);
    EXPECT_EQ(progress.not_written, 0u);
    EXPECT_EQ(progress.in_flight, 0u);
}

TEST_F(DiskWriters, frames_not_written_for_lack_of_memory_at_the_end_are_counted) {
    turn();
    add(10);
    turn(DiskWriter::sync_time);
    add(7);
    failing_disk.lacks_memory = true;
    EXPECT_THROW(finish(), std::bad_alloc);
    disk().lacks_memory(now);
    EXPECT_EQ(progress.frames, 10u);
    EXPECT_EQ(progress.not_written, 7u);
}

TEST_F(DiskWriters, after_a_file_was_removed_the_next_contains_the_frames_not_yet_saved) {
    turn();
    add(10);
    turn(DiskWriter::sync_time);
    fs::remove(path("flight.pcapng"));
    add(10);
    turn(1ms);
    turn(DiskWriter::look_time);
    EXPECT_EQ(disk().file(), path("flight-2.pcapng"));
    EXPECT_EQ(disk().fault().text(), "");
    finish();
    const auto second = support::read_pcapng(support::file_text(path("flight-2.pcapng")));
    ASSERT_EQ(second.items.size(), 10u);
    EXPECT_EQ(support::number_of(second.items[0].frame), 10);
    EXPECT_TRUE(second.has_end);
}

TEST_F(DiskWriters, a_file_that_was_moved_away_contains_the_frames_saved_until_then) {
    turn();
    add(10);
    turn(DiskWriter::sync_time);
    fs::rename(path("flight.pcapng"), dir / "moved.pcapng");
    add(10);
    turn(1ms);
    turn(DiskWriter::look_time);
    finish();
    EXPECT_EQ(support::read_pcapng(support::file_text(dir / "moved.pcapng")).items.size(), 10u);
    EXPECT_EQ(support::read_pcapng(support::file_text(path("flight-2.pcapng"))).items.size(), 10u);
}

TEST_F(DiskWriters, the_frame_count_does_not_decrease_when_a_file_is_abandoned) {
    turn();
    add(10);
    turn(DiskWriter::sync_time);
    add(10);
    turn();
    ASSERT_EQ(progress.frames, 20u);
    ASSERT_GT(progress.in_flight, 0u);
    fs::remove_all(settings.folder);
    std::ofstream{settings.folder} << "no folder";
    turn(DiskWriter::look_time);
    ASSERT_NE(disk().fault().text(), "");
    EXPECT_EQ(progress.frames, 20u);
    fs::remove(settings.folder);
    turn(DiskWriter::try_again_after);
    ASSERT_EQ(disk().fault().text(), "");
    EXPECT_EQ(progress.frames, 20u) << "none counts twice";
    add(5);
    finish();
    EXPECT_EQ(progress.frames, 25u);
}

TEST_F(DiskWriters, a_folder_that_was_removed_is_created_again) {
    turn();
    add(10);
    turn(DiskWriter::sync_time);
    fs::remove_all(dir / "a");
    add(10);
    turn(DiskWriter::look_time);
    EXPECT_EQ(disk().fault().text(), "");
    finish();
    EXPECT_EQ(support::read_pcapng(support::file_text(path("flight-2.pcapng"))).items.size(), 10u);
}

TEST_F(DiskWriters, creating_a_file_is_retried_after_a_failure) {
    dir.write("a", "a file in the place of the folder");
    turn();
    EXPECT_EQ(disk().fault().text(), settings.folder + ": Not a directory");
    EXPECT_FALSE(disk().accepts_more());
    fs::remove(dir / "a");
    turn(DiskWriter::try_again_after);
    EXPECT_EQ(disk().fault().text(), "");
    EXPECT_TRUE(disk().accepts_more());
}

TEST_F(DiskWriters, reserved_free_space_is_not_written) {
    settings.keep_free = std::uint64_t{1} << 60;
    turn();
    EXPECT_NE(disk().fault().text().find("of disk space is free, and recording needs 1152921504612.1 MB"), std::string::npos)
        << disk().fault().text();
    EXPECT_FALSE(fs::exists(settings.folder));
    settings.keep_free = 1000;
    turn(DiskWriter::try_again_after);
    EXPECT_EQ(disk().fault().text(), "");
    add(10);
    turn();
    settings.keep_free = std::uint64_t{1} << 60;
    add(10);
    turn(DiskWriter::look_time);
    EXPECT_NE(disk().fault().text(), "") << "looked at while it writes, too";
    EXPECT_EQ(files().numbers, support::numbers_to(10));
    settings.keep_free = 1000;
    turn(DiskWriter::try_again_after);
    finish();
    EXPECT_EQ(files().numbers, support::numbers_to(20));
}

TEST_F(DiskWriters, losses_are_recorded_with_message_names) {
    turn();
    LostFrames lost;
    lost.by_id[0x03] = 120;
    lost.by_id[0xEE] = 1;
    lost.count = 121;
    add(1);
    disk().add({.lost = std::make_shared<const LostFrames>(lost)});
    add(1);
    finish();
    EXPECT_EQ(files().lost, 121u);
    EXPECT_EQ(files().names, "euler 120, 0xEE 1");
}

/// Limits the size of the process's files.
class LimitOfFiles {
public:
    explicit LimitOfFiles(rlim_t bytes) {
        std::signal(SIGXFSZ, SIG_IGN);    // blocked in the thread of a recorder
        ::getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~LimitOfFiles() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, SIG_DFL);
    }
    LimitOfFiles(const LimitOfFiles&) = delete;
    LimitOfFiles& operator=(const LimitOfFiles&) = delete;

private:
    rlimit before_{};
};

TEST_F(DiskWriters, write_many_files_on_a_disk_that_limits_the_file_size) {
    const LimitOfFiles limit{20'000};
    turn();
    for (int i = 0; i < 50; ++i) {
        add(20);
        turn(DiskWriter::sync_time);
        ASSERT_EQ(disk().fault().text(), "");
    }
    finish();
    EXPECT_EQ(files().numbers, support::numbers_to(1000));
    EXPECT_GT(files().files.size(), 2u);
}

}    // namespace
}    // namespace disk_writer_tests
