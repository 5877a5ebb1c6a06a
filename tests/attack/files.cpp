// Files with unexpected types, damaged files, and files that were written halfway.
#include <http/client/certificate.hpp>
#include <support/process.hpp>
#include <support/small_disk.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <filesystem>
#include <fstream>

namespace attack_files_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
namespace fs = std::filesystem;

constexpr auto soon = 20s;    // a start takes a moment; a hanging one never ends

class Files : public testing::Test {
protected:
    std::string config() { return dir / "anogate.json"; }
    std::vector<std::string> environment() { return {"STATE_DIRECTORY=" + (dir / "state")}; }
    std::string write_atomically(const std::string& what) {
        std::error_code ec;
        const std::string absolute = fs::weakly_canonical(fs::absolute(config(), ec), ec).string();
        return dir / ("state/" + what + "-" + std::to_string(std::hash<std::string>{}(absolute)));
    }

    TempDir dir;
    std::string written = dir.write("anogate.json", R"({"links": ["udp-listen:127.0.0.1:0,name=ground"]})");
};

TEST_F(Files, that_are_pipes_block_neither_check_nor_start_nor_reload) {
    Daemon running{ANOGATED, dir / "control.sock", {"--config", config()}, environment()};
    ASSERT_TRUE(running.until_answers()) << running.output();
    fs::create_directory(dir / "conf.d");
    ASSERT_EQ(::mkfifo((dir / "conf.d/pipe.json").c_str(), 0600), 0);
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"--check", "--config", config()}, {"--config", config()}}) {
        Process program{ANOGATED, arguments, environment()};
        EXPECT_EQ(program.wait(soon), 78) << program.output();
        EXPECT_NE(program.output().find("pipe.json: is not a regular file"), std::string::npos) << program.output();
    }
    const std::string answer = http(dir / "control.sock", "POST /reload HTTP/1.0\r\n\r\n");
    EXPECT_NE(answer.find("is not a regular file"), std::string::npos) << answer;
    EXPECT_TRUE(running.until_answers());
    Process pipe{ANOGATED, {"--check", "--config", dir / "conf.d/pipe.json"}, environment()};
    EXPECT_EQ(pipe.wait(soon), 78) << pipe.output();
}

TEST_F(Files, that_an_earlier_run_left_damaged_are_logged_and_do_not_prevent_the_start) {
    fs::create_directory(dir / "state");
    for (const std::string& bytes :
         {std::string(1'000'000, '\x81'), std::string(1'000'000, '\x7F'), std::string{"nonsense"}, std::string{}}) {
        std::ofstream{write_atomically("unconfirmed"), std::ios::binary} << bytes;
        std::ofstream{dir / "state/flexible.json", std::ios::binary} << bytes;
        Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config()}, environment()};
        EXPECT_TRUE(daemon.until_answers()) << daemon.output();
        EXPECT_NE(daemon.output().find("unconfirmed-"), std::string::npos) << daemon.output();
        EXPECT_NE(daemon.output().find("damaged; remove it"), std::string::npos) << daemon.output();
        EXPECT_TRUE(daemon.until_says("flexible.json")) << daemon.output();
    }
}

TEST_F(Files, a_damaged_record_of_a_firmware_update_is_reported_and_does_not_block_the_start) {
    fs::create_directory(dir / "state");
    const std::string sound = R"({"device": {"address": "0xDE", "name": "FC"}})";
    std::ofstream{dir / "state/firmware-0xDC.json"} << "{\"device\": {";
    std::ofstream{dir / "state/firmware-0xDD-12ab34cd.json"} << std::string(100'000, '[');
    std::ofstream{dir / "state/firmware-0xDE.json"} << sound;
    Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config()}, environment()};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    const std::string said = daemon.output();
    EXPECT_NE(said.find("state/firmware-0xDC.json is damaged and ignored: the device 0xDC may be in its boot loader"),
              std::string::npos)
        << said;
    EXPECT_NE(said.find("state/firmware-0xDD-12ab34cd.json"), std::string::npos) << said;
    EXPECT_NE(said.find("FC (0xDE)) is not used: it is of an older version"), std::string::npos) << said;
}

