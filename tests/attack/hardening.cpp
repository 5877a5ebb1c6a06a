// The hardening of a release's programs against memory errors.
#include <support/process.hpp>

#include <gtest/gtest.h>

namespace hardening_tests {
namespace {

std::string read_by_readelf(const std::string& program) {
    support::Shell shell{"readelf -W --file-header --dynamic --program-headers --dyn-syms " + program};
    shell.wait();
    return shell.output();
}

TEST(Hardening, is_in_every_program_of_a_release) {
    if (!ANOGATE_HARDENED) GTEST_SKIP() << "with sanitizers or without optimisation the programs are built otherwise";
    for (const std::string program : {ANOGATED, ANOCTL}) {
        const std::string facts = read_by_readelf(program);
        ASSERT_NE(facts, "") << "is readelf here?";
        const auto has = [&](const std::string& words) { return facts.find(words) != std::string::npos; };
        EXPECT_TRUE(has("DYN (Position-Independent Executable file)") || has("DYN (Shared object file)")) << program;
        EXPECT_TRUE(has("GNU_RELRO")) << program;
        EXPECT_TRUE(has("BIND_NOW") || has("Flags: NOW")) << program;
        EXPECT_TRUE(has("__stack_chk_fail")) << program;
        EXPECT_TRUE(has("_chk@")) << program << ": _FORTIFY_SOURCE";
        EXPECT_FALSE(has("TEXTREL")) << program;
    }
}

}    // namespace
}    // namespace hardening_tests
