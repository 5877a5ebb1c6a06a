// Encrypted streams (TLS 1.2 and 1.3, by OpenSSL).
#pragma once
#include <http/stream.hpp>
#include <link/expected.hpp>

#include <memory>
#include <string>

namespace anogate::http {

/// A certificate with its key, read whole when it is made. Streams keep what they need of it.
class Tls {
public:
    /// PEM files: the certificate with those between it and its authority, and the key, without a password.
    static Expected<std::unique_ptr<Tls>> load(const std::string& certificate, const std::string& key);
    ~Tls();

    /// The server's side of a connected socket. The handshake comes before what is first read or written.
    std::unique_ptr<Stream> stream(Socket socket, Door door) const;

private:
    struct Context;
    explicit Tls(std::shared_ptr<Context> context);
    std::shared_ptr<Context> context_;
};

}    // namespace anogate::http
