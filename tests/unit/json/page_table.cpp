// The page is tested with a copy of the message table; it has to be that of the gateway. ANOGATE_UPDATE=1 in the environment writes it.
#include <ano_json/describe.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

namespace page_table_tests {
namespace {

std::string table() {
    std::string text = "[";
    for (const auto& row : ano::describe_all({})) text += (text.size() > 1 ? ",\n" : "\n") + row.dump();
    return text + "\n]\n";
}

TEST(PageTable, is_the_one_that_its_tests_read) {
    const std::string path = ANOGATE_SOURCE_DIR "/src/web/test/messages.json";
    if (std::getenv("ANOGATE_UPDATE")) std::ofstream{path} << table();
    std::ifstream in{path};
    const std::string there{std::istreambuf_iterator<char>{in}, {}};
    EXPECT_EQ(there, table()) << path << ": ANOGATE_UPDATE=1 writes it anew";
}

}    // namespace
}    // namespace page_table_tests
