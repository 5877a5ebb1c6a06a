// The file of a map, as browsers read it: by ranges; and other files under its path.
#include <support/http.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <filesystem>
#include <string>

namespace map_tests {
namespace {

using namespace support;
using nlohmann::json;
namespace fs = std::filesystem;

class Map : public testing::Test {
protected:
    void SetUp() override { ASSERT_TRUE(daemon.until_answers()); }
    /// Head and body of the answer to a request for the map.
    std::string ask(const std::string& headers, const std::string& method = "GET") const {
        return http(socket, method + " /map.pmtiles HTTP/1.1\r\nHost: x\r\nConnection: close\r\n" + headers + "\r\n");
    }
    static bool has(const std::string& answer, const std::string& words) { return answer.find(words) != answer.npos; }

    TempDir dir;
    std::string socket = dir / "control.sock";
    std::string file = dir / "map.pmtiles";
    std::string config = dir.write("anogate.json", R"({"links": ["udp-listen:127.0.0.1:0,name=ground"],
        "control": {"map": {"file": ")" + file + R"(", "datum": "gcj02"}}})");
    Daemon daemon{ANOGATED, socket, {"--config", config}};
};

TEST_F(Map, is_served_in_ranges) {
    (void)dir.write("map.pmtiles", "0123456789");
    const std::string part = ask("Range: bytes=2-4\r\n");
    EXPECT_TRUE(part.starts_with("HTTP/1.1 206 Partial Content\r\n")) << part;
    EXPECT_TRUE(has(part, "\r\nContent-Range: bytes 2-4/10\r\n")) << part;
    EXPECT_TRUE(has(part, "\r\nContent-Type: application/vnd.pmtiles\r\n")) << part;
    EXPECT_TRUE(has(part, "\r\nETag: \"")) << "a browser sees that another file was put in its place";
    EXPECT_EQ(body_of(part), "234");
    EXPECT_EQ(body_of(ask("")), "0123456789");
    const std::string head = ask("", "HEAD");
    EXPECT_TRUE(has(head, "\r\nContent-Length: 10\r\n")) << head;
    EXPECT_EQ(body_of(head), "");
    const std::string beyond = ask("Range: bytes=10-\r\n");
    EXPECT_TRUE(beyond.starts_with("HTTP/1.1 416 ")) << beyond;
    EXPECT_TRUE(has(beyond, "\r\nContent-Range: bytes */10\r\n")) << beyond;
}

TEST_F(Map, of_many_blocks_is_served_completely) {
    std::string content;
    for (std::uint32_t i = 0; content.size() < 3'000'000; ++i) content += std::to_string(i * 2654435761U);
    (void)dir.write("map.pmtiles", content);
    EXPECT_EQ(body_of(ask("")), content);
    EXPECT_EQ(body_of(ask("Range: bytes=100000-1500000\r\n")), content.substr(100'000, 1'400'001));
}

TEST_F(Map, is_reported_as_invalid_if_it_is_missing_or_not_a_regular_file) {
    const auto said = [&] { return json::parse(body_of(ask("Range: bytes=0-9\r\n"))).at("error").get<std::string>(); };
    EXPECT_EQ(said(), "control.map: " + file + ": No such file or directory");
    ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
    EXPECT_EQ(said(), "control.map: " + file + ": is not a regular file") << "and nobody waits for one who writes";
    fs::remove(file);
    fs::create_directory(file);
    EXPECT_EQ(said(), "control.map: " + file + ": is not a regular file");
    fs::remove(file);
    fs::create_symlink("/dev/zero", file);
    EXPECT_EQ(said(), "control.map: " + file + ": is not a regular file");
    fs::remove(file);
    fs::create_symlink(dir.write("other", "0123456789"), file);
    EXPECT_EQ(body_of(ask("Range: bytes=0-1\r\n")), "01") << "it may lie on another disk";
}

TEST_F(Map, is_shown_in_the_status) { EXPECT_EQ(daemon.status().at("map"), (json{{"file", file}, {"datum", "gcj02"}})); }

TEST_F(Map, that_is_missing_causes_a_warning_before_the_start) {
    const auto checked = [&] {
        Process check{ANOGATED, {"--check", "--config", config}};
        EXPECT_EQ(check.wait(), 0);
        return check.output();
    };
    EXPECT_NE(checked().find("warning: 'map/file' '" + file + "': not found: the page shows a grid"), std::string::npos)
        << checked();
    (void)dir.write("map.pmtiles", "0123456789");
    EXPECT_EQ(checked().find("map"), std::string::npos) << checked();
}

}    // namespace
}    // namespace map_tests
