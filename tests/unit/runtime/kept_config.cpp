#include <runtime/kept_config.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace anogate::kept_config_tests {
namespace {

const KeptConfig sample{{{"/etc/a.json", "{} // \xFF\xFE"}, {"/etc/conf.d/b.json", std::string{"a\0b", 3}}},
                        {{"/etc/a.json", "{\"links\": []}"}}};

/// The configuration stored at `path`; `fault`: why it can't be read.
struct Kept {
    explicit Kept(const std::string& path) : config{kept_config(path, fault)} {}
    std::string fault;
    std::optional<KeptConfig> config;
};

TEST(KeptConfig, is_read_as_it_was_written_with_any_bytes) {
    const support::TempDir dir;
    const std::string path = dir / "deeper/state/kept";
    EXPECT_EQ(keep_config(path, sample), "");
    const auto kept = Kept{path}.config;
    ASSERT_TRUE(kept);
    EXPECT_EQ(kept->unconfirmed, sample.unconfirmed);
    EXPECT_EQ(kept->confirmed, sample.confirmed);
    EXPECT_EQ(std::filesystem::status(path).permissions() & std::filesystem::perms::mask, std::filesystem::perms{0600});
    EXPECT_EQ(keep_config(path, {{}, {}}), "") << "in its place";
    EXPECT_TRUE(Kept{path}.config->confirmed.empty());
    EXPECT_EQ(forget_config(path), "");
    EXPECT_FALSE(Kept{path}.config);
    EXPECT_EQ(Kept{path}.fault, "");
    EXPECT_EQ(forget_config(path), "") << "there is none any more";
}

TEST(KeptConfig, is_compared_by_its_texts) {
    EXPECT_TRUE(have_same_texts({{"a.json", "1"}, {"b", "2"}}, {{"/etc/a.json", "1"}, {"/etc/b", "2"}}));
    EXPECT_FALSE(have_same_texts({{"a.json", "1"}, {"b", "2"}}, {{"a.json", "1"}}));
    EXPECT_FALSE(have_same_texts({{"a.json", "1"}}, {{"a.json", "2"}}));
}

TEST(KeptConfig, that_is_damaged_is_not_used) {
    const support::TempDir dir;
    const std::string path = dir / "kept";
    for (const char* bytes : {"", "nonsense", "{}", "\xA1\x61\x61\x01"}) {
        dir.write("kept", bytes);
        EXPECT_FALSE(Kept{path}.config) << bytes;
        EXPECT_EQ(Kept{path}.fault, path + ": damaged; remove it") << bytes;
    }
    for (const char nested : {'\x81', '\x9F', '\xA1', '\xBF', '\x5F', '\x7F', '\xC1'}) {    // nested arrays, maps, strings, tags
        dir.write("kept", std::string(10'000'000, nested));
        EXPECT_FALSE(Kept{path}.config);
        EXPECT_EQ(Kept{path}.fault, path + ": damaged; remove it");
    }
    for (const std::string& bytes : {"\xA1\x7F" + std::string(300'000, '\x7F'), "\xA2\x6B" + std::string{"unconf"},
                                     std::string{"\x9B\x7F\xFF\xFF\xFF\xFF\xFF\xFF\xFF"}}) {
        dir.write("kept", bytes);
        EXPECT_FALSE(Kept{path}.config);
        EXPECT_EQ(Kept{path}.fault, path + ": damaged; remove it");
    }
    ASSERT_EQ(keep_config(path, sample), "");
    std::filesystem::resize_file(path, std::filesystem::file_size(path) - 3);
    EXPECT_FALSE(Kept{path}.config);
    EXPECT_NE(Kept{path}.fault, "");
}

TEST(KeptConfig, reports_why_it_cannot_be_stored) {
    const support::TempDir dir;
    dir.write("file", "");
    EXPECT_NE(keep_config(dir / "file/kept", sample), "");
    EXPECT_NE(keep_config("", sample), "");
    EXPECT_NE(keep_config("/proc/nowhere/kept", sample), "");
}

TEST(KeptConfig, is_stored_per_configuration_file_in_the_folder_of_the_unit) {
    const support::TempDir dir;
    ::setenv("STATE_DIRECTORY", (dir / "a:" + "/b").c_str(), 1);
    const std::string one = kept_config_path("/etc/anogate/anogate.json");
    EXPECT_TRUE(one.starts_with(dir / "a/unconfirmed-")) << one;
    EXPECT_EQ(kept_config_path("/etc/anogate/../anogate/anogate.json"), one);
    EXPECT_NE(kept_config_path("/etc/anogate/other.json"), one);
    EXPECT_EQ(kept_config_path(""), "");
    ::unsetenv("STATE_DIRECTORY");
    ::setenv("XDG_STATE_HOME", "/state", 1);
    EXPECT_TRUE(kept_config_path("/etc/a.json").starts_with("/state/anogate/"));
    ::unsetenv("XDG_STATE_HOME");
}

}    // namespace
}    // namespace anogate::kept_config_tests
