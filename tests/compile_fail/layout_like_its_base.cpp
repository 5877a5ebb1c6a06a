// error: a_layout_needs_a_length_or_a_mode_of_its_own
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Variant variant{"other"};
#else
constexpr Variant variant{"other", 2};
#endif
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u8}}, exactly(1)}, {0x01, "one", "", report, {{"b", u16}}, variant}};
constexpr MessageIndex checked = index_messages(rows);
}    // namespace ano::table
