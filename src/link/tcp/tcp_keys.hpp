// Configuration shared by the kinds of TCP links.
#pragma once
#include <config/link_kind.hpp>
#include <link/link_error.hpp>
#include <link/tcp/certificate_reader.hpp>
#include <link/tcp/tcp_settings.hpp>

#include <cstdint>
#include <optional>
#include <string_view>

namespace anogate {

inline constexpr std::string_view dead_after_help =
    "close a connection when the peer is silent or acknowledges nothing for this time";
inline constexpr std::string_view certificate_help = "PEM file of the certificate, with intermediate certificates";
inline constexpr std::string_view key_help = "PEM file of its private key, not readable by other users";
inline constexpr std::string_view ca_help = "PEM file of the CA certificates to accept (default: those of the system)";

/// An error for a multicast or broadcast address, and for a link-local address without an interface.
void check_tcp_address(const EndpointSpec& address, LinkFaults& faults);
/// An error if there is a certificate without a key, or a key without a certificate.
void check_pair(const LinkCertificates& files, LinkFaults& faults);
/// The error for a certificate that is not valid yet, expires within 14 days or has expired; empty: none of them.
LinkError validity_trouble(const TlsContext& context);
/// The error for files that can't be used, or as validity_trouble(); empty: neither.
LinkError tls_trouble(const CertificateReader& certificates);

}    // namespace anogate
