// error: no_message_has_this_name
#include <ano/typed.hpp>

#ifdef BAD
auto read(ano::FrameView frame) { return ano::as<"eulr">(frame); }
#else
auto read(ano::FrameView frame) { return ano::as<"euler">(frame); }
#endif
