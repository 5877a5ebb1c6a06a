#include "faults.hpp"

#include <config/read_files.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <filesystem>

namespace anogate::read_files_tests {
namespace {

class ReadFiles : public testing::Test {
protected:
    ReadFiles() { std::filesystem::create_directory(folder / "conf.d"); }
    void write(const std::string& name, const std::string& text) { folder.write(name, text); }
    Draft read() {
        Draft draft{link_kinds()};
        read_config(read_config_files(folder / "a.json", draft.errors), draft);
        validate(draft);
        return draft;
    }
    /// Without the folder's name.
    std::string faults() {
        std::string all = lines(read().errors);
        const std::string place = folder.path().string() + "/";
        for (std::size_t at; (at = all.find(place)) != std::string::npos;) all.erase(at, place.size());
        return all;
    }
    support::TempDir folder;
};

TEST_F(ReadFiles, lists_of_conf_d_are_appended_in_order_of_file_names) {
    write("a.json", R"({"gateway": {"id": 9}, "links": ["sim:fc"], "routes": [{"address": 3, "link": "fc"}]})");
    write(
        "conf.d/20-b.json",
        R"({"links": ["sim:fc,name=b"], "routes": [{"address": 4, "link": "b"}], "flexible": [{"id": "0xF1", "fields": [{"name": "x", "type": "u8"}]}]})");
    write(
        "conf.d/10-c.json",
        R"({"$schema": "x", "gateway": {"name": "boat"}, "links": ["sim:fc,name=c"], "alias": [{"link": "c", "device": 5, "as": 31}]})");
    write("conf.d/30-d.json~", "not read");
    write("conf.d/.40-e.json", "not read");
    const Draft draft = read();
    EXPECT_EQ(lines(draft.errors), "");
    ASSERT_EQ(draft.settings.links.size(), 3u);
    EXPECT_EQ(draft.settings.links[1].name, "c");
    EXPECT_EQ(draft.settings.links[2].name, "b");
    EXPECT_EQ(draft.settings.routes.size(), 2u);
    EXPECT_EQ(draft.settings.aliases.size(), 1u);
    EXPECT_EQ(draft.settings.flexible.size(), 1u);
    EXPECT_EQ(draft.settings.gateway.id, 9);
    EXPECT_EQ(draft.settings.gateway.name, "boat");
}

TEST_F(ReadFiles, an_error_for_a_key_in_two_files_names_both_files) {
    write("a.json", R"({"gateway": {"id": 9}, "log": {"level": "info"}, "links": ["sim:fc"], "tunnel": {"links": ["fc"]}})");
    write("conf.d/10.json",
          R"({"gateway": {"id": 8}, "log": {"level": "info"}, "tunnel": {"port": 5}, "control": {"socket": "none"}})");
    write("conf.d/20.json", R"({"control": {"socket": "none"}})");
    EXPECT_EQ(faults(),
              "anogated: conf.d/10.json: /gateway/id: 'id' is also set in a.json\n"
              "anogated: conf.d/10.json: /log/level: 'level' is also set in a.json\n"
              "anogated: conf.d/10.json: /tunnel: 'tunnel' is also set in a.json\n"
              "anogated: conf.d/20.json: /control/socket: 'socket' is also set in conf.d/10.json\n");
}

TEST_F(ReadFiles, a_fault_names_its_file) {
    write("a.json", R"({"links": ["sim:fc,name=fc"]})");
    write("conf.d/10.json", R"({"links": ["sim:fc,name=fc"], "routes": [{"address": 3, "link": "gone"}]})");
    write("conf.d/20.json", R"({"links": [)");
    const std::string all = faults();
    EXPECT_NE(all.find("anogated: conf.d/20.json: line 1"), std::string::npos) << all;
    write("conf.d/20.json", R"({"flexible": [{"id": "0xF1", "fields": [{"name": "x", "type": "u8"}]}]})");
    write("conf.d/30.json", R"({"flexible": [{"id": "0xF1", "fields": [{"name": "y", "type": "u8"}]}]})");
    const std::string now = faults();
    EXPECT_NE(now.find("conf.d/10.json: /links/0: LINK 'sim:fc,name=fc': 'name' 'fc' is already the name of a.json: /links/0"),
              std::string::npos)
        << now;
    EXPECT_NE(now.find("conf.d/10.json: /routes/0/link: there is no link 'gone'"), std::string::npos) << now;
    EXPECT_NE(now.find("conf.d/30.json: /flexible/0"), std::string::npos) << now;
}

TEST_F(ReadFiles, reports_unreadable_files) {
    EXPECT_NE(faults().find("a.json: No such file or directory"), std::string::npos);
    write("a.json", "{}");
    std::filesystem::create_directory(folder / "conf.d/10.json");
    EXPECT_NE(faults().find("conf.d/10.json: Is a directory"), std::string::npos) << faults();
    std::filesystem::remove(folder / "conf.d/10.json");
    ASSERT_EQ(::mkfifo((folder / "conf.d/pipe").c_str(), 0600), 0);
    EXPECT_NE(faults().find("conf.d/pipe: is not a regular file but a pipe, socket or device"), std::string::npos) << faults();
    std::filesystem::remove_all(folder / "conf.d");
    EXPECT_EQ(faults(), "") << "there need not be any";
    write("conf.d", "a file");
    EXPECT_NE(faults().find("conf.d: Not a directory"), std::string::npos) << faults();
    std::filesystem::remove(folder / "conf.d");
    std::filesystem::create_symlink("nowhere", folder / "conf.d");
    EXPECT_NE(faults().find("conf.d: No such file or directory"), std::string::npos) << faults();
}

}    // namespace
}    // namespace anogate::read_files_tests
