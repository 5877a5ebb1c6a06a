// Why nobody answers at a control socket, in words for who asked.
#pragma once
#include <string>

namespace anogate::http {

/// What can be seen of a path that we could not connect to.
struct SocketFile {
    bool is_there = false;
    bool is_socket = false;
    bool can_be_seen = true;        // false: a folder on its way lets us not in
    std::string owner, group;       // their names, or numbers where they have none
    bool is_for_group = false;      // members of the group may use it
    bool lists_us = false;          // the group, for those who log in from now on
    std::string nor{};              // another socket that was looked for first; empty: none
    bool no_runtime_dir = false;    // where a gateway of this user would be can't be known
};
/// A path that is the usual one counts as looked for.
SocketFile look_at_socket(const std::string& path);

/// "no gateway is running at PATH: …" and the like; `error` is the errno of connect().
std::string connect_fault(const std::string& path, int error, const SocketFile& file);

}    // namespace anogate::http
