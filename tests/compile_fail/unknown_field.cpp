// error: the_layout_has_no_such_field
#include <ano/typed.hpp>

#ifdef BAD
auto read(ano::View<"euler"> euler) { return euler.get<"roll">(); }
#else
auto read(ano::View<"euler"> euler) { return euler.get<"rol">(); }
#endif
