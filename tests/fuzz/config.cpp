// Any bytes as a configuration: no crash, every error is one line, and an accepted configuration is unchanged after printing and
// reading.
#include <config/config.hpp>
#include <link/kinds.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace {

void must(bool law) {
    if (!law) std::abort();
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace anogate;
    const std::string text(reinterpret_cast<const char*>(data), size);
    const Draft draft = parse_config(text, link_kinds(), "file");
    if (!draft.errors.empty()) {
        const std::string shown = lines(draft.errors);
        must(static_cast<std::size_t>(std::count(shown.begin(), shown.end(), '\n')) == draft.errors.size());
        return 0;
    }
    const std::string printed = print_config(draft.settings);
    const Draft again = parse_config(printed, link_kinds());
    must(again.errors.empty());
    must(again.settings == draft.settings);
    must(print_config(again.settings) == printed);
    return 0;
}
