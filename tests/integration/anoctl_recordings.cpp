// anoctl recordings and status, for recordings that a gateway makes itself.
#include <support/recording_gateway.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace anoctl_recordings_tests {
namespace {

using namespace support;
using nlohmann::json;

class AnoctlRecordings : public RecordingGateway {
protected:
    struct Told {
        int exit = 0;
        std::string text;
    };
    Told anoctl(std::vector<std::string> words) const {
        words.insert(words.end(), {"--control", socket});
        Process process{ANOCTL, std::move(words)};
        Told told;
        told.exit = process.wait();
        told.text = process.output();
        return told;
    }
    static void expect(const Told& told, int exit, const std::string& words) {
        EXPECT_EQ(told.exit, exit) << told.text;
        EXPECT_NE(told.text.find(words), std::string::npos) << told.text;
    }
};

TEST_F(AnoctlRecordings, of_several_files_show_the_totals_and_the_current_file) {
    start(R"(, "record": {"start": false, "rotate": {"size": "20kB"}})");
    expect(anoctl({"recordings", "start", "one"}), 0, "one.pcapng started");
    send_numbered(10);
    expect(anoctl({"recordings", "end", "one"}), 0, "one.pcapng stopped, 10 frames");

    begin({{"name", "flight"}});
    const auto files = [&] { return get().at("running").at(0).at("files").get<int>(); };
    for (int round = 0; round < 50 && files() < 2; ++round) send_numbered(150);
    ASSERT_TRUE(until([&](const json& all) { return all.at("running").at(0).at("frames") == sent_ - 10; })) << get();
    const std::string sum = std::to_string(sent_ - 10) + " frames in " + std::to_string(files()) + " files";
    const json one = get().at("running").at(0);
    EXPECT_LT(one.at("file_frames"), one.at("frames"));
    EXPECT_LT(one.at("file_seconds"), one.at("seconds"));
    const std::string file = one.at("file");
    expect(anoctl({"status"}), 0, "recording: flight: " + sum);
    const Told list = anoctl({"recordings"});
    expect(list, 0, "flight: " + sum);
    expect(list, 0, file);
    EXPECT_EQ(list.text.find("failing"), std::string::npos) << list.text;
    expect(anoctl({"recordings", "end", "flight"}), 0, "flight stopped, " + sum);
}

TEST_F(AnoctlRecordings, are_fetched_and_deleted_by_name_without_extension_if_it_is_unambiguous) {
    start(R"(, "record": {"start": false, "rotate": {"size": "20kB"}})");
    begin({{"name", "one"}, {"format", "mcap"}});
    send_numbered(10);
    end("one");
    begin({{"name", "flight"}});
    for (int round = 0; round < 50 && get().at("running").at(0).at("files") < 2; ++round) send_numbered(150);
    end("flight");
    expect(anoctl({"recordings", "get", "one", dir / "copy.mcap"}), 0, "copy.mcap: ");
    EXPECT_EQ(file_text(dir / "copy.mcap"), content("one.mcap"));
    expect(anoctl({"recordings", "get", "one.mcap", dir.path().string()}), 0, dir / "one.mcap: ");
    EXPECT_EQ(file_text(dir / "one.mcap"), content("one.mcap"));
    for (const char* other : {"x.pcapng", "x.csv"}) {
        expect(anoctl({"recordings", "get", "one", dir / other}), 2, "get copies one.mcap unchanged; to get ");
        EXPECT_FALSE(std::filesystem::exists(dir / other));
    }
    expect(anoctl({"recordings", "delete", "flight"}), 2, " files; give one of: flight-");
    EXPECT_NE(file_called("flight.pcapng"), json());
    expect(anoctl({"recordings", "delete", "flight-2"}), 0, "flight-2.pcapng deleted");
    expect(anoctl({"recordings", "delete", "one"}), 0, "one.mcap deleted");
    expect(anoctl({"recordings", "delete", "flihgt.pcapng"}), 1, "did you mean 'flight.pcapng'?");
}

// Gateways of one user share the folder of recordings.
TEST_F(AnoctlRecordings, of_another_gateway_are_listed_while_they_run) {
    start(R"(, "record": {"start": false})");
    begin({{"name", "own"}});
    dir.write("other.json", R"({"links": [], "record": {"start": false, "folder": ")" + folder + "\"}}");
    const std::string others = dir / "other.sock";
    Daemon other{ANOGATED, others, {"--config", dir / "other.json"}};
    ASSERT_TRUE(other.until_answers()) << other.output();
    ASSERT_EQ(asked(others, "POST", "/recordings", R"({"name": "other"})").status, 200u);
    ASSERT_TRUE(wait_until([&] {
        const json file = file_called("other.pcapng");
        return file.is_object() && file.at("state") == "recording";
    })) << get();
    const std::string list = anoctl({"recordings"}).text;
    EXPECT_NE(list.find("other.pcapng  recording"), std::string::npos) << list;
    EXPECT_NE(list.find("by another gateway"), std::string::npos) << list;
    EXPECT_EQ(list.find("own.pcapng"), list.rfind("own.pcapng")) << "once: " << list;
}

TEST_F(AnoctlRecordings, cannot_have_the_extension_of_another_format) {
    start(R"(, "record": {"start": false, "keep_last": "60s"})");
    for (const char* action : {"start", "save"})
        expect(anoctl({"recordings", action, "flight.csv"}), 2, "flight.csv: recordings are pcapng");
    EXPECT_TRUE(get().at("running").empty());
    expect(anoctl({"recordings", "start", "2026.11", "--format", "mcap"}), 0, "2026.11.mcap started");
}

}    // namespace
}    // namespace anoctl_recordings_tests
