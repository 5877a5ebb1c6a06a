// error: a_scale_is_not_zero
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Field field{"a", i16, times(0)};
#else
constexpr Field field{"a", i16, times(100)};
#endif
}    // namespace ano::table
