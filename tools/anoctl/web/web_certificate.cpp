#include "web_certificate.hpp"

#include <http/client/certificate.hpp>
#include <link/udp/ip_socket.hpp>
#include <sys/unique_fd.hpp>

#include <fcntl.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <climits>
#include <filesystem>

namespace anoctl {
namespace {

namespace fs = std::filesystem;
using anogate::http::CertificateNames;

constexpr char folder_of_the_system[] = "/etc/anogate";
constexpr char user_of_the_service[] = "anogate";

}    // namespace

CertificateNames names_for(const Computer& computer) {
    CertificateNames names{names_of(computer), {}};
    names.hosts.emplace_back("localhost");
    for (const anogate::IpAddress& address : reachable(computer)) names.addresses.push_back(address.text());
    names.addresses.emplace_back("127.0.0.1");
    names.addresses.emplace_back("::1");
    return names;
}

// The service does not run as root and can't read a key that only root may read. The owner of the folder may have replaced the
// file by a hard link to another file of root: the owner of such a file is not changed.
bool set_service_owner(const std::string& key) {
    const passwd* user = ::geteuid() == 0 ? ::getpwnam(user_of_the_service) : nullptr;
    if (!user) return false;
    const anogate::UniqueFd fd{::open(key.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK)};
    struct stat facts {};
    return fd && ::fstat(fd.get(), &facts) == 0 && S_ISREG(facts.st_mode) && facts.st_nlink == 1 &&
           ::fchown(fd.get(), user->pw_uid, user->pw_gid) == 0;
}

Computer this_computer() {
    char name[HOST_NAME_MAX + 1] = {};
    Computer computer;
    if (::gethostname(name, sizeof name - 1) == 0) computer.name = name;
    for (const anogate::Network& network : anogate::own_networks()) computer.addresses.push_back(network.address);
    return computer;
}

std::string certificate_folder() {
    std::error_code ec;
    return ::geteuid() == 0 && fs::is_directory(folder_of_the_system, ec) ? folder_of_the_system : ".";
}

}    // namespace anoctl
