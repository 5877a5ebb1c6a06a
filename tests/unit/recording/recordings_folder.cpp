// The rules of the folder of recordings: which files are recordings, which are removed, and which are repaired.
#include <recording/recordings_folder.hpp>
#include <support/files.hpp>
#include <support/recorded.hpp>
#include <support/temp_dir.hpp>
#include <support/wait.hpp>

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace anogate::recordings_folder_tests {
namespace {

namespace fs = std::filesystem;
using support::Bytes;
using State = FoundRecording::State;

const Bytes euler = support::frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});

std::string recording(std::size_t frames, bool end = true, const std::string& program = "anogated 0.1.0",
                      RecordingFormat format = RecordingFormat::pcapng) {
    std::vector<support::KeptItem> items;
    for (std::size_t i = 0; i < frames; ++i) {
        support::KeptItem item;
        item.time_ns = 1763898044'000000000 + i;
        item.link = "fc";
        item.frame = euler;
        items.push_back(item);
    }
    return support::write_recording(format, items, {program, 1763898044'000000000, 5}, end);
}

unsigned status_of(const std::optional<Refusal>& refusal) { return refusal ? refusal->status : 200; }

class RecordingsFolder : public testing::Test {
protected:
    std::vector<std::string> names() const {
        std::vector<std::string> all;
        for (const FoundRecording& file : view_of(folder).files) all.push_back(file.name);
        std::sort(all.begin(), all.end());
        return all;
    }
    bool is_there(const std::string& name) const { return fs::exists(fs::symlink_status(dir / name)); }

    support::TempDir dir;
    std::string folder = dir.path().string();
};

TEST(RecordingName, has_only_characters_that_every_system_accepts) {
    for (const char* name : {"a", "flight-1.2_x", "A", "0", "a..b"}) EXPECT_TRUE(is_recording_name(name)) << name;
    EXPECT_TRUE(is_recording_name(std::string(100, 'x')));
    EXPECT_FALSE(is_recording_name(std::string(101, 'x')));
    for (const char* name : {"", ".", "..", ".hidden", "a/b", "../a", "a b", "a\n", "a\\b", "ä", "a:b", "a%2f"})
        EXPECT_FALSE(is_recording_name(name)) << name;
    EXPECT_FALSE(is_recording_name(std::string_view{"a\0b", 3}));
}

TEST_F(RecordingsFolder, suggests_a_similar_name_for_one_that_does_not_exist) {
    dir.write("flight.pcapng", recording(1));
    dir.write("notes", "x");
    const auto words = [&](const std::string& name) {
        const auto refusal = remove_recording(folder, name);
        return refusal ? std::to_string(refusal->status) + " " + refusal->fault.text() : std::string{};
    };
    EXPECT_EQ(words("flight"), "404 there is no recording flight; there is flight.pcapng");
    EXPECT_EQ(words("flight.mcap"), "404 there is no recording flight.mcap; there is flight.pcapng");
    EXPECT_EQ(words("fligth.pcapng"), "404 there is no recording fligth.pcapng (did you mean 'flight.pcapng'?)");
    EXPECT_EQ(words("fligt"), "404 there is no recording fligt (did you mean 'flight.pcapng'?)");
    EXPECT_EQ(words("entirely-else"), "404 there is no recording entirely-else");
    EXPECT_EQ(words("notes"), "403 notes was not written by the gateway and is left alone");
    EXPECT_EQ(std::get<Refusal>(open_recording(folder, "flight")).status, 404u);
    dir.write("FLIGHT.pcapng", recording(1));
    EXPECT_EQ(words("fligth.pcapng"), "404 there is no recording fligth.pcapng (did you mean 'flight.pcapng'?)");
    EXPECT_EQ(words("FLIGTH"), "404 there is no recording FLIGTH (did you mean 'FLIGHT.pcapng'?)");
}

TEST_F(RecordingsFolder, lists_files_that_the_gateway_wrote_and_only_counts_the_rest) {
    dir.write("flight.pcapng", recording(3));
    dir.write("cut.pcapng", recording(2, false));
    dir.write("foreign.pcapng", recording(3, true, "dumpcap"));
    dir.write("mine.pcapng", recording(3, true, "anoctl 0.1.0"));
    dir.write("notes.txt", "x");
    dir.write(".hidden.pcapng", recording(1));
    dir.write("empty.pcapng", "");
    fs::create_directory(dir / "folder.pcapng");
    fs::create_symlink(dir / "flight.pcapng", dir / "link.pcapng");
    ASSERT_EQ(::mkfifo((dir / "pipe.pcapng").c_str(), 0600), 0);
    EXPECT_EQ(names(), (std::vector<std::string>{"cut.pcapng", "flight.pcapng"}));
    const FolderView view = view_of(folder);
    EXPECT_EQ(view.others, 6u);
    EXPECT_EQ(view.fault.text(), "");
    EXPECT_TRUE(view.free.has_value());
    for (const FoundRecording& file : view.files) {
        EXPECT_EQ(file.state, file.name == "flight.pcapng" ? State::ended : State::unfinished);
        if (file.name == "flight.pcapng") {
            EXPECT_EQ(file.frames, 3u);
            EXPECT_TRUE(file.seconds.has_value());
            EXPECT_EQ(file.begun_ns, 1763898044'000000000u);
        }
    }
}

TEST_F(RecordingsFolder, reports_the_last_write_time_with_nanoseconds) {
    const std::string file = dir.write("flight.pcapng", recording(1));
    const timespec times[] = {{1763898063, 0}, {1763898063, 987654321}};
    ASSERT_EQ(::utimensat(AT_FDCWD, file.c_str(), times, 0), 0);
    EXPECT_EQ(view_of(folder).files.at(0).changed_ns, 1763898063'987654321u);
}

TEST_F(RecordingsFolder, reports_the_number_of_frames_of_a_finished_mcap_file) {
    dir.write("flight.mcap", recording(300, true, "anogated 0.1.0", RecordingFormat::mcap));
    dir.write("cut.mcap", recording(300, false, "anogated 0.1.0", RecordingFormat::mcap));
    dir.write("foreign.mcap", recording(300, true, "mcap", RecordingFormat::mcap));
    const FolderView view = view_of(folder);
    EXPECT_EQ(view.others, 1u);
    ASSERT_EQ(view.files.size(), 2u);
    for (const FoundRecording& file : view.files) {
        const bool is_whole = file.name == "flight.mcap";
        EXPECT_EQ(file.state, is_whole ? State::ended : State::unfinished);
        EXPECT_EQ(file.frames, is_whole ? std::optional<std::uint64_t>{300} : std::nullopt);
        EXPECT_EQ(file.seconds.has_value(), is_whole);
        EXPECT_EQ(file.format, RecordingFormat::mcap);
        EXPECT_EQ(file.begun_ns, 1763898044'000000000u);
    }
}

TEST_F(RecordingsFolder, that_does_not_exist_yet_is_empty) {
    const FolderView view = view_of(dir / "not/yet");
    EXPECT_TRUE(view.files.empty());
    EXPECT_EQ(view.fault.text(), "");
    EXPECT_TRUE(view.free.has_value()) << "of the disk where it will be";
    EXPECT_TRUE(repair_recordings(dir / "not/yet").empty());
    EXPECT_EQ(status_of(remove_recording(dir / "not/yet", "a.pcapng")), 404u);
    EXPECT_EQ(status_of(check_new_name(dir / "not/yet", "a")), 200u);
}

TEST_F(RecordingsFolder, deletes_only_files_that_the_gateway_wrote) {
    dir.write("flight.pcapng", recording(3));
    dir.write("foreign.pcapng", recording(3, true, "dumpcap"));
    dir.write("notes.txt", "x");
    fs::create_symlink(dir / "flight.pcapng", dir / "link.pcapng");
    ASSERT_EQ(::mkfifo((dir / "pipe.pcapng").c_str(), 0600), 0);
    for (const char* name : {"foreign.pcapng", "notes.txt", "link.pcapng", "pipe.pcapng"}) {
        EXPECT_EQ(status_of(remove_recording(folder, name)), 403u) << name;
        EXPECT_TRUE(is_there(name)) << name;
    }
    EXPECT_EQ(status_of(remove_recording(folder, "none.pcapng")), 404u);
    for (const char* name : {"../flight.pcapng", ".", "", "a/b.pcapng"})
        EXPECT_EQ(status_of(remove_recording(folder, name)), 422u) << name;
    EXPECT_EQ(status_of(remove_recording(folder, "flight.pcapng")), 200u);
    EXPECT_FALSE(is_there("flight.pcapng"));
    EXPECT_TRUE(is_there("link.pcapng"));
}

TEST_F(RecordingsFolder, opens_only_files_that_the_gateway_wrote) {
    dir.write("flight.pcapng", recording(3));
    dir.write("foreign.pcapng", recording(3, true, "dumpcap"));
    fs::create_symlink("/etc/passwd", dir / "passwd.pcapng");
    const auto status = [&](const char* name) {
        const auto opened = open_recording(folder, name);
        const auto* refusal = std::get_if<Refusal>(&opened);
        return refusal ? refusal->status : 200;
    };
    EXPECT_EQ(status("flight.pcapng"), 200u);
    EXPECT_EQ(status("foreign.pcapng"), 403u);
    EXPECT_EQ(status("passwd.pcapng"), 403u);
    EXPECT_EQ(status("none.pcapng"), 404u);
    EXPECT_EQ(status("../etc/passwd"), 422u);
}

TEST_F(RecordingsFolder, does_not_touch_files_that_are_being_written) {
    dir.write("flight.pcapng", recording(3, false));
    const UniqueFd writer{::open((dir / "flight.pcapng").c_str(), O_RDWR | O_CLOEXEC)};
    ASSERT_EQ(::flock(writer.get(), LOCK_EX | LOCK_NB), 0);
    ASSERT_EQ(view_of(folder).files.size(), 1u);
    EXPECT_EQ(view_of(folder).files[0].state, State::recording);
    EXPECT_EQ(status_of(remove_recording(folder, "flight.pcapng")), 409u);
    EXPECT_TRUE(repair_recordings(folder).empty());
    EXPECT_EQ(support::file_text(dir / "flight.pcapng"), recording(3, false));
    RecordingAges ages;
    EXPECT_TRUE(delete_old(folder, {1, {}, 0}, ages, {std::chrono::seconds{2'000'000'000}, {}}).gone.empty());
}

TEST_F(RecordingsFolder, is_not_blocked_by_other_readers) {
    dir.write("cut.pcapng", recording(3, false));
    dir.write("flight.pcapng", recording(3));
    const UniqueFd cut{::open((dir / "cut.pcapng").c_str(), O_RDONLY | O_CLOEXEC)};
    const UniqueFd flight{::open((dir / "flight.pcapng").c_str(), O_RDONLY | O_CLOEXEC)};
    ASSERT_EQ(::flock(cut.get(), LOCK_SH | LOCK_NB), 0);
    ASSERT_EQ(::flock(flight.get(), LOCK_SH | LOCK_NB), 0);
    for (const FoundRecording& file : view_of(folder).files) EXPECT_NE(file.state, State::recording) << file.name;
    EXPECT_EQ(status_of(remove_recording(folder, "flight.pcapng")), 200u);
    EXPECT_EQ(repair_recordings(folder).size(), 1u);
}

TEST_F(RecordingsFolder, also_deletes_files_that_are_being_repaired) {
    dir.write("old.pcapng", recording(3000, false));
    dir.write("new.pcapng", recording(1000));
    fs::last_write_time(dir / "old.pcapng", fs::file_time_type::clock::now() - std::chrono::hours{700});
    const UniqueFd repairer{::open((dir / "old.pcapng").c_str(), O_RDWR | O_CLOEXEC)};
    struct flock all {};
    all.l_type = F_WRLCK;
    ASSERT_EQ(::fcntl(repairer.get(), F_OFD_SETLK, &all), 0);
    EXPECT_TRUE(repair_recordings(folder).empty()) << "somebody else does it";
    EXPECT_EQ(view_of(folder).files.at(1).state, State::unfinished);
    RecordingAges ages;
    const KeepLimits limits{recording(3000).size(), {}, 0};
    EXPECT_EQ(delete_old(folder, limits, ages, {std::chrono::seconds{1'763'898'044}, {}}).gone,
              std::vector<std::string>{"old.pcapng"});
    EXPECT_EQ(names(), std::vector<std::string>{"new.pcapng"});
}

TEST_F(RecordingsFolder, stops_repairing_a_file_that_is_deleted) {
    dir.write("old.pcapng", recording(3, false));
    const UniqueFd old{::open((dir / "old.pcapng").c_str(), O_RDWR | O_CLOEXEC)};
    constexpr off_t large = off_t{8} * 1024 * 1024 * 1024;    // of zeros that use no disk space: seconds to read
    ASSERT_EQ(::ftruncate(old.get(), large), 0);
    std::vector<RepairedFile> repaired(1);
    std::thread repairer{[&] { repaired = repair_recordings(folder); }};
    const auto is_repaired = [&] {
        struct flock all {};
        all.l_type = F_WRLCK;
        return ::fcntl(old.get(), F_OFD_GETLK, &all) == 0 && all.l_type != F_UNLCK;
    };
    EXPECT_TRUE(support::wait_until(is_repaired));
    EXPECT_EQ(status_of(remove_recording(folder, "old.pcapng")), 200u);
    repairer.join();
    EXPECT_TRUE(repaired.empty());
    EXPECT_EQ(fs::file_size("/proc/self/fd/" + std::to_string(old.get())), static_cast<std::uintmax_t>(large))
        << "it stays as it was";
}

TEST_F(RecordingsFolder, repairs_files_cut_at_any_byte) {
    const std::string frames = recording(50, false);
    const std::size_t first = recording(1, false).size();
    for (std::size_t size = first; size <= frames.size(); size += 7) {
        dir.write("flight.pcapng", frames.substr(0, size));
        const auto repaired = repair_recordings(folder);
        ASSERT_EQ(repaired.size(), 1u) << size;
        EXPECT_EQ(repaired[0].fault, "");
        const auto read = support::read_pcapng(support::file_text(dir / "flight.pcapng"));
        ASSERT_TRUE(read.has_end) << size;
        ASSERT_EQ(read.unfinished, 0u) << size;
        ASSERT_EQ(read.items.size(), repaired[0].frames) << size;
        ASSERT_EQ(read.items.size(), (size - first) / (recording(2, false).size() - first) + 1) << size;
        ASSERT_TRUE(repair_recordings(folder).empty()) << "once is enough";
    }
}

TEST_F(RecordingsFolder, discards_nothing_after_damage_in_the_middle) {
    const std::string flight = recording(50'000, false);
    ASSERT_GT(flight.size(), 3'000'000u);
    std::string damaged = flight;
    damaged.replace(500'000, 200, 200, '\xFF');
    dir.write("flight.pcapng", damaged);
    const auto repaired = repair_recordings(folder);
    ASSERT_EQ(repaired.size(), 1u);
    EXPECT_NE(repaired[0].fault.find("damaged after byte 4999"), std::string::npos) << repaired[0].fault;
    EXPECT_EQ(support::file_text(dir / "flight.pcapng"), damaged);
}

TEST_F(RecordingsFolder, removes_the_zeros_that_a_power_loss_left) {
    const std::string flight = recording(1000, false);
    dir.write("flight.pcapng", flight + std::string(5'000'000, '\0'));
    const auto repaired = repair_recordings(folder);
    ASSERT_EQ(repaired.size(), 1u);
    EXPECT_EQ(repaired[0].fault, "");
    EXPECT_EQ(repaired[0].frames, 1000u);
    const auto read = support::read_pcapng(support::file_text(dir / "flight.pcapng"));
    EXPECT_TRUE(read.has_end);
    EXPECT_EQ(read.items.size(), 1000u);
}

TEST_F(RecordingsFolder, repairs_only_files_that_the_gateway_wrote_and_keeps_their_time) {
    const std::string foreign = recording(3, false, "dumpcap"), ours = recording(3, false);
    dir.write("foreign.pcapng", foreign);
    dir.write("flight.pcapng", ours.substr(0, ours.size() - 3));
    const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours{50};
    fs::last_write_time(dir / "flight.pcapng", long_ago);
    ASSERT_EQ(repair_recordings(folder).size(), 1u);
    EXPECT_EQ(support::file_text(dir / "foreign.pcapng"), foreign);
    EXPECT_EQ(std::chrono::floor<std::chrono::seconds>(fs::last_write_time(dir / "flight.pcapng")),
              std::chrono::floor<std::chrono::seconds>(long_ago));
}

TEST_F(RecordingsFolder, deletes_the_oldest_files_beyond_the_limits) {
    const auto now = std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now()).time_since_epoch();
    const std::uint64_t size = recording(3).size();
    for (int i = 0; i < 5; ++i) {
        const std::string name = "flight-" + std::to_string(i) + ".pcapng";
        dir.write(name, recording(3));
        fs::last_write_time(dir / name, fs::file_time_type::clock::now() - std::chrono::hours{5 - i});
    }
    dir.write("foreign.pcapng", recording(3, true, "dumpcap"));
    fs::last_write_time(dir / "foreign.pcapng", fs::file_time_type::clock::now() - std::chrono::hours{100});
    RecordingAges ages;
    const auto gone = [&](const KeepLimits& limits) {
        return delete_old(folder, limits, ages, {now, std::chrono::seconds{500}}).gone;
    };
    EXPECT_TRUE(gone({}).empty());
    EXPECT_EQ(gone({3 * size, {}, 0}), (std::vector<std::string>{"flight-0.pcapng", "flight-1.pcapng"}));
    EXPECT_EQ(gone({0, std::chrono::minutes{30}, 0}), std::vector<std::string>{"flight-2.pcapng"}) << "an hour, without a pause";
    EXPECT_EQ(names(), (std::vector<std::string>{"flight-3.pcapng", "flight-4.pcapng"}));
    EXPECT_TRUE(is_there("foreign.pcapng"));
    const DeletedRecordings old = delete_old(folder, {1, {}, 0}, ages, {now, std::chrono::seconds{500}},
                                             [](const std::string& name) { return name == "flight-3.pcapng"; });
    EXPECT_TRUE(old.gone.empty()) << "the one was just saved, the other is the newest";
    EXPECT_EQ(old.stays, "flight-4.pcapng");
}

TEST_F(RecordingsFolder, lists_files_changed_since_a_time) {
    const auto now = std::chrono::seconds{std::time(nullptr)};
    for (const std::string name : {"before", "now"}) dir.write(name + ".pcapng", recording(1));
    dir.write("foreign.pcapng", "x");
    fs::last_write_time(dir / "before.pcapng", fs::file_time_type::clock::now() - std::chrono::seconds{70});
    EXPECT_EQ(changed_since(folder, now - std::chrono::seconds{60}), std::set<std::string>{"now.pcapng"});
    EXPECT_EQ(changed_since(folder, now - std::chrono::seconds{80}), (std::set<std::string>{"before.pcapng", "now.pcapng"}));
    EXPECT_TRUE(changed_since(folder, now + std::chrono::seconds{60}).empty());
}

TEST_F(RecordingsFolder, rejects_a_name_that_exists_in_any_format) {
    dir.write("a.pcapng", "whatever it is");
    fs::create_symlink("/nowhere", dir / "b.mcap");
    EXPECT_EQ(status_of(check_new_name(folder, "a")), 409u);
    EXPECT_EQ(status_of(check_new_name(folder, "b")), 409u);
    EXPECT_EQ(status_of(check_new_name(folder, "c")), 200u);
}

KeptFrames kept_frames(std::size_t frames) {
    const auto names = std::make_shared<const RecordedNames>(RecordedNames{{"fc"}, {"serial"}, {"", "192.168.1.20:6000"}});
    std::string batch;
    for (std::size_t i = 0; i < frames; ++i)
        append(batch, {1'000'000'000 + i, 500 + i, 0, Direction::in, 0, 1, ano::FrameView{euler}});
    KeptFrames kept;
    kept.head = {"anogated 0.1.0", 7, 8};
    kept.parts.push_back({std::make_shared<const std::string>(batch), names, {}, {}, frames});
    kept.parts.push_back({nullptr, names, RecordedLoss{5, {}}, "euler 5", 0});
    kept.parts.push_back(kept.parts[0]);
    return kept;
}

TEST_F(RecordingsFolder, saves_frames_from_memory_unchanged) {
    const auto saved = save_frames(dir / "new/folder", "last", RecordingFormat::pcapng, 0, kept_frames(3000));
    ASSERT_TRUE(std::holds_alternative<SavedFrames>(saved)) << std::get<Refusal>(saved).fault.text();
    EXPECT_EQ(std::get<SavedFrames>(saved).name, "last.pcapng");
    struct stat is {};
    ASSERT_EQ(::stat((dir / "new/folder/last.pcapng").c_str(), &is), 0);
    EXPECT_EQ(is.st_mode & 07777, 0640u);
    const auto read = support::read_pcapng(support::file_text(dir / "new/folder/last.pcapng"));
    ASSERT_EQ(read.items.size(), 6001u);
    EXPECT_TRUE(read.has_end);
    EXPECT_EQ(read.items[0].link, "fc");
    EXPECT_EQ(read.items[0].description, "serial");
    EXPECT_EQ(read.items[0].peer, "192.168.1.20:6000");
    EXPECT_EQ(read.items[0].frame, euler);
    EXPECT_EQ(read.items[2999].time_ns, 1'000'002'999u);
    const auto loss = std::find_if(read.items.begin(), read.items.end(), [](const auto& item) { return item.lost > 0; });
    ASSERT_NE(loss, read.items.end());
    EXPECT_EQ(loss->lost, 5u);
    EXPECT_EQ(loss->names, "euler 5");
}

TEST_F(RecordingsFolder, saves_nothing_if_too_little_space_is_free) {
    const auto saved = save_frames(folder, "last", RecordingFormat::pcapng, std::uint64_t{1} << 60, kept_frames(10));
    ASSERT_TRUE(std::holds_alternative<Refusal>(saved));
    EXPECT_EQ(std::get<Refusal>(saved).status, 507u);
    const auto other = save_frames(folder, "other", RecordingFormat::pcapng, 0, kept_frames(10));
    const std::uint64_t needed = (std::uint64_t{1} << 60) + std::get<SavedFrames>(other).bytes;
    EXPECT_NE(std::get<Refusal>(saved).fault.text().find(" bytes of disk space are free, and " + std::to_string(needed) +
                                                         " are needed"),
              std::string::npos)
        << std::get<Refusal>(saved).fault.text();
    EXPECT_FALSE(is_there("last.pcapng"));
}

}    // namespace
}    // namespace anogate::recordings_folder_tests
