#include <config/values.hpp>
#include <link/tcp/tcp_keys.hpp>

#include <string>

namespace anogate {

void check_tcp_address(const EndpointSpec& endpoint, LinkFaults& faults) {
    const IpAddress& address = endpoint.address;
    const std::string text = in_quotes(endpoint.text());
    if (address.is_multicast() || is_broadcast(address, {}))
        faults.error("address", text + " is a multicast or broadcast address: TCP needs the address of one host; use a UDP link");
    else if (address.v6 && address.is_link_local() && endpoint.interface.empty())
        faults.error("address", text + " is a link-local address: add the interface, [" + address.text() +
                                    "%eth0]:" + std::to_string(endpoint.port));
}

void check_pair(const LinkCertificates& files, LinkFaults& faults) {
    if (files.certificate.empty() == files.key.empty()) return;
    if (files.key.empty()) faults.error("key", "'certificate' also needs 'key'");
    else faults.error("certificate", "'key' also needs 'certificate'");
}

LinkError validity_trouble(const TlsContext& context) {
    const CertificateValidity validity = context.validity();
    const std::string warning = validity.warning("the certificate of this link");
    if (warning.empty()) return {};
    if (!validity.has_begun) return {"tls", warning, {}};
    return {"certificate_expires", warning, {{"days", std::to_string(*validity.days_left)}}};
}

LinkError tls_trouble(const CertificateReader& certificates) {
    const std::string& fault = certificates.fault();
    if (fault.empty()) return certificates.in_use() ? validity_trouble(*certificates.in_use()) : LinkError{};
    if (!certificates.has_usable()) return {"tls", fault, {}};
    return {"certificate_unusable", fault + "; the previous certificates stay in use until this is corrected", {{"why", fault}}};
}

}    // namespace anogate
