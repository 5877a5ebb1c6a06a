#include <http/client/connect_fault.hpp>
#include <http/socket_path.hpp>
#include <sys/errors.hpp>

#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

namespace anogate::http {
namespace {

std::string user_name(uid_t user) {
    const passwd* entry = ::getpwuid(user);
    return entry ? entry->pw_name : std::to_string(user);
}

bool lists(const group& members, const std::string& name) {
    for (char** member = members.gr_mem; *member != nullptr; ++member)
        if (name == *member) return true;
    return false;
}

std::string no_permission(const std::string& path, const SocketFile& file) {
    const std::string no = "no permission for " + path + ": ";
    if (!file.can_be_seen) return no + "this user has no access to its folder: sudo anoctl ...";
    if (!file.is_for_group) return no + "only user " + file.owner + " has access: run sudo -u " + file.owner + " anoctl ...";
    if (file.group == "root") return no + "it belongs to group root: sudo anoctl ...";
    const std::string belongs = no + "it belongs to group " + file.group;
    if (file.lists_us) return belongs + ", which you join at your next login: log in again";
    return belongs + "; sudo usermod -aG " + file.group + " $USER, then log in again";
}

// The same search as socket_to_ask().
void note_where_it_was_sought(const std::string& path, SocketFile& file) {
    const Runner runner = this_runner();
    if (path != control_socket({}, runner)) return;
    if (path != system_socket()) file.nor = system_socket();
    else file.no_runtime_dir = !runner.system && runner.runtime_dir.empty();
}

std::string no_such_socket(const SocketFile& file) {
    std::string text = ": socket not found";
    if (!file.nor.empty()) text += ", nor " + file.nor;
    if (file.no_runtime_dir) text += "; XDG_RUNTIME_DIR is not set, so a gateway of this user can't be found";
    return text + " (another one: --control PATH)";
}

}    // namespace

SocketFile look_at_socket(const std::string& path) {
    SocketFile file;
    note_where_it_was_sought(path, file);
    struct stat info {};
    if (::stat(path.c_str(), &info) != 0) {
        file.can_be_seen = errno != EACCES;
        return file;
    }
    file.is_there = true;
    file.is_socket = S_ISSOCK(info.st_mode);
    file.owner = user_name(info.st_uid);
    file.is_for_group = (info.st_mode & S_IWGRP) != 0;
    const group* its = ::getgrgid(info.st_gid);
    file.group = its ? its->gr_name : std::to_string(info.st_gid);
    file.lists_us = its && lists(*its, user_name(::geteuid()));
    return file;
}

std::string connect_fault(const std::string& path, int error, const SocketFile& file) {
    const std::string none = "no gateway is running at " + path;
    switch (error) {
    case ENOENT:
    case ENOTDIR: return none + no_such_socket(file);
    case ECONNREFUSED: return file.is_socket ? none + ": the socket is left from a stopped one" : path + " is not a socket";
    case EACCES: return no_permission(path, file);
    case EPROTOTYPE: return "the program at " + path + " is not a gateway";
    default: return error_text(path, error);
    }
}

}    // namespace anogate::http
