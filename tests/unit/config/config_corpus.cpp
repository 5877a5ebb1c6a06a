// The seeds of the fuzz target for configurations, and many small changes of them, without a fuzzer.
#include <gtest/gtest.h>
#include <support/files.hpp>
#include <support/random.hpp>

#include <fuzz/config.cpp>

namespace config_corpus_tests {
namespace {

void replay(const std::string& text) { LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()); }

/// One byte changed, removed or inserted, or a piece moved.
std::string changed(std::string text, support::Random& random) {
    constexpr std::string_view bytes = "{}[],:\"'0919-xX/*\\\n ue\xFF\x80\x01%+=";
    for (unsigned n = 1 + random.below(4u); n > 0 && !text.empty(); --n) {
        const std::size_t at = random.below(text.size());
        switch (random.below(4)) {
        case 0: text[at] = bytes[random.below(bytes.size())]; break;
        case 1: text.erase(at, 1 + random.below(8u)); break;
        case 2: text.insert(at, 1, bytes[random.below(bytes.size())]); break;
        default: text.insert(random.below(text.size()), text.substr(at, random.below(40u))); break;
        }
    }
    return text;
}

TEST(ConfigCorpus, satisfies_the_invariants) {
    std::size_t seeds = 0;
    for (const auto& entry : std::filesystem::directory_iterator{support::source_file("tests/fuzz/corpus/config")}) {
        const std::string text = support::file_text(entry.path());
        replay(text);
        support::Random random{++seeds};
        for (int i = 0; i < 500; ++i) replay(changed(text, random));
    }
    EXPECT_GE(seeds, 8u);
}

}    // namespace
}    // namespace config_corpus_tests
