// Recordings of the gateway: by its configuration, on request, of the most recent frames; and the files that it leaves alone.
#include <support/pty_device.hpp>
#include <support/recorded.hpp>
#include <support/recorded_files.hpp>
#include <support/recording_gateway.hpp>
#include <support/sanitized.hpp>
#include <support/small_disk.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace recordings_tests {
namespace {

namespace fs = std::filesystem;
using namespace support;
using anogate::http::Answer;
using nlohmann::json;

const Bytes wind = frame(0xDD, 0xFF, 0x09, {1, 0, 2, 0});

constexpr auto reported_within = std::chrono::seconds{2} * (sanitized ? 5 : 1);    // one second, plus a margin for a busy machine

class Recordings : public RecordingGateway {
protected:
    /// The first of the running recordings.
    json running() const { return gateway->status().at("recording").at("running").at(0); }
    bool until_error(const std::string& words) const {
        return gateway->until([&](const json& status) {
            const json& all = status.at("recording").at("running");
            return !all.empty() && all[0].at("error").get<std::string>().find(words) != std::string::npos;
        });
    }
    std::string metric(const std::string& name) const {
        const std::string all = ask("GET", "/metrics").body;
        const std::size_t at = all.find("\n" + name + " ");
        if (at == std::string::npos) return {};
        const std::size_t begin = at + name.size() + 2;
        return all.substr(begin, all.find('\n', begin) - begin);
    }
};

TEST_F(Recordings, are_made_on_request_listed_fetched_and_deleted) {
    start();
    const json begun = begin({{"name", "flight"}});
    EXPECT_EQ(begun.at("name"), "flight");
    EXPECT_EQ(begun.at("file"), "flight.pcapng");
    EXPECT_EQ(begun.at("by"), "request");
    send_numbered(50);
    EXPECT_TRUE(until([](const json& all) { return all.at("running").at(0).at("frames") == 50; }));
    EXPECT_EQ(file_called("flight.pcapng").at("state"), "recording");
    EXPECT_EQ(gateway->status().at("recording").at("running").at(0).at("name"), "flight");
    refuses(409, "DELETE", "/recordings/flight.pcapng", {}, "is still being recorded");
    refuses(409, "POST", "/recordings", R"({"name": "flight"})", "is already being recorded");

    const json ended = end("flight");
    EXPECT_EQ(ended.at("frames"), 50);
    EXPECT_EQ(ended.at("not_written"), 0);
    const json file = file_called("flight.pcapng");
    EXPECT_EQ(file.at("state"), "ended");
    EXPECT_EQ(file.at("frames"), 50);
    EXPECT_EQ(file.at("bytes"), ended.at("bytes"));
    EXPECT_GT(file.at("time").get<double>() + 0.02, file.at("begun")) << "both with what is behind the second";
    struct stat is {};
    ASSERT_EQ(::stat((folder + "/flight.pcapng").c_str(), &is), 0);
    EXPECT_EQ(is.st_mode & 07777, 0640u);

    const auto read = read_pcapng(content("flight.pcapng"));
    EXPECT_TRUE(read.has_end);
    ASSERT_EQ(read.items.size(), 50u);
    for (int i = 0; i < 50; ++i) EXPECT_EQ(read.items[static_cast<std::size_t>(i)].frame, numbered(0xDC, 0xFF, i));
    EXPECT_EQ(ask("GET", "/recordings/flight.pcapng").body, content("flight.pcapng"));

    refuses(409, "POST", "/recordings", R"({"name": "flight"})", "flight.pcapng already exists");
    refuses(409, "POST", "/recordings", R"({"name": "flight.mcap"})", "flight.pcapng already exists");
    EXPECT_EQ(ask("DELETE", "/recordings/flight.pcapng").status, 200u);
    EXPECT_TRUE(names().empty());
    refuses(404, "GET", "/recordings/flight.pcapng", {}, "there is no recording flight.pcapng");
}

TEST_F(Recordings, are_ended_by_name_with_or_without_extension_whichever_file_is_being_written) {
    start(R"(, "record": {"start": false, "rotate": {"size": "20kB"}})");
    for (std::string name : {"flight", "flight.pcapng", ""}) {
        begin({{"name", "flight"}});
        for (int frames = 150; frames < 50 * 150 && running().at("files") < 2; frames += 150) {
            send_numbered(150);
            ASSERT_TRUE(until([&](const json& all) { return all.at("running").at(0).at("frames") == frames; })) << get();
        }
        if (name.empty()) name = running().at("file");
        refuses(404, "POST", "/recordings/fligth/end", {}, "is in progress (did you mean 'flight'?)");
        EXPECT_GE(end(name).at("files"), 2) << name;
        refuses(404, "POST", "/recordings/flight/end", {}, "is in progress; see anoctl recordings");
        refuses(404, "DELETE", "/recordings/flight", {}, "there is no recording flight; there is flight.pcapng");
        for (const auto& file : names()) EXPECT_EQ(ask("DELETE", "/recordings/" + file).status, 200u) << file;
    }
}

TEST_F(Recordings, contain_frames_that_pass_their_filters_and_end_after_the_given_time) {
    start();
    begin({{"name", "in"}, {"id", {"wind"}}, {"seconds", 1}});
    begin({{"name", "all"}, {"direction", {"in", "out", "dropped"}}, {"from", "0xDD"}, {"link", "a"}});
    for (int i = 0; i < 5; ++i) {
        send(euler);
        send(wind);
    }
    ASSERT_TRUE(until([](const json& all) { return all.at("running").size() == 1; })) << "one second is over";
    EXPECT_EQ(file_called("in.pcapng").at("frames"), 5);
    EXPECT_EQ(end("all").at("frames"), 10) << "each came in, and had no other link to leave by";
    for (const auto& item : read_pcapng(content("in.pcapng")).items) EXPECT_EQ(item.frame, wind);
    for (const auto& item : read_pcapng(content("all.pcapng")).items) EXPECT_EQ(item.frame, wind);
}

TEST_F(Recordings, have_portable_names_and_are_named_by_the_time_by_default) {
    start();
    for (const char* name : {"../x", "a/b", ".x", "..", "a b", "ä", "x\n"})
        refuses(422, "POST", "/recordings", json{{"name", name}}.dump(), "no leading dot");
    refuses(422, "POST", "/recordings", json{{"name", std::string(101, 'x')}}.dump(), "this one has 101");
    refuses(422, "POST", "/recordings", R"({"name": "a.pcapng", "format": "mcap"})", "the file extension means pcapng");
    refuses(422, "POST", "/recordings", R"({"format": "mp4"})", "neither pcapng nor mcap");
    refuses(422, "POST", "/recordings", R"({"format": "mcap", "message_encoding": "xml"})", "neither cdr nor json");
    refuses(422, "POST", "/recordings", R"({"message_encoding": "json"})", "use format mcap");
    refuses(422, "POST", "/recordings", R"({"seconds": -1})", "seconds");
    refuses(422, "POST", "/recordings", R"({"link": "b"})", "there is no link 'b'");
    refuses(422, "POST", "/recordings", "[]", "a JSON object");
    EXPECT_FALSE(fs::exists(folder));
    const json begun = begin(json::object());
    EXPECT_TRUE(begun.at("name").get<std::string>().ends_with("Z")) << begun;
    EXPECT_EQ(end(begun.at("name")).at("file"), begun.at("file"));
    EXPECT_EQ(begin({{"name", std::string(100, 'x')}}).at("file"), std::string(100, 'x') + ".pcapng");
    end(std::string(100, 'x'));
    EXPECT_EQ(file_called(std::string(100, 'x') + ".pcapng").at("state"), "ended");
}

TEST_F(Recordings, are_limited_to_four_at_once_in_addition_to_the_configured_one) {
    start(R"(, "record": {})");
    for (const char* name : {"1", "2", "3", "4"}) begin({{"name", name}});
    refuses(409, "POST", "/recordings", R"({"name": "5"})", "4 requested recordings");
    end("2");
    begin({{"name", "5"}});
    EXPECT_EQ(get().at("running").size(), 5u);
}

TEST_F(Recordings, leave_files_alone_that_the_gateway_did_not_write) {
    fs::create_directories(folder);
    const std::string secret = dir.write("secret.pcapng", "secret");
    std::ofstream{folder + "/notes.pcapng"} << "not ours";
    fs::create_symlink(secret, folder + "/link.pcapng");
    ASSERT_EQ(::mkfifo((folder + "/pipe.pcapng").c_str(), 0600), 0);
    start();
    EXPECT_EQ(get().at("others"), 3);
    EXPECT_EQ(get().at("recordings"), json::array());
    for (const char* name : {"notes.pcapng", "link.pcapng", "pipe.pcapng"}) {
        const std::string target = std::string{"/recordings/"} + name;
        refuses(403, "GET", target, {}, "left alone");
        refuses(403, "DELETE", target, {}, "left alone");
    }
    refuses(422, "GET", "/recordings/..%2Fsecret.pcapng", {}, "no leading dot");
    refuses(422, "DELETE", "/recordings/..%2F..%2Fsecret.pcapng", {}, "no leading dot");
    refuses(409, "POST", "/recordings", R"({"name": "link"})", "already exists");
    EXPECT_EQ(file_text(secret), "secret");
    EXPECT_EQ(names().size(), 3u);
}

TEST_F(Recordings, are_fetched_in_ranges) {
    start();
    begin({{"name", "flight"}});
    send_numbered(200);
    end("flight");
    const std::string whole = content("flight.pcapng");
    const auto part = [&](const std::string& range, const std::string& more = {}) {
        return http(socket, "GET /recordings/flight.pcapng HTTP/1.1\r\nHost: a\r\nConnection: close\r\nRange: bytes=" + range +
                                "\r\n" + more + "\r\n");
    };
    const std::string middle = part("100-199");
    EXPECT_TRUE(middle.starts_with("HTTP/1.1 206 ")) << middle;
    EXPECT_NE(middle.find("\r\nContent-Range: bytes 100-199/" + std::to_string(whole.size()) + "\r\n"), std::string::npos);
    EXPECT_NE(middle.find("\r\nContent-Length: 100\r\n"), std::string::npos);
    EXPECT_EQ(body_of(middle), whole.substr(100, 100));
    EXPECT_EQ(body_of(part("-50")), whole.substr(whole.size() - 50));
    EXPECT_TRUE(part(std::to_string(whole.size()) + "-").starts_with("HTTP/1.1 416 "));
    const auto tag_at = middle.find("\r\nETag: ") + 8;
    const std::string tag = middle.substr(tag_at, middle.find('\r', tag_at) - tag_at);
    EXPECT_TRUE(part("0-9", "If-Range: " + tag + "\r\n").starts_with("HTTP/1.1 206 "));
    EXPECT_TRUE(part("0-9", "If-Range: \"another\"\r\n").starts_with("HTTP/1.1 200 ")) << "another file is sent whole";
    const std::string head = http(socket, "HEAD /recordings/flight.pcapng HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n");
    EXPECT_NE(head.find("\r\nContent-Length: " + std::to_string(whole.size()) + "\r\n"), std::string::npos) << head;
    EXPECT_EQ(body_of(head), "");
}

TEST_F(Recordings, begin_and_end_with_the_gateway_if_configured) {
    start(R"(, "record": {"direction": ["in", "out"]})");
    ASSERT_TRUE(until([](const json& all) { return all.at("running").size() == 1 && all.at("running")[0].at("files") == 1; }));
    EXPECT_EQ(get().at("running").at(0).at("by"), "configuration");
    send_numbered(20);
    stop();
    ASSERT_EQ(names().size(), 1u);
    const auto read = read_pcapng(content(names()[0]));
    EXPECT_TRUE(read.has_end) << "what waited was written";
    EXPECT_EQ(read.items.size(), 20u);
}

TEST_F(Recordings, lose_at_most_a_second_when_the_gateway_is_killed_and_are_repaired_at_the_next_start) {
    start(R"(, "record": {})");
    send_numbered(30);
    std::this_thread::sleep_for(std::chrono::seconds{1});    // until no earlier frame can be missing
    send_numbered(10);
    gateway->signal(SIGKILL);
    gateway->wait();
    ASSERT_EQ(names().size(), 1u);
    const std::string first = names()[0];
    EXPECT_FALSE(read_pcapng(content(first)).has_end);
    start(R"(, "record": {"start": false})");
    ASSERT_TRUE(wait_until([&] { return file_called(first).at("state") == "ended"; })) << gateway->output();
    EXPECT_TRUE(gateway->until_says("repaired the truncated " + first));
    const auto read = read_pcapng(content(first));
    EXPECT_TRUE(read.has_end);
    ASSERT_GE(read.items.size(), 30u);
    for (std::size_t i = 0; i < read.items.size(); ++i) EXPECT_EQ(read.items[i].frame, numbered(0xDC, 0xFF, static_cast<int>(i)));
}

TEST_F(Recordings, continue_without_a_gap_when_a_reload_does_not_affect_them) {
    start(R"(, "record": {})");
    send_numbered(20);
    const json before = get().at("running").at(0);
    write_config(R"(, "record": {"keep_last": "10s", "keep": {"size": "1GB"}})", R"(, "sim:fc")");
    gateway->signal(SIGHUP);
    ASSERT_TRUE(gateway->until_up("fc"));
    EXPECT_TRUE(gateway->until_says("reload: record.keep.size: 0 -> 1GB")) << gateway->output();
    send_numbered(20);
    EXPECT_EQ(get().at("running").at(0).at("name"), before.at("name"));
    EXPECT_EQ(get().at("keep_last").at("seconds"), 10.0);

    write_config(R"(, "record": {"direction": ["in", "dropped"]})", R"(, "sim:fc")");
    gateway->signal(SIGHUP);
    ASSERT_TRUE(gateway->until_says("reload: record.direction: in -> in, dropped")) << gateway->output();
    send_numbered(20);
    ASSERT_TRUE(until([](const json& all) { return all.at("running").size() == 1 && all.at("recordings").size() == 2; }));
    write_config("", R"(, "sim:fc")");
    gateway->signal(SIGHUP);
    ASSERT_TRUE(until([](const json& all) { return all.at("running").empty(); }));
    std::vector<Bytes> all;
    std::vector<std::pair<fs::file_time_type, std::string>> files;
    for (const std::string& name : names()) files.emplace_back(fs::last_write_time(folder + "/" + name), name);
    std::sort(files.begin(), files.end());
    for (const auto& [time, name] : files)
        for (const auto& item : read_pcapng(content(name)).items)
            if (item.link == "a") all.push_back(item.frame);
    ASSERT_EQ(all.size(), 60u);
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i], numbered(0xDC, 0xFF, static_cast<int>(i)));
}