// The stored state of a device: alarm limits, and each kind of note.
constexpr const char* of_devices[] = {"limits-0xDC.json", "firmware-0xDC-12ab34cd.json", "type7-0xDC-12ab34cd.json",
                                      "calibration-0xDC-12ab34cd-compass.json", "calibration-0xDC-12ab34cd-accelerometer.json"};

TEST_F(Files, of_devices_that_are_not_regular_files_are_logged_and_do_not_prevent_the_start) {
    using Make = void (*)(const std::string& path);
    const Make kinds[] = {[](const std::string& path) { ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0); },
                          [](const std::string& path) { fs::create_directory(path); },
                          [](const std::string& path) { fs::create_symlink(path, path); },
                          [](const std::string& path) { fs::create_symlink("/dev/zero", path); }};
    for (const Make make : kinds) {
        fs::remove_all(dir / "state");
        fs::create_directory(dir / "state");
        for (const char* name : of_devices) make(dir / ("state/" + std::string{name}));
        Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config()}, environment()};
        ASSERT_TRUE(daemon.until_answers()) << daemon.output();
        for (const char* name : of_devices)
            EXPECT_TRUE(wait_until([&] {
                return daemon.output().find("state/" + std::string{name} + ": ") != std::string::npos;
            })) << name
                << daemon.output();
    }
}

TEST_F(Files, that_were_left_half_written_are_removed) {
    fs::create_directory(dir / "state");
    const std::string config_with_http = dir.write(
        "anogate.json", R"({"links": ["udp-listen:127.0.0.1:0"], "control": {"http": "127.0.0.1:0", "token_file": ")" +
                            (dir / "state/token") + "\"}}");
    std::vector<std::string> left{dir / "state/token.2147483646", write_atomically("unconfirmed") + ".new",
                                  dir / "state/flexible.json.new", dir / "state/firmware-0xDC.json.new"};
    for (const char* name : of_devices) left.push_back(dir / ("state/" + std::string{name} + ".new"));
    const std::string of_another[] = {dir / "state/flexible-1.json.new", dir / "state/parameters-1.json.new",
                                      dir / "state/unconfirmed-1.new"};
    left.insert(left.end(), std::begin(of_another), std::end(of_another));
    for (const std::string& file : left) std::ofstream{file} << "half";
    for (const std::string& file : of_another) fs::last_write_time(file, fs::file_time_type::clock::now() - 2min);
    const std::string being_written = dir / "state/flexible-2.json.new";
    std::ofstream{being_written} << "half";
    std::ofstream{dir / "state/token.old"} << "a copy of the user's";
    Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config_with_http}, environment()};
    ASSERT_TRUE(daemon.until_says("http://127.0.0.1:")) << daemon.output();
    ASSERT_TRUE(daemon.until_answers());
    for (const std::string& file : left) EXPECT_FALSE(fs::exists(file)) << file;
    EXPECT_TRUE(fs::exists(being_written)) << "another gateway may be writing it";
    EXPECT_TRUE(fs::exists(dir / "state/token.old"));
    EXPECT_TRUE(fs::exists(dir / "state/token"));
}

TEST_F(Files, about_an_upgrade_that_cannot_be_written_to_a_full_disk_are_logged) {
    fs::create_directory(dir / "state");
    const SmallDisk disk{dir / "state", "64k"};
    if (!disk.why_not().empty()) GTEST_SKIP() << disk.why_not();
    std::ofstream{dir / "state/full"} << std::string(64 * 1024, 'x') << std::flush;
    Daemon daemon{ANOGATED, dir / "control.sock", {"sim:fc"}, environment()};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    const std::string image = std::string(512, '\1');
    const std::string flashed = http(dir / "control.sock",
                                     "POST /devices/0xDC/firmware HTTP/1.0\r\nContent-Type: application/octet-stream\r\n"
                                     "Content-Length: " +
                                         std::to_string(image.size()) + "\r\n\r\n" + image);
    EXPECT_NE(flashed.find("202 Accepted"), std::string::npos) << flashed;
    EXPECT_TRUE(daemon.until_says("state/firmware-0xDC")) << daemon.output();
    EXPECT_TRUE(daemon.until_says("No space left on device; after a restart")) << daemon.output();
}

