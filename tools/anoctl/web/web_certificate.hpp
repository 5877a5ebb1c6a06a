// What a certificate of this computer contains, and where it is stored.
#pragma once
#include "web_names.hpp"

#include <http/client/certificate.hpp>

#include <string>

namespace anoctl {

/// The name and the addresses of this computer.
Computer this_computer();

/// The default folder: for root, the folder of the gateway's configuration if it exists; otherwise the current folder.
std::string certificate_folder();

/// The names and addresses of `computer` for its certificate, including localhost.
anogate::http::CertificateNames names_for(const Computer& computer);

/// Makes the user of the service the owner of a new key. False: there is no such user, this process is not root, or the file is
/// not as expected.
bool set_service_owner(const std::string& key);

}    // namespace anoctl
