// error: a_name_is_lower_case_letters_digits_and_underscores
#include <ano/messages.hpp>

namespace ano::table {
#ifdef BAD
constexpr Field field{"Acc-X", i16};
#else
constexpr Field field{"acc_x", i16};
#endif
}    // namespace ano::table
