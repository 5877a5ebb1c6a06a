// When a certificate is valid.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

struct x509_st;

namespace anogate {

struct CertificateValidity {
    static constexpr std::int64_t soon = 14;    // days

    bool has_begun = true;
    std::optional<std::int64_t> days_left{};    // full days, negative if it has expired; std::nullopt: there is no certificate

    bool expires_soon() const noexcept { return days_left && *days_left <= soon; }
    /// A warning, in which `name` is the certificate; empty: it is valid for longer than `soon`.
    std::string warning(std::string_view name) const;
};

/// As of now. nullptr: there is no certificate.
CertificateValidity validity_of(const x509_st* certificate);

}    // namespace anogate
