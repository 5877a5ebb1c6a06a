// The file of a listening Unix socket: made where no other user's thing is touched, removed only while it is our own.
#pragma once
#include <link/held_folder.hpp>
#include <link/path_claim.hpp>

#include <sys/types.h>

#include <string>

namespace anogate {

class SocketFile {
public:
    struct Outcome {
        std::string error;      // empty: it listens
        bool in_use = false;    // another program has the path: it may be free later
    };
    /// `socket`, of the type SOCK_STREAM, listens at `path`, for our own user alone. A folder of our own is made when missing, a
    /// socket that a dead process left is replaced.
    Outcome listen(int socket, const std::string& path);
    /// The group may use it, too. False: it may not, for we are not in it, or it is not ours to let in.
    bool let_in(gid_t group);
    /// Before the socket is closed.
    void remove() noexcept;

private:
    Outcome make_room(const std::string& path);
    Outcome make(int socket, const std::string& path);

    PathClaim claim_;
    HeldFolder folder_;
    std::string name_;
    UniqueFd made_;    // what listen() made at the path
};

}    // namespace anogate
