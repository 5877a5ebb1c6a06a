// error: the_wire_type_cannot_hold_this_value
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Field field{"a", u8, only(256)};
#else
constexpr Field field{"a", u16, only(256)};
#endif
}    // namespace ano::table
