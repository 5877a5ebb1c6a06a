// error: a_list_needs_elements_of_fixed_size
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Message row{0x01, "one", "", report, {{"a", u8}, {"points", list}}};
#else
constexpr Message row{0x01, "one", "", report, {{"a", u8}, {"points", list}, {"x", i16}}};
#endif
}    // namespace ano::table
