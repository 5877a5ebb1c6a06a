// error: a_field_is_named_twice
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Message row{0x01, "one", "", report, {{"a", u8}, {"b", u8}, {"a", u16}}};
#else
constexpr Message row{0x01, "one", "", report, {{"a", u8}, {"b", u8}, {"c", u16}}};
#endif
}    // namespace ano::table
