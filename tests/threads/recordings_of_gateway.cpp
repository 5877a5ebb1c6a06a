// Requests of the program to its recorders: recordings that start, end and are saved, on a disk that hangs.
#include <config/difference.hpp>
#include <http/response.hpp>
#include <recording/recordings.hpp>

#include <support/bytes.hpp>
#include <support/failing_disk.hpp>
#include <support/files.hpp>
#include <support/recorded.hpp>
#include <support/running_gateway.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace recordings_of_gateway_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;
using support::failing_disk;

class RecordingsOfGateway : public testing::Test {
protected:
    RecordingsOfGateway() { recordings.start(); }

    Settings settings() {
        Settings settings = support::settings_of_texts({a.link("a")});
        settings.record = RecordSettings{};
        settings.record->start = false;
        settings.record->keep_last = 60s;
        settings.record->free = 0;
        settings.routes = {{0xDC, 0xDC, "a"}};    // in a network only the faults of a pinned device count
        return settings;
    }
    /// The status of the answer; 0 until it arrives.
    std::shared_ptr<unsigned> save(const std::string& name = {}) {
        const auto status = std::make_shared<unsigned>(0);
        const http::Response response = recordings.save_last(name, {});
        response.later([status](const http::Response& answer) { *status = answer.status; });
        return status;
    }
    std::shared_ptr<unsigned> save_that_hangs(const std::string& name = {}) {
        failing_disk.hangs = true;
        const auto status = save(name);
        EXPECT_TRUE(gateway.until([] { return failing_disk.hanging == 1; }));
        return status;
    }
    void change_to(const Settings& other) {
        bool is_changed = false;
        gateway.gateway().change(other, difference(gateway.gateway().settings(), other), 0s, [&] { is_changed = true; });
        ASSERT_TRUE(gateway.until([&] { return is_changed; }));
        recordings.configure();
    }
    int saved_for_lost_links() const { return saved_for("link-lost"); }
    int saved_for(const std::string& why) const {
        int count = 0;
        for (const auto& file : std::filesystem::directory_iterator{dir / "recordings"})
            count += file.path().string().ends_with("Z-" + why + ".pcapng");
        return count;
    }
    bool saves_failed() {
        nlohmann::ordered_json recording;
        static_cast<RecordingService&>(recordings).describe(recording);
        return recording.at("keep_last").at("error") != "";
    }
    /// The memory receives the next `count` frames.
    void receive(std::uint64_t count) {
        for (std::uint64_t i = 0; i < count; ++i)
            a.send(gateway.port("a"), support::frame(0xDC, 0xFF, 0x03, {1, 2, 3, 4, 5, 6, 0}));
        ASSERT_TRUE(gateway.until([&] { return gateway.count("a", "frames_in") == count; }));
    }
    void lose_the_link() {
        anogate::Gateway& its = gateway.gateway();
        its.parts().tell(&anogate::GatewayEvents::link_lost, its.links().front());
    }
    static std::size_t frames_in(const std::filesystem::path& file) {
        return support::read_pcapng(support::file_text(file)).items.size();
    }

    const support::Bytes fault = support::frame(0xDC, 0xFF, 0xA0, {1, 'b', 'a', 'd'});

    const support::TempDir dir;
    support::UdpPeer a;
    support::RunningGateway gateway{settings()};
    FrameWatch watch{gateway.gateway()};
    Recordings recordings{gateway.gateway(), watch, dir / "recordings"};
    const support::WellAgain well_again{};
};

TEST_F(RecordingsOfGateway, of_the_last_frames_refuse_a_second_save_while_the_first_waits_for_the_disk) {
    const auto first = save_that_hangs();
    EXPECT_EQ(*save(), 503u);
    failing_disk.hangs = false;
    ASSERT_TRUE(gateway.until([&] { return *first != 0; }));
    EXPECT_EQ(*first, 200u);
    const auto next = save();
    ASSERT_TRUE(gateway.until([&] { return *next != 0; }));
    EXPECT_EQ(*next, 200u);
    EXPECT_EQ(recordings.figures().saved, 2u);
}

