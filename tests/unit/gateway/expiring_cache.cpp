#include <gateway/expiring_cache.hpp>

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <memory>

namespace expiring_cache_tests {

using namespace anogate;
using namespace std::chrono_literals;
using ano::TimePoint;

namespace {

constexpr TimePoint start{1h};

/// Resident memory of this process, in bytes.
long resident() {
    long mapped = 0, pages = 0;
    std::ifstream{"/proc/self/statm"} >> mapped >> pages;
    return pages * ::sysconf(_SC_PAGESIZE);
}

TEST(ExpiringCache, remembers_within_its_window) {
    ExpiringCache<int> cache{2s, 64};
    EXPECT_EQ(cache.find(0, start), nullptr);
    cache.put(0, 7, start);
    ASSERT_NE(cache.find(0, start + 2s - 1ns), nullptr);
    EXPECT_EQ(*cache.find(0, start), 7);
    EXPECT_EQ(cache.find(0, start + 2s), nullptr);
    cache.put(0, 8, start + 1s);
    EXPECT_EQ(*cache.find(0, start + 2s), 8);
}

TEST(ExpiringCache, forgets_the_oldest_when_full) {
    ExpiringCache<int> cache{1h, 8};
    for (int n = 0; n < 1000; ++n) cache.put(static_cast<std::uint64_t>(n), n, start + n * 1ms);
    int known = 0;
    for (int n = 0; n < 1000; ++n) known += cache.find(static_cast<std::uint64_t>(n), start + 1s) != nullptr;
    EXPECT_EQ(known, 8);
    EXPECT_NE(cache.find(999, start + 1s), nullptr);
}

/// Whether the kernel provides memory for pages that are only read, as some kernels of virtual machines do.
bool reading_uses_memory() {
    constexpr std::size_t size = std::size_t{33} << 20;
    const long before = resident();
    const std::unique_ptr<char, decltype(&std::free)> pages{static_cast<char*>(std::calloc(size, 1)), &std::free};
    char all = 0;
    for (std::size_t i = 0; i < size; i += 4096) all = static_cast<char>(all | const_cast<const volatile char*>(pages.get())[i]);
    return resident() - before > 16'000'000 || all != 0;
}

TEST(ExpiringCache, uses_no_memory_for_entries_that_were_never_stored) {
    if (reading_uses_memory()) GTEST_SKIP() << "this kernel provides memory for pages that are only read";
    const long before = resident();
    ExpiringCache<std::array<std::uint64_t, 6>> cache{1h, 1 << 19};    // 32 MiB
    cache.put(1, {1}, start);
    for (std::uint64_t n = 0; n < 100'000; ++n) cache.find(n, start);
    cache.keep_if([](std::uint64_t, const auto&) { return true; });
    EXPECT_LT(resident() - before, 16'000'000);    // sanitizers need an eighth of it
    EXPECT_EQ((*cache.find(1, start))[0], 1u);
}

TEST(ExpiringCache, returns_the_time_at_which_an_entry_was_stored) {
    ExpiringCache<int> cache{2s, 64};
    for (const TimePoint at : {TimePoint{}, TimePoint{} - 1s, start}) {    // a clock may begin at any time
        cache.put(5, 1, at);
        ASSERT_NE(cache.find(5, at), nullptr);
        EXPECT_EQ(cache.stored_at(5), at);
        cache.for_each([at](std::uint64_t key, TimePoint told, int) { EXPECT_TRUE(key == 5 && told == at); });
    }
}

TEST(ExpiringCache, keep_if_removes_all_other_entries) {
    ExpiringCache<int> cache{2s, 64};
    for (int n = 0; n < 4; ++n) cache.put(static_cast<std::uint64_t>(n), n, start);
    cache.keep_if([](std::uint64_t key, int& value) {
        value += 10;
        return key % 2 == 0;
    });
    EXPECT_EQ(*cache.find(0, start), 10);
    EXPECT_EQ(cache.find(1, start), nullptr);
    EXPECT_EQ(*cache.find(2, start), 12);
    int left = 0;
    cache.keep_if([&](std::uint64_t, int) { return ++left, true; });
    EXPECT_EQ(left, 2) << "what was never put in is not shown";
}

}    // namespace
}    // namespace expiring_cache_tests
