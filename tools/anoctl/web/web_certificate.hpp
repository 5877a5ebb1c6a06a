// Makes a self-signed certificate for the TCP access of a gateway.
#pragma once
#include "web_names.hpp"

#include <http/client/certificate.hpp>

#include <string>
#include <vector>

namespace anoctl {

struct MadeCertificate {
    std::string certificate, key;      // absolute paths
    std::vector<std::string> names;    // hosts and addresses for which it is valid
    std::string fingerprint;           // SHA-256
    bool is_for_service = false;       // the key is owned by the user of the service
};

/// The name and the addresses of this computer.
Computer this_computer();

/// The default folder: for root, the folder of the gateway's configuration if it exists; otherwise the current folder.
std::string certificate_folder();

/// The names and addresses of `computer` for its certificate, including localhost.
anogate::http::CertificateNames names_for(const Computer& computer);

/// Makes the user of the service the owner of a new key. False: there is no such user, this process is not root, or the file is
/// not as expected.
bool set_service_owner(const std::string& key);

/// Creates certificate.pem and key.pem in `folder`, for the names and addresses of `computer`, including localhost. Throws
/// Failure with the problem and a solution. Existing files are not overwritten.
MadeCertificate make_certificate_in(const std::string& folder, const Computer& computer);

}    // namespace anoctl