TEST_F(RecordingsOfGateway, of_the_last_frames_for_a_fault_wait_for_the_save_of_a_client) {
    const auto first = save_that_hangs();
    lose_the_link();
    lose_the_link();
    EXPECT_EQ(recordings.figures().skipped, 1u) << "the second in one minute";
    gateway.run_for(50ms);
    EXPECT_EQ(failing_disk.hanging, 1) << "one at a time";
    failing_disk.hangs = false;
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().saved == 2; }));
    EXPECT_EQ(*first, 200u);
    EXPECT_EQ(saved_for_lost_links(), 1);
}

TEST_F(RecordingsOfGateway, of_the_last_frames_are_waited_for_at_the_end_and_answered) {
    const auto first = save_that_hangs();
    lose_the_link();
    recordings.stop();
    EXPECT_EQ(recordings.save_last({}, {}).status, 503u);
    EXPECT_EQ(*first, 0u);
    failing_disk.hangs = false;
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().saved == 2; }));
    EXPECT_EQ(*first, 200u);
    EXPECT_EQ(saved_for_lost_links(), 1);
}

TEST_F(RecordingsOfGateway, of_the_last_frames_that_are_due_at_the_end_are_saved) {
    lose_the_link();
    recordings.stop();
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().saved == 1; }));
    EXPECT_EQ(saved_for_lost_links(), 1);
}

TEST_F(RecordingsOfGateway, of_the_last_frames_use_the_settings_and_frames_of_the_time_of_the_event) {
    receive(3);
    const auto first = save_that_hangs();
    lose_the_link();
    Settings other = settings();
    other.record->keep_last = std::nullopt;
    other.record->folder = dir / "elsewhere";
    other.record->format = "mcap";
    change_to(other);
    failing_disk.hangs = false;
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().saved == 2; }));
    EXPECT_EQ(*first, 200u);
    EXPECT_EQ(saved_for_lost_links(), 1);
    for (const auto& file : std::filesystem::directory_iterator{dir / "recordings"}) EXPECT_EQ(frames_in(file), 3u) << file;
}

TEST_F(RecordingsOfGateway, of_the_last_frames_with_a_name_have_the_frames_of_the_time_of_the_request) {
    receive(3);
    const auto first = save("incident");
    Settings other = settings();
    other.record->keep_last = std::nullopt;
    change_to(other);
    ASSERT_TRUE(gateway.until([&] { return *first != 0; }));
    EXPECT_EQ(*first, 200u);
    EXPECT_EQ(frames_in(dir / "recordings/incident.pcapng"), 3u);
}

TEST_F(RecordingsOfGateway, of_the_last_frames_are_saved_for_a_fault_received_just_before_the_end) {
    receive(3);
    a.send(gateway.port("a"), fault);
    ASSERT_TRUE(gateway.until([&] { return gateway.count("a", "frames_in") == 4; }));
    recordings.stop();
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().saved == 1; }));
    EXPECT_EQ(saved_for("fault"), 1);
}

TEST_F(RecordingsOfGateway, of_the_last_frames_are_saved_for_a_fault_received_just_before_a_reload) {
    receive(3);
    Settings other = settings();
    other.record->keep_last = std::nullopt;
    a.send(gateway.port("a"), fault);
    ASSERT_TRUE(gateway.until([&] { return gateway.count("a", "frames_in") == 4; }));
    change_to(other);
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().saved == 1; }));
    EXPECT_EQ(saved_for("fault"), 1);
}

TEST_F(RecordingsOfGateway, of_the_last_frames_that_failed_are_retried_before_the_minute_ends) {
    failing_disk.write_error = ENOSPC;
    lose_the_link();
    lose_the_link();
    EXPECT_EQ(recordings.figures().skipped, 1u);
    ASSERT_TRUE(gateway.until([&] { return saves_failed(); }));
    failing_disk.write_error = 0;
    lose_the_link();
    EXPECT_EQ(recordings.figures().skipped, 2u) << "it is tried again in 5 s";
    gateway.run_for(Recordings::after_a_failed_save);
    lose_the_link();
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().saved == 1; }));
}

