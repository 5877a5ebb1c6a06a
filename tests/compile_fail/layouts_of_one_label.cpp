// error: two_layouts_share_a_label
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr const char* label = "wide";
#else
constexpr const char* label = "wider";
#endif
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u8}}, exactly(1)},
                            {0x01, "one", "", report, {{"a", u16}}, Variant{"wide", 2}},
                            {0x01, "one", "", report, {{"a", u32}}, Variant{label, 4}}};
constexpr MessageIndex checked = index_messages(rows);
}    // namespace ano::table
