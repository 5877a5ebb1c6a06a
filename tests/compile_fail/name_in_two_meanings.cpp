// error: one_name_stands_for_two_messages
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr const char* name = "one";
#else
constexpr const char* name = "two";
#endif
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u8}}}, {0x02, name, "", report, {{"a", u8}}}};
constexpr MessageIndex checked = index_messages(rows);
}    // namespace ano::table
