// The main function of the tests of the whole gateway. The log is off unless a test reads it. anoctl uses a temporary cache
// folder, so that the user's is not changed.
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
