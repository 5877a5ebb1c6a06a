// error: the_layouts_of_a_message_share_its_traffic_class
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Traffic traffic = urgent;
#else
constexpr Traffic traffic = report;
#endif
constexpr Message rows[] = {{0x01, "one", "", report, {{"a", u8}}, exactly(1)},
                            {0x01, "one", "", traffic, {{"a", u16}}, Variant{"wide", 2}}};
constexpr MessageIndex checked = index_messages(rows);
}    // namespace ano::table
