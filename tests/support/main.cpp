// The tests of the whole gateway: its log says nothing unless a test wants to read it.
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

int main(int argc, char** argv) {
    testing::InitGoogleTest(&argc, argv);
    spdlog::set_level(spdlog::level::off);
    return RUN_ALL_TESTS();
}
