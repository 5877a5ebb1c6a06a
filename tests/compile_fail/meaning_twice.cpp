// error: one_value_has_two_meanings
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Meaning states[]{{0, "off"}, {0, "on"}};
#else
constexpr Meaning states[]{{0, "off"}, {1, "on"}};
#endif
constexpr Field field{"a", u8, states};
}    // namespace ano::table
