// A listening Unix socket and its file. Never touches files of other users; removes the file only while it is ours.
#pragma once
#include <sys/descriptor.hpp>
#include <sys/files/held_folder.hpp>
#include <sys/files/path_lock.hpp>

#include <sys/types.h>

#include <string>

namespace anogate::http {

class LocalSocket {
public:
    struct Outcome {
        std::string error;      // empty: it listens
        bool in_use = false;    // another program has the path: it may be free later
        std::string notice;     // it listens, but some users that might be expected can't connect
        UniqueFd fd;            // the listening socket
    };
    /// Listens at `path` for our user, and for the group `anogate` if it exists and we are a member. Makes a missing folder that is
    /// is_own_folder(); replaces a socket left by a dead process. After an error it may be called again.
    Outcome listen(const std::string& path);
    /// Removes the file if it is still ours. To be called before the listening socket is closed, so that clients never find the
    /// file of a closed socket.
    void remove() noexcept;

private:
    Outcome make_room(const std::string& path);
    Outcome make(int socket, const std::string& path);
    bool let_in(gid_t group);

    PathLock lock_;
    HeldFolder folder_;
    std::string name_;
    UniqueFd made_;    // the file that listen() made
};

}    // namespace anogate::http
