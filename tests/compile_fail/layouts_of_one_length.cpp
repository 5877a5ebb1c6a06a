// error: a_layout_before_takes_this_length_already
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Variant variant{"signed", 2};
#else
constexpr Variant variant{"signed", 3};
#endif
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u8}}, exactly(1)},
                            {0x01, "one", "", report, {{"a", u16}}, Variant{"wide", 2}},
                            {0x01, "one", "", report, {{"a", i16}}, variant}};
constexpr MessageIndex checked = index_messages(rows);
}    // namespace ano::table