TEST_F(Recordings, on_a_disk_without_free_space_report_an_error_within_a_second_while_frames_are_forwarded) {
    start(R"(, "record": {"free": "1000000GB"})");
    const auto begun = std::chrono::steady_clock::now();
    const auto is_failing = [](const json& status) {
        const json& running = status.at("recording").at("running");
        return !running.empty() && !running[0].at("error").get<std::string>().empty();
    };
    ASSERT_TRUE(gateway->until(is_failing)) << gateway->output();
    EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds{2} * (support::sanitized ? 5 : 1));
    EXPECT_TRUE(gateway->until_says("frames are still forwarded, but are not recorded")) << gateway->output();
    EXPECT_NE(ask("GET", "/metrics").body.find("\nanogate_recording_failing 1\n"), std::string::npos);
    send_numbered(20);
    refuses(507, "POST", "/recordings", R"({"name": "flight"})", "recording did not start: ");
    EXPECT_TRUE(until([](const json& all) { return all.at("running").size() == 1; })) << "what could not begin has ended";
    const json ended = end(get().at("running").at(0).at("name"));
    EXPECT_EQ(ended.at("frames"), 0);
    EXPECT_EQ(ended.at("not_written"), 20) << "they waited in memory for the disk";
    EXPECT_TRUE(names().empty());
}

