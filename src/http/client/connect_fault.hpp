// Explains to the user why a control socket can't be connected to.
#pragma once
#include <string>

namespace anogate::http {

/// The known facts about a path that can't be connected to.
struct SocketFile {
    bool is_there = false;
    bool is_socket = false;
    bool can_be_seen = true;        // false: our user may not enter a folder of the path
    std::string owner, group;       // names, or numbers where there is no name
    bool is_for_group = false;      // members of the group may use it
    bool lists_us = false;          // our user is a member of the group, in effect from the next login on
    std::string nor{};              // another socket that was tried first; empty: none
    bool no_runtime_dir = false;    // the path of a gateway of this user is unknown
};
/// The default path counts as found by searching: `nor` and `no_runtime_dir` are set.
SocketFile look_at_socket(const std::string& path);

/// "no gateway is running at PATH: …" and the like; `error` is the errno of connect().
std::string connect_fault(const std::string& path, int error, const SocketFile& file);

}    // namespace anogate::http
