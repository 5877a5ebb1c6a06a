// A certificate that is not valid yet.
#pragma once
#include <openssl/pem.h>

#include <cstdio>
#include <string>

namespace support {

/// Changes the certificate so that it is valid from tomorrow on, and signs it by its own key. False: that failed.
inline bool postpone_validity(const std::string& certificate, const std::string& key) {
    std::FILE* const file = std::fopen(certificate.c_str(), "r+e");
    std::FILE* const key_file = std::fopen(key.c_str(), "re");
    if (!file || !key_file) return false;
    X509* const changed = PEM_read_X509(file, nullptr, nullptr, nullptr);
    EVP_PKEY* const its_key = PEM_read_PrivateKey(key_file, nullptr, nullptr, nullptr);
    std::rewind(file);
    const bool done = X509_gmtime_adj(X509_getm_notBefore(changed), 24L * 60 * 60) != nullptr &&
                      X509_sign(changed, its_key, EVP_sha256()) > 0 && PEM_write_X509(file, changed) == 1;
    X509_free(changed);
    EVP_PKEY_free(its_key);
    std::fclose(key_file);
    return std::fclose(file) == 0 && done;
}

}    // namespace support
