// error: two_messages_share_an_id
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr std::uint8_t id = 0x01;
#else
constexpr std::uint8_t id = 0x02;
#endif
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u8}}}, {id, "two", "", report, {{"a", u8}}}};
constexpr MessageIndex checked = index_messages(rows);
}    // namespace ano::table
