// The settings of TCP links, encrypted or not.
#pragma once
#include <ano/time.hpp>
#include <gateway/host_spec.hpp>
#include <link/v7_settings.hpp>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

enum class TlsVerify : std::uint8_t { peer, none };

/// PEM files of an encrypted link.
struct LinkCertificates {
    std::string certificate;    // ours, with its intermediate certificates; empty: none
    std::string key;            // of the certificate, without a password
    std::string ca;             // authorities of accepted certificates; empty: those of the system
    TlsVerify verify = TlsVerify::peer;
    bool operator==(const LinkCertificates&) const = default;
};

struct TcpSettings {
    HostSpec peer;
    ano::Duration dead_after = std::chrono::seconds{10};
    LinkCertificates tls;    // of a `tls` link
    V7LinkSettings v7{};
    bool operator==(const TcpSettings&) const = default;
};

struct TcpListenSettings {
    EndpointSpec local;
    ano::Duration dead_after = std::chrono::seconds{10};
    std::uint16_t max_peers = 16;
    std::optional<std::uint16_t> max_per_address;    // std::nullopt: a quarter of max_peers, at least 2
    bool allow_any = false;
    std::vector<Network> allow;    // empty without allow_any: the networks of our interfaces
    bool trusted_any = false;
    std::vector<Network> trusted;    // networks for which a quarter of the places is reserved
    LinkCertificates tls;            // of a `tls-listen` link
    V7LinkSettings v7{};             // of every connection
    bool operator==(const TcpListenSettings&) const = default;
};

}    // namespace anogate
