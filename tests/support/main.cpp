// The tests of the whole gateway: its log says nothing unless a test wants to read it, and what anoctl keeps for later runs is not kept for
// those of the user.
#include "temp_dir.hpp"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <cstdlib>

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    const support::TempDir cache;
    ::setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
    spdlog::set_level(spdlog::level::off);
    return RUN_ALL_TESTS();
}
