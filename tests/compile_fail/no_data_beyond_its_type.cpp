// error: the_wire_type_cannot_hold_this_value
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Field field{"a", u16, NoData{INT16_MIN}};
#else
constexpr Field field{"a", i16, NoData{INT16_MIN}};
#endif
}    // namespace ano::table
