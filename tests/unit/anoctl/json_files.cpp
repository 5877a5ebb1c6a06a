// JSON files read by anoctl: a duplicate key, deep nesting and trailing content are rejected, whatever the source.
#include <support/anoctl.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace json_files_tests {
namespace {

using namespace support;

struct BadJson {
    std::string what;
    std::function<std::string(const std::string& inner)> around;    // `inner`: members of an object
    std::string expected_error;
};

const std::vector<BadJson> all_bad{
    {"a key twice", [](const std::string& inner) { return "{\"x\": 1, \"x\": 2" + inner + "}"; }, "'x' is given twice"},
    {"too deep", [](const std::string& inner) { return "{\"x\": " + std::string(40, '[') + std::string(40, ']') + inner + "}"; },
     "nested deeper than 32 levels"},
    {"more behind it", [](const std::string& inner) { return "{\"x\": 1" + inner + "} {}"; }, "not valid JSON: "},
    {"a byte 0 behind it",
     [](const std::string& inner) {
         return "{\"x\": 1" + inner + "}" + std::string{'\0', 'x'};
     },
     "contains a NUL byte"},
};

TEST(JsonFiles, with_malformed_json_are_rejected_before_anything_is_done) {
    const TempDir dir;
    const std::string nowhere = dir / "no.sock";
    for (const BadJson& bad : all_bad) {
        SCOPED_TRACE(bad.what);
        const std::string plain = dir.write("plain.json", bad.around(""));
        const std::string config = dir.write("config.json", bad.around(R"(, "flexible": [])"));
        for (const std::vector<std::string>& words :
             std::vector<std::vector<std::string>>{{"param", "import", plain, "--device", "0xDC", "--control", nowhere, "--yes"},
                                                   {"param", "diff", plain, "--device", "0xDC", "--control", nowhere},
                                                   {"waypoint", "put", plain, "--device", "0xDC", "--control", nowhere, "--yes"},
                                                   {"flexible", "set", config, "--control", nowhere},
                                                   {"decode", "AB", "--config", config}}) {
            const AnoctlResult ran = support::anoctl(words);
            EXPECT_EQ(ran.exit, 2) << words[0] << ' ' << words[1] << ": " << ran.err;
            EXPECT_NE(ran.err.find(bad.expected_error), std::string::npos) << words[0] << ' ' << words[1] << ": " << ran.err;
        }
        const AnoctlResult lines = support::anoctl({"encode", "-"}, bad.around(R"(, "id": 3)") + "\n");
        EXPECT_EQ(lines.exit, 2) << lines.err;
        EXPECT_NE(lines.err.find(bad.expected_error), std::string::npos) << lines.err;
    }
}

}    // namespace
}    // namespace json_files_tests
