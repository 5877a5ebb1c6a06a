// error: the_message_has_no_such_layout
#include <ano/typed.hpp>

#ifdef BAD
auto read(ano::FrameView frame) { return ano::as<"power", "fields">(frame); }
#else
auto read(ano::FrameView frame) { return ano::as<"power", "field">(frame); }
#endif
