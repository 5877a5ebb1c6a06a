// Any bytes as a pcapng file: what is read does not depend on how it was cut into pieces, and what was read, recorded, is read as the same
// and recorded again is the same bytes.
#include <support/recorded.hpp>

#include <cstdint>
#include <cstdlib>
#include <string>

namespace {

void must_hold(bool law) {
    if (!law) std::abort();
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size > 65536) return 0;
    const std::string_view file{reinterpret_cast<const char*>(data), size};
    const auto read = support::read_pcapng(file);
    const auto in_pieces = support::read_pcapng(file, 13);
    must_hold(read.items == in_pieces.items && read.fault == in_pieces.fault && read.position == in_pieces.position);
    must_hold(read.position <= size);

    const std::string recorded = support::write_pcapng(read.items, read.head);
    const auto again = support::read_pcapng(recorded);
    must_hold(again.fault.empty() && again.has_end && again.unfinished == 0);
    must_hold(support::write_pcapng(again.items, again.head) == recorded);
    return 0;
}
