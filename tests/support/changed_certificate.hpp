// A certificate that is not valid yet, or not for long.
#pragma once
#include <openssl/pem.h>

#include <chrono>
#include <cstdio>
#include <string>

namespace support {

/// Changes the certificate so that it is valid between these times from now, and signs it by its own key. False: that failed.
inline bool change_validity(const std::string& certificate, const std::string& key, std::chrono::seconds begin,
                            std::chrono::seconds end) {
    std::FILE* const file = std::fopen(certificate.c_str(), "r+e");
    std::FILE* const key_file = std::fopen(key.c_str(), "re");
    if (!file || !key_file) return false;
    X509* const changed = PEM_read_X509(file, nullptr, nullptr, nullptr);
    EVP_PKEY* const its_key = PEM_read_PrivateKey(key_file, nullptr, nullptr, nullptr);
    std::rewind(file);
    const bool done = X509_gmtime_adj(X509_getm_notBefore(changed), static_cast<long>(begin.count())) != nullptr &&
                      X509_gmtime_adj(X509_getm_notAfter(changed), static_cast<long>(end.count())) != nullptr &&
                      X509_sign(changed, its_key, EVP_sha256()) > 0 && PEM_write_X509(file, changed) == 1;
    X509_free(changed);
    EVP_PKEY_free(its_key);
    std::fclose(key_file);
    return std::fclose(file) == 0 && done;
}

/// Valid from tomorrow on.
inline bool postpone_validity(const std::string& certificate, const std::string& key) {
    constexpr std::chrono::hours day{24};
    return change_validity(certificate, key, day, 300 * day);
}

}    // namespace support