TEST_F(Files, that_cannot_be_written_to_a_full_disk_are_reported) {
    fs::create_directory(dir / "state");
    const SmallDisk disk{dir / "state", "64k"};
    if (!disk.why_not().empty()) GTEST_SKIP() << disk.why_not();
    std::ofstream{dir / "state/full"} << std::string(60 * 1024, 'x') << std::flush;
    for (int i = 0; i < 16; ++i) std::ofstream{dir / ("state/more" + std::to_string(i))} << std::string(4096, 'x') << std::flush;
    const std::string config_with_http = dir.write("anogate.json",
                                                   R"({"gateway": {"id": 200}, "links": ["udp-listen:127.0.0.1:0"], )"
                                                   R"("control": {"http": "127.0.0.1:0", "token_file": ")" +
                                                       (dir / "state/token") + "\"}}");
    Daemon daemon{ANOGATED, dir / "control.sock", {"--config", config_with_http}, environment()};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    EXPECT_TRUE(daemon.until_says("No space left on device")) << daemon.output();
    EXPECT_FALSE(fs::exists(dir / "state/token"));
    const std::string layout = R"([{"id": "0xF1", "fields": [{"name": "a", "type": "u8"}]}])";
    const std::string put = http(dir / "control.sock",
                                 "PUT /flexible HTTP/1.0\r\nContent-Type: application/json\r\nContent-Length: " +
                                     std::to_string(layout.size()) + "\r\n\r\n" + layout);
    EXPECT_NE(put.find("No space left on device"), std::string::npos) << put;
    const std::string save = R"({"action": "save"})";
    const std::string saved = http(dir / "control.sock",
                                   "POST /devices/0xC8/actions HTTP/1.0\r\nContent-Type: application/json\r\nContent-Length: " +
                                       std::to_string(save.size()) + "\r\n\r\n" + save);
    EXPECT_NE(saved.find("the parameters are not saved: "), std::string::npos) << saved;
    EXPECT_NE(saved.find("No space left on device"), std::string::npos) << saved;
    EXPECT_NE(saved.find("\"refused\""), std::string::npos) << "not a silence: " << saved;
}

TEST_F(Files, a_key_that_other_users_can_read_is_not_used_for_encryption) {
    const auto made = anogate::http::make_certificate({{"localhost"}, {"127.0.0.1"}}, dir / "cert.pem", dir / "key.pem");
    ASSERT_TRUE(made) << made.error();
    fs::permissions(dir / "key.pem", fs::perms{0644});
    const std::string with_tls = dir.write(
        "anogate.json", R"({"links": ["udp-listen:127.0.0.1:0"], "control": {"http": "127.0.0.1:0", "tls": {"certificate": ")" +
                            (dir / "cert.pem") + R"(", "key": ")" + (dir / "key.pem") + "\"}}}");
    const std::string words = "key.pem: every user of this computer can read it; run chmod o= ";
    Daemon daemon{ANOGATED, dir / "control.sock", {"--config", with_tls}, environment()};
    ASSERT_TRUE(daemon.until_answers()) << daemon.output();
    EXPECT_TRUE(daemon.until_says("control.http stays off: control.tls: ")) << daemon.output();
    EXPECT_NE(daemon.output().find(words), std::string::npos) << daemon.output();
    Process check{ANOGATED, {"--check", "--config", with_tls}, environment()};
    check.wait(soon);
    EXPECT_NE(check.output().find(words), std::string::npos) << check.output();
    fs::permissions(dir / "key.pem", fs::perms{0640});
    const auto reload = [&] { return http(dir / "control.sock", "POST /reload HTTP/1.0\r\n\r\n"); };
    EXPECT_EQ(reload().find("http_error"), std::string::npos);
    EXPECT_EQ(daemon.status().at("http").at("state"), "up") << daemon.output();
    fs::permissions(dir / "key.pem", fs::perms{0644});
    EXPECT_NE(reload().find(words), std::string::npos) << "it is in use no more";
    EXPECT_EQ(daemon.status().at("http").at("state"), "shut");
    fs::permissions(dir / "key.pem", fs::perms{0640});
    Process checked{ANOGATED, {"--check", "--config", with_tls}, environment()};
    checked.wait(soon);
    EXPECT_EQ(checked.output().find("stays off"), std::string::npos) << checked.output();
}

}    // namespace
}    // namespace attack_files_tests