TEST_F(Recordings, on_a_disk_that_is_read_only_at_first_report_an_error_and_begin_when_it_is_writable) {
    fs::create_directories(folder);
    const SmallDisk disk{folder, "4m"};
    if (!disk.why_not().empty() || !disk.read_only(true)) GTEST_SKIP() << disk.why_not();
    start(R"(, "record": {"free": 0})");
    const auto begun = std::chrono::steady_clock::now();
    ASSERT_TRUE(until_error("Read-only file system"));
    EXPECT_LT(std::chrono::steady_clock::now() - begun, reported_within);
    EXPECT_TRUE(gateway->until_says("Read-only file system; frames are still forwarded, but are not recorded"))
        << gateway->output();
    EXPECT_EQ(metric("anogate_recording_failing"), "1");
    refuses(507, "POST", "/recordings", R"({"name": "flight"})", "recording did not start: ");
    send_numbered(20);
    ASSERT_TRUE(disk.read_only(false));
    ASSERT_TRUE(until([](const json& all) { return all.at("running").at(0).at("frames") == 20; })) << get();
    EXPECT_EQ(running().at("error"), "");
    EXPECT_EQ(running().at("not_written"), 0) << "they waited in memory";
    EXPECT_EQ(metric("anogate_recording_failing"), "0");
    stop();
    ASSERT_EQ(names().size(), 1u) << testing::PrintToString(names()) << gateway->output();
    EXPECT_EQ(read_pcapng(content(names()[0])).items.size(), 20u);
}

