// error: the_wire_type_cannot_hold_this_value
#include <ano/messages.hpp>

namespace ano::table {
constexpr Meaning states[]{{256, "far"}};
#ifdef BAD
constexpr Field field{"a", u8, states};
#else
constexpr Field field{"a", u16, states};
#endif
}    // namespace ano::table
