// Makes certificates for TLS: self-signed ones, which browsers ask the user to accept once, and ones signed by an authority of
// the user.
#pragma once
#include <sys/expected.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace anogate::http {

struct CertificateNames {
    std::vector<std::string> hosts;        // "vehicle.local"; the first is its subject
    std::vector<std::string> addresses;    // "192.168.1.5"
};

/// Writes a new key (P-256, readable by our user only) and its self-signed certificate. The certificate is valid for 824 days
/// (some browsers do not accept more), from yesterday on (clocks differ). Existing files are never overwritten.
Expected<void> make_certificate(const CertificateNames& names, const std::string& certificate, const std::string& key);

/// PEM files.
struct CertificateFiles {
    std::string certificate, key;
};
/// Writes a new authority, which signs the certificates of several computers, valid for 20 years. Existing files are never overwritten.
Expected<void> make_authority(const std::string& name, const CertificateFiles& files);
enum class Existing : std::uint8_t { kept, replaced };
/// As make_certificate(), signed by `authority`; also valid for clients. If existing files are replaced, the new key has the owner
/// and the mode of the previous one.
Expected<void> make_signed_certificate(const CertificateNames& names, const CertificateFiles& files,
                                       const CertificateFiles& authority, Existing existing = Existing::kept);

/// The names and addresses in the first certificate of a PEM file.
Expected<CertificateNames> names_in(const std::string& certificate);

/// The SHA-256 of the first certificate in a PEM file, as browsers show it: "AB:CD:…", 32 bytes.
Expected<std::string> fingerprint(const std::string& certificate);

}    // namespace anogate::http
