// Makes a self-signed certificate for the TCP access of a gateway.
#pragma once
#include "web_names.hpp"

#include <http/client/certificate.hpp>

#include <string>
#include <vector>

namespace anoctl {

struct MadeCertificate {
    std::string certificate, key;      // absolute paths
    std::vector<std::string> names;    // hosts and addresses that it is valid for
    std::string fingerprint;           // SHA-256
    bool is_for_service = false;       // the key is owned by the user of the service
};

/// This computer's name and addresses.
Computer this_computer();

/// The default folder: for root that of the gateway's configuration, if it exists; else the current one.
std::string certificate_folder();

/// The names and addresses of `computer` that a certificate is for, localhost included.
anogate::http::CertificateNames names_for(const Computer& computer);

/// Gives a new key to the user of the service, who is not root. False: there is none, or we are not root.
bool give_to_service(const std::string& key);

/// Makes certificate.pem and key.pem in `folder`, for the names and addresses of `computer`, localhost included. Throws Failure with the
/// problem and a solution. Existing files are not overwritten.
MadeCertificate make_certificate_in(const std::string& folder, const Computer& computer);

}    // namespace anoctl
