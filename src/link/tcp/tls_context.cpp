#include <link/tcp/record_ends.hpp>
#include <link/tcp/tls_context.hpp>
#include <sys/errors.hpp>
#include <sys/unique_fd.hpp>
#include <sys/unread.hpp>

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>
#include <vector>

namespace anogate {
namespace {

constexpr std::size_t most_per_write = 16 * 1024;
constexpr int records_per_read = 32;
constexpr int without_data_per_read = 16;    // of them, those of TLS itself; servers send a few
constexpr int max_handshake_steps = 64;      // each may cost a thread; a usual handshake has about five

using Context = std::unique_ptr<SSL_CTX, void (*)(SSL_CTX*)>;

/// The text of the oldest OpenSSL error in this thread.
std::string openssl_fault() {
    const unsigned long error = ::ERR_get_error();
    ::ERR_clear_error();
    const int number = ERR_GET_LIB(error) == ERR_LIB_SSL ? ERR_GET_REASON(error) : 0;
    if (number == SSL_R_WRONG_VERSION_NUMBER || number == SSL_R_HTTP_REQUEST || number == SSL_R_HTTPS_PROXY_REQUEST)
        return "the other end does not use TLS";
    const char* const reason = error == 0 ? nullptr : ::ERR_reason_error_string(error);
    return reason ? reason : "TLS failed";
}

// OpenSSL does not report why a file can't be read, and would block on a pipe.
std::string fault_of_file(const std::string& file, bool is_secret) {
    struct stat facts {};
    if (::access(file.c_str(), R_OK) != 0 || ::stat(file.c_str(), &facts) != 0) {
        const bool is_closed = errno == EACCES && is_secret;
        return error_text(file, errno) + (is_closed ? "; for the service, run sudo chown anogate: " + file : "");
    }
    if (!S_ISREG(facts.st_mode)) return file + ": is not a file";
    const bool is_open = is_secret && (facts.st_mode & S_IRWXO) != 0;
    return is_open ? file + ": every user of this computer can read it; run chmod o= " + file : "";
}

std::string fault_of_files(const LinkCertificates& files) {
    for (const std::string* file : {&files.certificate, &files.key, &files.ca})
        if (!file->empty())
            if (std::string fault = fault_of_file(*file, file == &files.key); !fault.empty()) return fault;
    return {};
}

// The certificate of a computer in `ca` verifies nothing, unless it signed itself.
bool has_authority(SSL_CTX* context) {
    const STACK_OF(X509_OBJECT)* const all = ::X509_STORE_get0_objects(::SSL_CTX_get_cert_store(context));
    for (int i = 0; i < sk_X509_OBJECT_num(all); ++i) {
        X509* const one = ::X509_OBJECT_get0_X509(sk_X509_OBJECT_value(all, i));
        if (!one) continue;
        const bool signed_itself = ::X509_NAME_cmp(::X509_get_subject_name(one), ::X509_get_issuer_name(one)) == 0;
        if (signed_itself || ::X509_check_ca(one) != 0) return true;
    }
    return false;
}

// Never asks for a password at the terminal.
std::string use_key(SSL_CTX* context, const std::string& file) {
    if (file.empty()) return {};
    bool has_password = false;
    ::SSL_CTX_set_default_passwd_cb_userdata(context, &has_password);
    ::SSL_CTX_set_default_passwd_cb(context, [](char*, int, int, void* asked) {
        *static_cast<bool*>(asked) = true;
        return 0;
    });
    const bool is_used = ::SSL_CTX_use_PrivateKey_file(context, file.c_str(), SSL_FILETYPE_PEM) == 1;
    ::SSL_CTX_set_default_passwd_cb(context, nullptr);
    ::SSL_CTX_set_default_passwd_cb_userdata(context, nullptr);
    if (is_used) return {};
    return has_password ? "it has a password; remove it: openssl pkey -in " + file + " -out NEW_FILE" : openssl_fault();
}

// Others refuse it: its key is for signing certificates only.
bool is_only_for_signing(SSL_CTX* context) {
    constexpr std::uint32_t of_connections = KU_DIGITAL_SIGNATURE | KU_KEY_ENCIPHERMENT | KU_KEY_AGREEMENT;
    return (::X509_get_key_usage(::SSL_CTX_get0_certificate(context)) & of_connections) == 0;
}

std::string use_files(SSL_CTX* context, const LinkCertificates& files) {
    if (!files.certificate.empty() && ::SSL_CTX_use_certificate_chain_file(context, files.certificate.c_str()) != 1)
        return files.certificate + ": " + openssl_fault();
    if (!files.certificate.empty() && is_only_for_signing(context))
        return files.certificate +
               ": is the certificate of an authority, which others refuse; use one made by 'anoctl certificate'";
    if (const std::string fault = use_key(context, files.key); !fault.empty()) return files.key + ": " + fault;
    if (!files.ca.empty() && ::SSL_CTX_load_verify_file(context, files.ca.c_str()) != 1) return files.ca + ": " + openssl_fault();
    if (files.ca.empty()) ::SSL_CTX_set_default_verify_paths(context);
    else if (!has_authority(context))
        return files.ca + ": is the certificate of a computer, not of an authority that signs certificates; 'ca' needs ca.pem";
    return {};
}

// Counts the bytes that OpenSSL reads from the socket.
// NOLINTNEXTLINE(readability-non-const-parameter): OpenSSL gives the signature
long note_read(BIO* bio, int what, const char* bytes, std::size_t, int, long, int result, std::size_t* size) {
    if (what == (BIO_CB_READ | BIO_CB_RETURN) && result > 0)
        reinterpret_cast<RecordEnds*>(::BIO_get_callback_arg(bio))->took({reinterpret_cast<const std::uint8_t*>(bytes), *size});
    return result;
}

}    // namespace

struct TlsConnection::Parts {
    UniqueFd socket{};    // a duplicate: a handshake in a thread may outlast the connection
    std::unique_ptr<SSL, void (*)(SSL*)> ssl{nullptr, ::SSL_free};
    std::vector<std::uint8_t> taken{};    // passed to OpenSSL but not sent yet: the next call must pass the same bytes
    std::string fault{};
    RecordEnds records{};     // of the handshake
    int steps = 0;            // of the handshake
    bool has_more = false;    // read() stopped before the socket was empty
};

TlsConnection::TlsConnection(std::unique_ptr<Parts> parts) : parts_{std::move(parts)} {}
TlsConnection::~TlsConnection() = default;

const std::string& TlsConnection::fault() const noexcept { return parts_->fault; }
bool TlsConnection::is_done() const noexcept { return ::SSL_is_init_finished(parts_->ssl.get()) == 1; }
bool TlsConnection::has_more() const noexcept { return parts_->has_more || ::SSL_pending(parts_->ssl.get()) > 0; }
std::size_t TlsConnection::unsent() const noexcept { return parts_->taken.size(); }

TlsConnection::Handshake TlsConnection::go_on() {
    if (++parts_->steps > max_handshake_steps) {
        parts_->fault = "the TLS handshake takes too many steps";
        errno = ECONNABORTED;
        return Handshake::failed;
    }
    ::ERR_clear_error();
    SSL* const ssl = parts_->ssl.get();
    const int result = ::SSL_do_handshake(ssl);
    if (result == 1) {
        ::BIO_set_callback_ex(::SSL_get_rbio(ssl), nullptr);
        return Handshake::done;
    }
    const int error = errno;
    switch (::SSL_get_error(ssl, result)) {
    case SSL_ERROR_WANT_READ: return Handshake::wants_to_read;
    case SSL_ERROR_WANT_WRITE: return Handshake::wants_to_write;
    case SSL_ERROR_SYSCALL:
    case SSL_ERROR_ZERO_RETURN:
        parts_->fault = "the other end closed the connection during the handshake";
        if (error != 0 && error != ECONNRESET && error != EPIPE) parts_->fault = error_text(error);
        break;
    default:
        const long verified = ::SSL_get_verify_result(ssl);
        const bool was_refused_by_us = verified != X509_V_OK;
        if (verified == X509_V_ERR_HOSTNAME_MISMATCH || verified == X509_V_ERR_IP_ADDRESS_MISMATCH)
            parts_->fault =
                "its certificate is for other names: connect to one of them, or create one for this name with "
                "'anoctl certificate NAME'";
        else
            parts_->fault = was_refused_by_us ? std::string{"its certificate: "} + ::X509_verify_cert_error_string(verified)
                                              : openssl_fault();
    }
    ::ERR_clear_error();
    errno = ECONNABORTED;
    return Handshake::failed;
}

// The kernel also reports the end of input as readable, and less than a record if it lacks memory.
bool TlsConnection::has_record() {
    const int fd = parts_->socket.get();
    std::array<std::uint8_t, RecordEnds::header_size> waiting{};
    const ssize_t seen = ::recv(fd, waiting.data(), waiting.size(), MSG_PEEK | MSG_DONTWAIT);
    int low_water = parts_->records.missing(std::span{waiting}.first(static_cast<std::size_t>(std::max<ssize_t>(seen, 0))));
    ::setsockopt(fd, SOL_SOCKET, SO_RCVLOWAT, &low_water, sizeof low_water);
    pollfd readable{fd, POLLIN, 0};
    const bool has = ::poll(&readable, 1, 0) != 0;
    low_water = 1;
    if (has) ::setsockopt(fd, SOL_SOCKET, SO_RCVLOWAT, &low_water, sizeof low_water);
    return has;
}

// Limits the number of records per call, because each may contain only one byte, or none: a flood of key updates would hold the
// loop.
ssize_t TlsConnection::read(std::span<std::uint8_t> room) {
    ::ERR_clear_error();
    std::size_t size = 0;
    int without_data = 0;
    parts_->has_more = true;
    for (int records = 0; size < room.size() && records < records_per_read; ++records) {
        std::size_t more = 0;
        const int result = ::SSL_read_ex(parts_->ssl.get(), room.data() + size, room.size() - size, &more);
        size += more;
        if (result == 1) continue;
        const int error = errno;
        const int what = ::SSL_get_error(parts_->ssl.get(), result);
        if (what == SSL_ERROR_WANT_READ && has_unread(parts_->socket.get())) {
            if (++without_data <= without_data_per_read) continue;
            parts_->fault = "too many TLS messages without data";
            errno = ECONNABORTED;
            return -1;
        }
        parts_->has_more = false;
        if (what == SSL_ERROR_SSL)
            parts_->fault = openssl_fault();    // an alert of the other end: it does not accept our certificate
        ::ERR_clear_error();
        if (size > 0) break;    // the next call reports the end
        if (what == SSL_ERROR_ZERO_RETURN) return 0;
        errno = what == SSL_ERROR_WANT_READ || what == SSL_ERROR_WANT_WRITE ? EAGAIN
                : what == SSL_ERROR_SYSCALL && error != 0                   ? error
                                                                            : ECONNRESET;
        return -1;
    }
    return static_cast<ssize_t>(size);
}

ssize_t TlsConnection::write(std::span<const iovec> pieces) {
    const auto send = [&] {
        std::vector<std::uint8_t>& taken = parts_->taken;
        ::ERR_clear_error();
        while (!taken.empty()) {
            std::size_t sent = 0;
            const int result = ::SSL_write_ex(parts_->ssl.get(), taken.data(), taken.size(), &sent);
            taken.erase(taken.begin(), taken.begin() + static_cast<std::ptrdiff_t>(sent));
            if (result == 1) continue;
            const int what = ::SSL_get_error(parts_->ssl.get(), result);
            ::ERR_clear_error();
            errno = what == SSL_ERROR_WANT_READ || what == SSL_ERROR_WANT_WRITE ? EAGAIN : EPIPE;
            return false;
        }
        return true;
    };
    if (!send()) return -1;
    for (const iovec& piece : pieces) {
        if (!parts_->taken.empty() && parts_->taken.size() + piece.iov_len > most_per_write) break;
        const auto* const begin = static_cast<const std::uint8_t*>(piece.iov_base);
        parts_->taken.insert(parts_->taken.end(), begin, begin + piece.iov_len);
    }
    const auto size = static_cast<ssize_t>(parts_->taken.size());
    if (!send() && errno != EAGAIN) return -1;
    return size;
}

struct TlsContext::Parts {
    Context context{nullptr, ::SSL_CTX_free};
};

TlsContext::TlsContext(std::unique_ptr<Parts> parts, Side side) : parts_{std::move(parts)}, side_{side} {}
TlsContext::~TlsContext() = default;

Opened<std::shared_ptr<const TlsContext>> TlsContext::read(const LinkCertificates& files, Side side) {
    auto parts = std::make_unique<Parts>();
    parts->context.reset(::SSL_CTX_new(side == Side::listens ? ::TLS_server_method() : ::TLS_client_method()));
    SSL_CTX* const context = parts->context.get();
    if (!context) return NotOpened{LinkError{"tls", openssl_fault(), {}}};
    ::SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
    ::SSL_CTX_set_options(context, SSL_OP_NO_COMPRESSION | SSL_OP_NO_RENEGOTIATION | SSL_OP_IGNORE_UNEXPECTED_EOF);
    ::SSL_CTX_clear_mode(context, SSL_MODE_AUTO_RETRY);    // SSL_read() returns after each record
    ::SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER | SSL_MODE_RELEASE_BUFFERS);
    const int verify = files.verify == TlsVerify::peer ? SSL_VERIFY_PEER | SSL_VERIFY_FAIL_IF_NO_PEER_CERT : SSL_VERIFY_NONE;
    ::SSL_CTX_set_verify(context, verify, nullptr);
    const std::array<unsigned char, 8> id{'a', 'n', 'o', 'g', 'a', 't', 'e', 0};
    ::SSL_CTX_set_session_id_context(context, id.data(), id.size());
    ::ERR_clear_error();
    std::string fault = fault_of_files(files);
    if (fault.empty()) fault = use_files(context, files);
    if (!fault.empty()) return NotOpened{LinkError{"tls", fault, {}}};
    return std::shared_ptr<const TlsContext>{new TlsContext{std::move(parts), side}};
}

