// TLS 1.2 and 1.3 for connections of links, by OpenSSL.
#pragma once
#include <link/link_error.hpp>
#include <link/tcp/tcp_settings.hpp>
#include <sys/certificate_validity.hpp>

#include <sys/types.h>
#include <sys/uio.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace anogate {

/// One end of an encrypted connection over a non-blocking socket. For one thread at a time.
class TlsConnection {
public:
    struct Parts;
    explicit TlsConnection(std::unique_ptr<Parts> parts);
    ~TlsConnection();
    TlsConnection(const TlsConnection&) = delete;
    TlsConnection& operator=(const TlsConnection&) = delete;

    enum class Handshake { done, wants_to_read, wants_to_write, failed };
    /// To be called again when the socket can be read or written, depending on the result. `failed`: fault() returns the reason.
    Handshake go_on();
    /// After wants_to_read: whether a complete record or the end of input is available for go_on(). Until then the socket does
    /// not report that it is readable.
    bool has_record();
    /// The handshake is done.
    bool is_done() const noexcept;
    const std::string& fault() const noexcept;

    /// As read() and writev(). Bytes accepted by write() may be buffered here; the next call sends them first.
    ssize_t read(std::span<std::uint8_t> room);
    ssize_t write(std::span<const iovec> pieces);
    /// Number of bytes that write() accepted and that are still buffered here.
    std::size_t unsent() const noexcept;
    /// Whether more may be readable although the socket does not report it.
    bool has_more() const noexcept;

private:
    std::unique_ptr<Parts> parts_;
};

/// The certificates of a link, as they were in its files. Never changes.
class TlsContext {
public:
    enum class Side { connects, listens };
    /// Reads the files. May block on the disk, and takes a tenth of a second for the certificates of many authorities.
    static Opened<std::shared_ptr<const TlsContext>> read(const LinkCertificates& files, Side side);
    ~TlsContext();
    TlsContext(const TlsContext&) = delete;
    TlsContext& operator=(const TlsContext&) = delete;

    /// For a connected socket. `host`: the name or address that the other end's certificate must have; empty: any.
    Opened<std::shared_ptr<TlsConnection>> connection(int fd, const std::string& host) const;
    /// Of our certificate.
    CertificateValidity validity() const;

private:
    struct Parts;
    TlsContext(std::unique_ptr<Parts> parts, Side side);

    std::unique_ptr<Parts> parts_;
    Side side_;
};

}    // namespace anogate
