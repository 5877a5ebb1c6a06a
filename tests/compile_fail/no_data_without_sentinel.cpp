// error: this field has no value that says
#include <ano/typed.hpp>

#ifdef BAD
void fill(ano::Draft<"velocity">& velocity) { velocity.clear<"speed_x">(); }
#else
void fill(ano::Draft<"general_velocity">& velocity) { velocity.clear<"speed_x">(); }
#endif
