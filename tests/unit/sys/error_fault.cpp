#include <sys/error_fault.hpp>
#include <sys/errors.hpp>

#include <gtest/gtest.h>

namespace error_fault_tests {
namespace {

TEST(ErrorFault, has_the_text_of_the_system_and_an_id_for_usual_errors) {
    for (int error = 1; error < 134; ++error)
        EXPECT_EQ(anogate::error_fault("/rec", error).text(), anogate::error_text("/rec", error));
    EXPECT_EQ(anogate::error_fault("/rec", ENOSPC).id(), "disk_full");
    EXPECT_EQ(anogate::error_fault("/rec", EMLINK).id(), "system_error");
}

}    // namespace
}    // namespace error_fault_tests