TEST_F(Recordings, on_a_full_disk_report_an_error_within_a_second_and_count_the_missing_frames) {
    fs::create_directories(folder);
    const SmallDisk disk{folder, "64k"};
    if (!disk.why_not().empty()) GTEST_SKIP() << disk.why_not();
    start(R"(, "record": {"free": 0})");
    ASSERT_TRUE(until([](const json& all) { return all.at("running").size() == 1 && all.at("running")[0].at("files") == 1; }));
    std::ofstream{folder + "/filler"} << std::string(64 * 1024, '.') << std::flush;
    const auto begun = std::chrono::steady_clock::now();
    send_numbered(200);
    ASSERT_TRUE(until_error("No space left on device"));
    EXPECT_LT(std::chrono::steady_clock::now() - begun, reported_within);
    EXPECT_TRUE(gateway->until_says("No space left on device; frames are still forwarded, but are not recorded"))
        << gateway->output();
    EXPECT_EQ(metric("anogate_recording_failing"), "1");
    send_numbered(20);
    const json ended = end(running().at("name"));
    EXPECT_EQ(ended.at("frames").get<int>() + ended.at("not_written").get<int>(), 220);
    EXPECT_GE(ended.at("not_written"), 20);
    EXPECT_EQ(metric("anogate_recording_not_written_total"), ended.at("not_written").dump());
}

