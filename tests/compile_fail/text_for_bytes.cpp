// error: this field is not text
#include <ano/typed.hpp>

#ifdef BAD
bool fill(ano::Draft<"special">& special) { return special.set<"data">(std::string_view{"text"}); }
#else
bool fill(ano::Draft<"log">& log) { return log.set<"str">(std::string_view{"text"}); }
#endif
