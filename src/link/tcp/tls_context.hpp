// TLS 1.2 and 1.3 for connections of links, by OpenSSL.
#pragma once
#include <link/link_error.hpp>
#include <link/tcp/tcp_settings.hpp>

#include <sys/types.h>
#include <sys/uio.h>

#include <cstdint>
#include <memory>
#include <optional>
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
    /// To be called again when the socket can be read or written, as the result asks. `failed`: fault() says why.
    Handshake go_on();
    /// After wants_to_read: go_on() has a whole record, or the end of input, to work on. While there is none the socket reports nothing.
    bool has_record();
    /// The handshake is done.
    bool is_done() const noexcept;
    const std::string& fault() const noexcept;

    /// As read() and writev(). What write() has taken may still wait here; the next call sends it first.
    ssize_t read(std::span<std::uint8_t> room);
    ssize_t write(std::span<const iovec> pieces);
    /// Of what write() has taken: bytes that wait here.
    std::size_t unsent() const noexcept;
    /// More may be there although the socket reports nothing.
    bool has_more() const noexcept;

private:
    std::unique_ptr<Parts> parts_;
};

/// The certificates of a link. The files are read again when they have changed; connections that are open go on.
class TlsContext {
public:
    enum class Side { connects, listens };
    TlsContext(LinkCertificates files, Side side);
    ~TlsContext();
    TlsContext(const TlsContext&) = delete;
    TlsContext& operator=(const TlsContext&) = delete;

    /// For a connected socket. `host`: the name or address that the other end's certificate must have; empty: any.
    Opened<std::shared_ptr<TlsConnection>> connection(int fd, const std::string& host);
    /// Reads the files when they have changed. Those that can't be used now don't replace the ones before: see fault().
    Opened<void> refresh();
    /// Why the files can't be used as they are now; empty: they can.
    const std::string& fault() const noexcept { return fault_; }
    /// Full days until our certificate expires, below zero when it has; std::nullopt: there is none. Reads the files as refresh() does, so
    /// that the status tells of new ones although nobody connects.
    std::optional<std::int64_t> days_left();

private:
    struct Loaded;

    LinkCertificates files_;
    Side side_;
    std::shared_ptr<const Loaded> loaded_;
    std::string fault_;
};

}    // namespace anogate
