// error: this field is not a number
#include <ano/typed.hpp>

#ifdef BAD
bool fill(ano::Draft<"log">& log) { return log.set<"str">(1); }
#else
bool fill(ano::Draft<"log">& log) { return log.set<"color">(1); }
#endif
