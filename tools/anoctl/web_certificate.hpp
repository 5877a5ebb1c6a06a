// A certificate of our own for a gateway's TCP door.
#pragma once
#include "web_names.hpp"

#include <string>
#include <vector>

namespace anoctl {

struct MadeCertificate {
    std::string certificate, key;      // whole paths
    std::vector<std::string> names;    // that it is for: hosts and addresses
    std::string fingerprint;           // SHA-256
    bool is_for_service = false;       // the service's user owns the key
};

/// The folder when none is given: that of the gateway's configuration for root, where there is one, else this one.
std::string certificate_folder();

/// Makes certificate.pem and key.pem in `folder`, for the names and addresses of `computer`, localhost included. Throws Failure: what
/// is in the way, and what to do. Nothing is written over.
MadeCertificate make_certificate_in(const std::string& folder, const Computer& computer);

}    // namespace anoctl