TEST_F(RecordingsOfGateway, of_the_last_frames_leave_no_file_if_memory_runs_out) {
    failing_disk.lacks_memory = true;
    const auto first = save("incident");
    ASSERT_TRUE(gateway.until([&] { return *first != 0; }));
    EXPECT_EQ(*first, 507u);
    EXPECT_FALSE(std::filesystem::exists(dir / "recordings/incident.pcapng"));
    failing_disk.lacks_memory = false;
    const auto next = save("incident");
    ASSERT_TRUE(gateway.until([&] { return *next != 0; }));
    EXPECT_EQ(*next, 200u) << "the name is free";
}

TEST_F(RecordingsOfGateway, of_the_last_frames_are_not_reported_as_saved_if_the_file_was_removed) {
    const auto first = save_that_hangs("incident");
    std::filesystem::remove_all(dir / "recordings");
    failing_disk.hangs = false;
    ASSERT_TRUE(gateway.until([&] { return *first != 0; }));
    EXPECT_EQ(*first, 507u);
    EXPECT_EQ(recordings.figures().saved, 0u);
}

TEST_F(RecordingsOfGateway, report_their_end_after_all_requests_are_answered) {
    const auto first = save_that_hangs();
    bool has_ended = false;
    recordings.stop([&] {
        EXPECT_EQ(*first, 200u);
        has_ended = true;
    });
    EXPECT_FALSE(has_ended);
    failing_disk.hangs = false;
    ASSERT_TRUE(gateway.until([&] { return has_ended; }));
}

TEST_F(RecordingsOfGateway, can_be_read_from_memory_by_two_clients_at_once) {
    http::Response first = recordings.last({});
    http::Response second = recordings.last({});
    EXPECT_EQ(first.status, 200u);
    EXPECT_EQ(second.status, 200u);
    const http::Response third = recordings.last({});
    EXPECT_EQ(third.status, 503u);
    EXPECT_NE(third.body.find("already being read by 2 clients"), std::string::npos) << third.body;
    first = {};
    const http::Response next = recordings.last({});
    EXPECT_EQ(next.status, 200u) << "one has them";
    EXPECT_EQ(recordings.last({}).status, 503u);
    std::string all;
    while (second.producer->next(all) == http::Producer::Next::part) {}
    EXPECT_EQ(recordings.last({}).status, 200u) << "all of them are made";
}

TEST_F(RecordingsOfGateway, are_not_started_repeatedly_while_the_disk_delays_their_end) {
    failing_disk.hangs = true;
    for (int i = 0; i < 20; ++i) {
        recordings.start_recording();
        recordings.stop_recording();
    }
    EXPECT_EQ(recordings.figures().running, Recordings::max_ending);
    EXPECT_NE(recordings.start_recording().find("not completely written"), std::string::npos);
    failing_disk.hangs = false;
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().running == 0; }));
    EXPECT_EQ(recordings.start_recording(), "");
    EXPECT_EQ(recordings.stop_recording(), "");
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().running == 0; }));
}

TEST_F(RecordingsOfGateway, that_a_reload_could_not_start_while_the_disk_hung_start_afterwards) {
    failing_disk.hangs = true;
    for (std::uint64_t size = 1'000'000; size < 5'000'000; size += 1'000'000) {
        Settings other = settings();
        other.record->start = true;
        other.record->rotate_size = size;
        change_to(other);
    }
    EXPECT_EQ(recordings.figures().running, Recordings::max_ending);
    failing_disk.hangs = false;
    ASSERT_TRUE(gateway.until([&] { return recordings.figures().running == 1 && recordings.figures().failing == 0; }));
    EXPECT_EQ(recordings.start_recording(), "a recording is already in progress");
}

}    // namespace
}    // namespace recordings_of_gateway_tests
