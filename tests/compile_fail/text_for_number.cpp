// error: this field is a number
#include <ano/typed.hpp>

#ifdef BAD
bool fill(ano::Draft<"log">& log, ano::Bytes bytes) { return log.set<"color">(bytes); }
#else
bool fill(ano::Draft<"log">& log, ano::Bytes bytes) { return log.set<"str">(bytes); }
#endif
