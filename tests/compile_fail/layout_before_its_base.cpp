// error: the_first_row_of_a_message_is_its_base_layout
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u16}}, Variant{"wide", 2}},
                            {0x01, "one", "", report, {{"a", u8}}, exactly(1)}};
#else
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u8}}, exactly(1)},
                            {0x01, "one", "", report, {{"a", u16}}, Variant{"wide", 2}}};
#endif
constexpr MessageIndex checked = index_messages(rows);
}    // namespace ano::table
