// error: a_layout_is_no_longer_than_its_length
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Variant variant{"wide", 3};
#else
constexpr Variant variant{"wide", 4};
#endif
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u8}}, exactly(1)}, {0x01, "one", "", report, {{"a", u32}}, variant}};
constexpr MessageIndex checked = index_messages(rows);
}    // namespace ano::table
