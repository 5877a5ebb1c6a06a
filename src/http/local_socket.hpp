// A listening Unix socket and its file: made where no other user's thing is touched, removed only while it is our own.
#pragma once
#include <link/descriptor.hpp>
#include <link/held_folder.hpp>
#include <link/path_claim.hpp>

#include <sys/types.h>

#include <string>

namespace anogate::http {

class LocalSocket {
public:
    struct Outcome {
        std::string error;      // empty: it listens
        bool in_use = false;    // another program has the path: it may be free later
        std::string notice;     // it listens, but not for all whom one might expect
        UniqueFd fd;            // what listens
    };
    /// Listens at `path` for our own user, and for the group `anogate` when there is one that we are in. A folder of our own is made
    /// when missing, a socket that a dead process left is replaced. After an error it may be tried again.
    Outcome listen(const std::string& path);
    /// Removes the file while it is ours. Before what listens is closed: who finds the file must find somebody.
    void remove() noexcept;

private:
    Outcome make_room(const std::string& path);
    Outcome make(int socket, const std::string& path);
    bool let_in(gid_t group);

    PathClaim claim_;
    HeldFolder folder_;
    std::string name_;
    UniqueFd made_;    // what listen() made at the path
};

}    // namespace anogate::http
