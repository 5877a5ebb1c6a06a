// error: a_row_has_too_many_fields
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Message row{0x01,
                      "one",
                      "",
                      report,
                      {{"a", u8},
                       {"b", u8},
                       {"c", u8},
                       {"d", u8},
                       {"e", u8},
                       {"f", u8},
                       {"g", u8},
                       {"h", u8},
                       {"i", u8},
                       {"j", u8},
                       {"k", u8},
                       {"l", u8},
                       {"m", u8}}};
#else
constexpr Message row{0x01,
                      "one",
                      "",
                      report,
                      {{"a", u8},
                       {"b", u8},
                       {"c", u8},
                       {"d", u8},
                       {"e", u8},
                       {"f", u8},
                       {"g", u8},
                       {"h", u8},
                       {"i", u8},
                       {"j", u8},
                       {"k", u8},
                       {"l", u8}}};
#endif
}    // namespace ano::table
