// error: another_length_moves_the_fields_so_the_base_layout_is_exact
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Variant base{};
#else
constexpr Variant base = exactly(2);
#endif
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u16}}, base},
                            {0x01, "one", "", report, {{"mode", u8}, {"a", u16}}, Variant{"field", 3}}};
constexpr MessageIndex checked = index_messages(rows);
}    // namespace ano::table
