// The parser of V7 against the reference. The input is the bytes of the line; its first byte states how many of them come at once.
#include <support/both_v7_parsers.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size < 2) return 0;
    support::BothV7Parsers both;
    both.put({data + 1, std::min<std::size_t>(size - 1, 20000)}, 1 + std::size_t{data[0]} * data[0]);
    both.finish();
    if (both.difference().empty()) return 0;
    std::fprintf(stderr, "%s\n", both.difference().c_str());
    std::abort();
}
