// The user and the program at the other end of a Unix socket, as text for people.
#pragma once
#include <sys/types.h>

#include <string>

namespace anogate {

/// "anoctl of pi, process 712"; "a program of user 1005, process 712" if the names are not readable. `process` 0: not known.
std::string local_client(uid_t user, pid_t process);

}    // namespace anogate
