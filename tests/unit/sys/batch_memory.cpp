#include <sys/batch_memory.hpp>

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace batch_memory_tests {

using anogate::BatchMemory;

namespace {

constexpr std::size_t usual = 16 * 1024;

TEST(BatchMemory, of_an_unused_batch_is_reused_for_the_next) {
    BatchMemory memory;
    auto first = memory.acquire(usual);
    EXPECT_EQ(first->size(), usual);
    const char* const place = first->data();
    first->resize(100);
    std::shared_ptr<const std::string> other = first;
    first.reset();
    auto second = memory.acquire(usual);
    EXPECT_NE(second->data(), place) << "somebody has it still";
    other.reset();
    const auto third = memory.acquire(usual);
    EXPECT_EQ(third->data(), place);
    EXPECT_EQ(third->size(), usual);
    EXPECT_EQ(memory.bytes_kept(), 0u);
}

TEST(BatchMemory, a_small_batch_does_not_use_the_memory_of_a_large_one) {
    BatchMemory memory;
    memory.acquire(usual).reset();
    EXPECT_LT(memory.acquire(100)->capacity(), 1000u);
    EXPECT_LT(memory.acquire(0)->capacity(), 1000u);
}

TEST(BatchMemory, is_kept_up_to_a_bound) {
    BatchMemory memory;
    std::vector<std::shared_ptr<std::string>> batches;
    for (std::size_t size = 0; size < 2 * BatchMemory::max_kept; size += usual) batches.push_back(memory.acquire(usual));
    batches.clear();
    EXPECT_LE(memory.bytes_kept(), BatchMemory::max_kept);
    EXPECT_GT(memory.bytes_kept(), BatchMemory::max_kept - 2 * usual);
    auto one = memory.acquire(usual);
    memory.clear();
    EXPECT_EQ(memory.bytes_kept(), 0u);
    one.reset();
    EXPECT_EQ(memory.bytes_kept(), 0u) << "what was in use is freed as well";
}

}    // namespace
}    // namespace batch_memory_tests