TEST_F(Recordings, are_rotated_and_deleted_by_size_as_configured) {
    start(R"(, "record": {"rotate": {"size": "20kB"}, "keep": {"size": "100kB"}})");
    // The first look treats the files that it finds as older ones.
    ASSERT_TRUE(until([](const json& all) { return !all.at("free_bytes").is_null(); }));
    const auto gone = [&] { return gateway->output().find(" as configured by \"keep\"") != std::string::npos; };
    for (int round = 0; round < 50 && !gone(); ++round) {
        send_numbered(150);
        ASSERT_TRUE(until([&](const json& all) { return all.at("running").at(0).at("frames") == sent_; })) << get();
    }
    ASSERT_TRUE(gone()) << gateway->output();
    const std::string name = running().at("name");
    const int files = running().at("files");
    EXPECT_GE(files, 3);
    stop();
    std::vector<int> numbers;
    int left = 0;
    for (int number = 1; number <= 100; ++number) {
        const std::string file = folder + "/" + name + (number > 1 ? "-" + std::to_string(number) : "") + ".pcapng";
        if (!fs::exists(file)) continue;
        const auto read = read_pcapng(file_text(file));
        EXPECT_TRUE(read.has_end) << file;
        EXPECT_LT(fs::file_size(file), 60'000u) << file;
        for (const auto& item : read.items) numbers.push_back(number_of(item.frame));
        ++left;
    }
    EXPECT_LT(left, files) << "the oldest went";
    ASSERT_FALSE(numbers.empty());
    for (std::size_t i = 1; i < numbers.size(); ++i) ASSERT_EQ(numbers[i], numbers[i - 1] + 1);
    EXPECT_EQ(numbers.back(), sent_ - 1);
}

TEST_F(Recordings, of_recent_frames_are_saved_on_request) {
    start(R"(, "record": {"start": false, "keep_last": "60s"})");
    send_numbered(40);
    EXPECT_TRUE(until([](const json& all) { return all.at("keep_last").at("frames") == 40; }));
    const auto fetched = read_pcapng(ask("GET", "/recordings/last").body);
    EXPECT_TRUE(fetched.has_end);
    EXPECT_EQ(fetched.items.size(), 40u);
    const Answer saved = ask("POST", "/recordings", R"({"last": true, "name": "incident"})");
    EXPECT_EQ(saved.status, 200u) << saved.body;
    EXPECT_EQ(json::parse(saved.body).at("name"), "incident.pcapng");
    const auto read = read_pcapng(content("incident.pcapng"));
    ASSERT_EQ(read.items.size(), 40u);
    for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(read.items[i].frame, numbered(0xDC, 0xFF, static_cast<int>(i)));
    EXPECT_EQ(read.items[0].link, "a");
    const auto span = static_cast<double>(read.items[39].boottime_ns - read.items[0].boottime_ns) / 1e9;
    EXPECT_DOUBLE_EQ(file_called("incident.pcapng").at("seconds").get<double>(), span) << "of what it has, whenever it was saved";
    refuses(409, "POST", "/recordings", R"({"last": true, "name": "incident"})", "already exists");
    refuses(422, "POST", "/recordings", R"({"last": true, "id": "euler"})", "as it is");
}

TEST_F(Recordings, of_recent_frames_lose_nothing_when_a_reload_extends_the_time_span) {
    start(R"(, "record": {"start": false, "keep_last": "60s"})");
    send_numbered(40);
    write_config(R"(, "record": {"start": false, "keep_last": "120s"})");
    gateway->signal(SIGHUP);
    ASSERT_TRUE(gateway->until_says("reload: record.keep_last: 1m -> 2m")) << gateway->output();
    ASSERT_EQ(ask("POST", "/recordings", R"({"last": true, "name": "incident"})").status, 200u);
    EXPECT_EQ(read_pcapng(content("incident.pcapng")).items.size(), 40u);
}

TEST_F(Recordings, of_recent_frames_that_exceed_the_size_limit_stay_until_they_can_be_fetched) {
    start(R"(, "record": {"keep_last": "60s", "rotate": {"size": "10kB"}, "keep": {"size": "100kB"}})");
    send_numbered(1500);
    ASSERT_TRUE(until([](const json& all) {
        return all.at("keep_last").at("frames") == 1500 && all.at("running").at(0).at("frames") == 1500;
    })) << get();
    ASSERT_EQ(ask("POST", "/recordings", R"({"last": true, "name": "incident"})").status, 200u);
    ASSERT_GT(fs::file_size(folder + "/incident.pcapng"), 100'000u);
    EXPECT_TRUE(gateway->until_says("incident.pcapng is kept although it exceeds \"keep\": keep.size is too small"));
    const int files = running().at("files");
    for (int round = 0; round < 50 && running().at("files") < files + 3; ++round) {
        send_numbered(150);
        ASSERT_TRUE(until([&](const json& all) { return all.at("running").at(0).at("frames") == sent_; })) << get();
    }
    EXPECT_EQ(read_pcapng(content("incident.pcapng")).items.size(), 1500u);
}

TEST_F(Recordings, of_recent_frames_are_saved_when_a_device_logs_a_fault_at_most_once_a_minute) {
    start(R"(, "record": {"start": false, "keep_last": "60s", "id": ["euler"]}, "routes": [{"address": "0xDC", "link": "a"}])");
    send(frame(0xDC, 0xFF, 0xA0, {0, 'o', 'k'}));
    for (const std::uint8_t stranger : Bytes{0x21, 0x22}) send(frame(stranger, 0xFF, 0xA0, {1, 'b', 'a', 'd'}));
    send(euler);
    ASSERT_TRUE(until([](const json& all) { return all.at("keep_last").at("frames") == 1; }));
    EXPECT_EQ(get().at("keep_last").at("saved"), 0)
        << "a line in no colour is no fault, and one from a network counts only where the address is pinned";
    send(frame(0xDC, 0xFF, 0xA0, {1, 'b', 'a', 'd'}));
    ASSERT_TRUE(until([](const json& all) { return all.at("keep_last").at("saved") == 1; })) << gateway->output();
    const std::string name = get().at("keep_last").at("last");
    EXPECT_TRUE(name.ends_with("Z-fault.pcapng")) << name;
    EXPECT_EQ(read_pcapng(content(name)).items.size(), 1u);
    send(frame(0xDC, 0xFF, 0xA0, {1, 'b', 'a', 'd'}));
    ASSERT_TRUE(until([](const json& all) { return all.at("keep_last").at("skipped") == 1; }));
    EXPECT_EQ(get().at("keep_last").at("saved"), 1);
}

TEST_F(Recordings, of_recent_frames_are_saved_for_a_fault_of_a_serial_device_but_not_for_a_forged_one) {
    PtyDevice device{dir / "tty"};
    start(R"(, "record": {"start": false, "keep_last": "60s"})", R"(, "serial:)" + (dir / "tty") + R"(,name=fc")");
    ASSERT_TRUE(gateway->until_up("fc"));
    device.write(frame(0xDC, 0xFF, 0xA0, {0, 'o', 'k'}));
    ASSERT_TRUE(until([](const json& all) { return all.at("keep_last").at("frames") == 1; }));
    for (std::uint8_t n = 0; n < 3; ++n) send(frame(0xDC, 0xFF, 0xA0, {1, 'b', 'a', 'd', n}));
    ASSERT_TRUE(until([](const json& all) { return all.at("keep_last").at("frames") == 4; }));
    EXPECT_EQ(get().at("keep_last").at("saved"), 0);
    device.write(frame(0xDC, 0xFF, 0xA0, {1, 'b', 'a', 'd'}));
    EXPECT_TRUE(until([](const json& all) { return all.at("keep_last").at("saved") == 1; })) << gateway->output();
}

TEST_F(Recordings, of_recent_frames_are_saved_when_a_link_is_lost) {
    PtyDevice device{dir / "tty"};
    start(R"(, "record": {"start": false, "keep_last": "60s"})", R"(, "serial:)" + (dir / "tty") + R"(,name=fc")");
    ASSERT_TRUE(gateway->until_up("fc"));
    send_numbered(10);
    device.unplug();
    ASSERT_TRUE(until([](const json& all) { return all.at("keep_last").at("saved") == 1; })) << gateway->output();
    const std::string name = get().at("keep_last").at("last");
    EXPECT_TRUE(name.ends_with("Z-link-lost.pcapng")) << name;
    EXPECT_EQ(read_pcapng(content(name)).items.size(), 10u);
}

TEST_F(Recordings, are_deleted_as_configured_if_the_gateway_wrote_them) {
    fs::create_directories(folder);
    std::ofstream{folder + "/notes.pcapng"} << std::string(100'000, 'x');
    start();
    for (const char* name : {"first", "second", "third"}) {
        begin({{"name", name}});
        send_numbered(100);
        end(name);
    }
    const auto now = fs::file_time_type::clock::now();
    fs::last_write_time(folder + "/first.pcapng", now - std::chrono::hours{4});
    fs::last_write_time(folder + "/second.pcapng", now - std::chrono::hours{2});
    write_config(R"(, "record": {"start": false, "keep": {"age": "1h"}})");
    gateway->signal(SIGHUP);
    EXPECT_TRUE(gateway->until_says("deleted first.pcapng as configured by \"keep\"")) << gateway->output();
    EXPECT_EQ(names(), (std::vector<std::string>{"notes.pcapng", "second.pcapng", "third.pcapng"}));
}

TEST_F(Recordings, of_the_minute_before_a_restart_stay_even_above_the_limits_of_keep) {
    start();
    for (const char* name : {"old", "last", "newest"}) {
        begin({{"name", name}});
        send_numbered(1500);
        end(name);
    }
    stop();
    fs::last_write_time(folder + "/old.pcapng", fs::file_time_type::clock::now() - std::chrono::hours{4});
    start(R"(, "record": {"start": false, "rotate": {"size": "100kB"}, "keep": {"size": "100kB"}})");
    EXPECT_TRUE(gateway->until_says("deleted old.pcapng as configured by \"keep\"")) << gateway->output();
    EXPECT_EQ(names(), (std::vector<std::string>{"last.pcapng", "newest.pcapng"}));
}

TEST_F(Recordings, of_the_minute_before_a_restart_stay_also_when_keep_is_added_later) {
    start();
    for (const char* name : {"last", "newest"}) {
        begin({{"name", name}});
        send_numbered(1500);
        end(name);
    }
    stop();
    for (const char* name : {"/last.pcapng", "/newest.pcapng"})    // not in the same second as the start
        fs::last_write_time(folder + name, fs::file_time_type::clock::now() - std::chrono::seconds{10});
    start(R"(, "record": {"start": false})");
    ASSERT_TRUE(until([](const json& all) { return all.at("recordings").size() == 2; }));
    write_config(R"(, "record": {"start": false, "keep": {"size": "100kB"}})");
    gateway->signal(SIGHUP);
    EXPECT_TRUE(gateway->until_says("newest.pcapng is kept although it exceeds \"keep\"")) << gateway->output();
    EXPECT_EQ(names(), (std::vector<std::string>{"last.pcapng", "newest.pcapng"}));
}

TEST_F(Recordings, of_a_gateway_that_is_a_device_are_started_and_stopped_by_its_commands) {
    write_config("");
    dir.write("anogate.json", R"({"gateway": {"id": 199}, "links": [")" + a.link("a") + R"("]})");
    gateway = std::make_unique<Daemon>(ANOGATED, socket, std::vector<std::string>{"--config", dir / "anogate.json"});
    ASSERT_TRUE(gateway->until_answers()) << gateway->output();
    const auto call = [&](const char* command) {
        return ask("POST", std::string{"/devices/199/commands/"} + command, R"({"values": []})").status;
    };
    EXPECT_EQ(call("START_RECORDING"), 200u);
    EXPECT_TRUE(until([](const json& all) { return all.at("running").size() == 1; }));
    EXPECT_NE(call("START_RECORDING"), 200u) << "a recording is already in progress";
    EXPECT_EQ(call("STOP_RECORDING"), 200u);
    EXPECT_TRUE(until([](const json& all) { return all.at("running").empty() && all.at("recordings").size() == 1; }));
    EXPECT_NE(call("STOP_RECORDING"), 200u);
}

TEST_F(Recordings, are_listed_and_fetched_but_not_made_or_deleted_with_the_read_only_token) {
    const std::string looks = "view-token-0123456789";
    fs::permissions(dir.write("token", "view " + looks + "\n"), fs::perms{0600});
    start("", {});
    stop();
    dir.write("anogate.json", R"({"links": [")" + a.link("a") + R"("], "control": {"http": "127.0.0.1:0", "token_file": ")" +
                                  (dir / "token") + "\"}}");
    gateway = std::make_unique<Daemon>(ANOGATED, socket, std::vector<std::string>{"--config", dir / "anogate.json"});
    ASSERT_TRUE(gateway->until_answers()) << gateway->output();
    begin({{"name", "flight"}});
    end("flight");
    const auto port = gateway->status().at("http").at("port").get<std::uint16_t>();
    const auto code = [&](const std::string& line, const std::string& body = {}) {
        const std::string answer = http(
            port,
            line + " HTTP/1.1\r\nHost: localhost\r\nVia: 1.1 test\r\nConnection: close\r\nContent-Type: application/json\r\n" +
                "Content-Length: " + std::to_string(body.size()) + "\r\nAuthorization: Bearer " + looks + "\r\n\r\n" + body);
        return answer.size() > 12 ? answer.substr(9, 3) : answer;
    };
    EXPECT_EQ(code("GET /recordings"), "200");
    EXPECT_EQ(code("GET /recordings/flight.pcapng"), "200");
    EXPECT_EQ(code("POST /recordings", R"({"name": "another"})"), "403");
    EXPECT_EQ(code("POST /recordings", R"({"last": true})"), "403");
    EXPECT_EQ(code("POST /recordings/flight/end"), "403");
    EXPECT_EQ(code("DELETE /recordings/flight.pcapng"), "403");
    EXPECT_EQ(names(), std::vector<std::string>{"flight.pcapng"});
}

}    // namespace
}    // namespace recordings_tests
