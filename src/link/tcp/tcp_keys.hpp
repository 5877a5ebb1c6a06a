// Configuration that the kinds of TCP links share.
#pragma once
#include <config/link_kind.hpp>
#include <link/link_error.hpp>
#include <link/tcp/tcp_settings.hpp>
#include <link/tcp/tls_context.hpp>

#include <string_view>

namespace anogate {

inline constexpr std::string_view dead_after_help =
    "a connection is closed when the other end is silent or acknowledges nothing for so long";
inline constexpr std::string_view certificate_help = "PEM file of our certificate, with intermediate ones";
inline constexpr std::string_view key_help = "PEM file of its key, which others may not read";
inline constexpr std::string_view ca_help =
    "PEM file of the certificates that may sign the other end's (default: those of the system)";

/// An error if there is a certificate without a key, or a key without a certificate.
void check_pair(const LinkCertificates& files, LinkFaults& faults);
/// The error of files that can't be used as they are now, or of a certificate that expires within 14 days; empty: neither.
LinkError tls_trouble(TlsContext& tls);

}    // namespace anogate