Opened<std::shared_ptr<TlsConnection>> TlsContext::connection(int fd, const std::string& host) const {
    auto parts = std::make_unique<TlsConnection::Parts>();
    parts->socket = UniqueFd{::fcntl(fd, F_DUPFD_CLOEXEC, 0)};
    if (!parts->socket) return NotOpened{LinkError{error_text(errno)}};
    parts->ssl.reset(::SSL_new(parts_->context.get()));
    SSL* const ssl = parts->ssl.get();
    if (!ssl || ::SSL_set_fd(ssl, parts->socket.get()) != 1) return NotOpened{LinkError{"tls", openssl_fault(), {}}};
    ::BIO_set_callback_ex(::SSL_get_rbio(ssl), note_read);
    ::BIO_set_callback_arg(::SSL_get_rbio(ssl), reinterpret_cast<char*>(&parts->records));
    if (side_ == Side::listens) {
        ::SSL_set_accept_state(ssl);
    } else {
        ::SSL_set_connect_state(ssl);
        X509_VERIFY_PARAM* const wanted = ::SSL_get0_param(ssl);
        const bool is_address = !host.empty() && ::X509_VERIFY_PARAM_set1_ip_asc(wanted, host.c_str()) == 1;
        if (!host.empty() && !is_address) {
            std::string name = host.ends_with('.') ? host.substr(0, host.size() - 1) : host;
            ::SSL_ctrl(ssl, SSL_CTRL_SET_TLSEXT_HOSTNAME, TLSEXT_NAMETYPE_host_name, name.data());    // the macro has a C cast
            ::SSL_set1_host(ssl, name.c_str());
        }
        ::ERR_clear_error();
    }
    return std::make_shared<TlsConnection>(std::move(parts));
}

CertificateValidity TlsContext::validity() const { return validity_of(::SSL_CTX_get0_certificate(parts_->context.get())); }

}    // namespace anogate
