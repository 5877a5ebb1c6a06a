// Makes a self-signed certificate for TLS: browsers ask once whether to trust it.
#pragma once
#include <sys/expected.hpp>

#include <string>
#include <vector>

namespace anogate::http {

struct CertificateNames {
    std::vector<std::string> hosts;        // "vehicle.local"; the first is its subject
    std::vector<std::string> addresses;    // "192.168.1.5"
};

/// Writes a new key (P-256, readable by our user only) and its self-signed certificate, valid for 824 days (some browsers do not accept
/// more) from yesterday (clocks differ). Existing files are never overwritten.
Expected<void> make_certificate(const CertificateNames& names, const std::string& certificate, const std::string& key);

/// The SHA-256 of the first certificate in a PEM file, as browsers show it: "AB:CD:…", 32 bytes.
Expected<std::string> fingerprint(const std::string& certificate);

}    // namespace anogate::http
