#include <link/tcp/tcp_keys.hpp>

#include <string>

namespace anogate {

void check_pair(const LinkCertificates& files, LinkFaults& faults) {
    if (files.certificate.empty() == files.key.empty()) return;
    if (files.key.empty()) faults.error("key", "'certificate' also needs 'key'");
    else faults.error("certificate", "'key' also needs 'certificate'");
}

LinkError tls_trouble(TlsContext& tls) {
    const auto days_left = tls.days_left();
    if (const std::string& fault = tls.fault(); !fault.empty())
        return {"tls", fault + (days_left ? "; the previous certificates stay in use until a restart" : ""), {}};
    constexpr std::int64_t soon = 14;
    if (!days_left || *days_left > soon) return {};
    const std::string days = std::to_string(*days_left);
    if (*days_left < 0) return {"certificate_expires", "the certificate of this link has expired: replace it", {{"days", days}}};
    return {"certificate_expires", "the certificate of this link expires in " + days + " days: replace it", {{"days", days}}};
}

}    // namespace anogate
