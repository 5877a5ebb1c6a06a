// Encrypted streams: TLS 1.2 and 1.3 by OpenSSL.
#pragma once
#include <http/stream.hpp>
#include <sys/certificate_validity.hpp>
#include <sys/expected.hpp>

#include <memory>
#include <string>

namespace anogate::http {

/// A certificate and its key, read by load(). May be destroyed before its streams.
class Tls {
public:
    /// PEM files: the certificate with its intermediate certificates, and the key without a password, which others may not read.
    static Expected<std::unique_ptr<Tls>> load(const std::string& certificate, const std::string& key);
    ~Tls();

    /// A warning about the key; empty: none. A new connection with a large RSA key takes the loop many milliseconds.
    std::string advice() const;
    CertificateValidity validity() const;

    /// The server's side of a connected socket. The handshake is done with the first read or write, which must be called only
    /// after the client has sent something.
    std::unique_ptr<Stream> stream(Socket socket, ConnectionInfo connection_info) const;

private:
    struct Context;
    explicit Tls(std::shared_ptr<Context> context);
    std::shared_ptr<Context> context_;
};

}    // namespace anogate::http
