// A certificate of our own, for TLS without an authority: browsers ask once whether it is to be trusted.
#pragma once
#include <link/expected.hpp>

#include <string>
#include <vector>

namespace anogate::http {

struct CertificateNames {
    std::vector<std::string> hosts;        // "vehicle.local"; the first is its subject
    std::vector<std::string> addresses;    // "192.168.1.5"
};

/// Writes a new key (P-256, readable for us alone) and a certificate for it that it signed itself, valid from yesterday, since clocks
/// differ, for 824 days: more is not trusted by some browsers. Files that exist are never written over.
Expected<void> make_certificate(const CertificateNames& names, const std::string& certificate, const std::string& key);

/// Of the first certificate in a PEM file, SHA-256 as browsers show it: "AB:CD:…", 32 bytes.
Expected<std::string> fingerprint(const std::string& certificate);

}    // namespace anogate::http
