#include <sys/certificate_validity.hpp>

#include <openssl/x509.h>

namespace anogate {

std::string CertificateValidity::warning(std::string_view name) const {
    std::string text{name};
    if (!has_begun) return text += " is not valid yet: check the clock of this computer, or replace it";
    if (!expires_soon()) return {};
    if (*days_left < 0) return text += " has expired: replace it";
    return text += " expires in " + std::to_string(*days_left) + (*days_left == 1 ? " day" : " days") + ": replace it";
}

CertificateValidity validity_of(const x509_st* certificate) {
    if (!certificate) return {};
    CertificateValidity validity{::X509_cmp_current_time(::X509_get0_notBefore(certificate)) <= 0};
    int days = 0, seconds = 0;
    if (::ASN1_TIME_diff(&days, &seconds, nullptr, ::X509_get0_notAfter(certificate)) == 1)
        validity.days_left = days < 0 || seconds < 0 ? days - 1 : days;
    return validity;
}

}    // namespace anogate
