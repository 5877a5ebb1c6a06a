// error: a_field_of_open_length_must_be_last
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Message row{0x01, "one", "", report, {{"str", text}, {"a", u8}}};
#else
constexpr Message row{0x01, "one", "", report, {{"a", u8}, {"str", text}}};
#endif
}    // namespace ano::table
