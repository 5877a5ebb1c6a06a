#include <http/request.hpp>
#include <http/tls.hpp>

#include <http/asio_ssl.hpp>
#include <sys/errors.hpp>

#include <cerrno>
#include <utility>
#include <vector>

#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

namespace anogate::http {

struct Tls::Context {
    asio::ssl::context ssl{asio::ssl::context::tls_server};
};

namespace {

/// Shared by running operations, which may outlive the stream.
struct Encrypted : std::enable_shared_from_this<Encrypted> {
    Encrypted(Socket connected, asio::ssl::context& context) : ssl{std::move(connected), context} {}

    /// Calls `then` once the handshake is done; several calls wait for the same handshake.
    void shake_hands(std::function<void(error_code)> then) {
        if (is_ready) return then({});
        waiting.push_back(std::move(then));
        if (waiting.size() > 1) return;
        ssl.async_handshake(asio::ssl::stream_base::server, [self = shared_from_this()](error_code ec) {
            self->is_ready = !ec;
            for (const auto& next : std::exchange(self->waiting, {})) next(ec);
        });
    }

    asio::ssl::stream<Socket> ssl;
    bool is_ready = false;
    std::vector<std::function<void(error_code)>> waiting;
};

class TlsStream final : public Stream {
public:
    TlsStream(Socket socket, asio::ssl::context& context, std::shared_ptr<const void> keep, ConnectionInfo connection_info)
        : keep_{std::move(keep)},
          state_{std::make_shared<Encrypted>(std::move(socket), context)},
          connection_info_{std::move(connection_info)} {}

    bool has_left() const override {
        pollfd look{state_->ssl.lowest_layer().native_handle(), POLLRDHUP, 0};
        return ::poll(&look, 1, 0) == 1;
    }
    void read_some(asio::mutable_buffer into, Done done) override {
        state_->shake_hands([state = state_, into, done = std::move(done)](error_code ec) mutable {
            if (ec) return done(ec, 0);
            state->ssl.async_read_some(
                into, [state, done = std::move(done)](error_code failed, std::size_t size) { done(ended(failed), size); });
        });
    }
    void write_some(const Parts& from, Done done) override {
        state_->shake_hands([state = state_, from, done = std::move(done)](error_code ec) mutable {
            if (ec) return done(ec, 0);
            state->ssl.async_write_some(
                from, [state, done = std::move(done)](error_code failed, std::size_t size) { done(failed, size); });
        });
    }
    void cancel() override {
        error_code ignored;
        state_->ssl.lowest_layer().cancel(ignored);
    }
    // Without TLS close_notify: every response has a length or a last chunk, so the client does not depend on it.
    void end_output() override {
        error_code ignored;
        state_->ssl.lowest_layer().shutdown(Socket::shutdown_send, ignored);
    }
    void close() override {
        error_code ignored;
        state_->ssl.lowest_layer().close(ignored);
    }
    std::uint32_t user() const override { return unknown_user; }
    const ConnectionInfo& connection_info() const override { return connection_info_; }

private:
    /// Many clients close the connection without close_notify: that counts as the end of the input.
    static error_code ended(error_code ec) { return ec == asio::ssl::error::stream_truncated ? asio::error::eof : ec; }

    std::shared_ptr<const void> keep_;
    std::shared_ptr<Encrypted> state_;
    ConnectionInfo connection_info_;
};

// Checked here since OpenSSL does not report why a file can't be read, and blocks on a pipe.
std::string fault_of_file(const std::string& file) {
    struct stat facts {};
    if (::access(file.c_str(), R_OK) != 0 || ::stat(file.c_str(), &facts) != 0) return error_text(file, errno);
    return S_ISREG(facts.st_mode) ? "" : file + ": is not a file";
}

std::string fault_of_secret(const std::string& file) {
    struct stat facts {};
    if (::stat(file.c_str(), &facts) != 0) return error_text(file, errno);
    return (facts.st_mode & S_IRWXO) == 0 ? "" : file + ": every user of this computer can read it; run chmod o= " + file;
}

}    // namespace

Tls::Tls(std::shared_ptr<Context> context) : context_{std::move(context)} {}
Tls::~Tls() = default;

Expected<std::unique_ptr<Tls>> Tls::load(const std::string& certificate, const std::string& key) {
    auto context = std::make_shared<Context>();
    // Not set by Asio, whose options are of type long: it is too small on 32 bits, and sign extension would set all bits from
    // 2^32 up.
    ::SSL_CTX_set_options(context->ssl.native_handle(),
                          SSL_OP_ALL | SSL_OP_NO_TLSv1 | SSL_OP_NO_TLSv1_1 | SSL_OP_NO_COMPRESSION | SSL_OP_NO_RENEGOTIATION);
    for (const std::string& file : {certificate, key})
        if (std::string fault = fault_of_file(file); !fault.empty()) return Unexpected{std::move(fault)};
    if (std::string fault = fault_of_secret(key); !fault.empty()) return Unexpected{std::move(fault)};
    context->ssl.set_password_callback(
        [](std::size_t, asio::ssl::context::password_purpose) { return std::string{}; });    // never asks at the terminal
    error_code ec;
    context->ssl.use_certificate_chain_file(certificate, ec);
    if (ec) return Unexpected{certificate + ": " + ec.message()};
    context->ssl.use_private_key_file(key, asio::ssl::context::pem, ec);
    if (ec) return Unexpected{key + ": " + ec.message()};
    return std::unique_ptr<Tls>{new Tls{std::move(context)}};
}

std::string Tls::advice() const {
    constexpr int usual_bits = 2048;
    const EVP_PKEY* const key = ::SSL_CTX_get0_privatekey(context_->ssl.native_handle());
    const int bits = key ? ::EVP_PKEY_get_bits(key) : 0;
    if (!key || ::EVP_PKEY_get_base_id(key) != EVP_PKEY_RSA || bits <= usual_bits) return {};
    return "an RSA key of " + std::to_string(bits) +
           " bits slows down every new connection: create a certificate with a fast key (ECDSA) with anoctl "
           "certificate";
}

CertificateValidity Tls::validity() const { return validity_of(::SSL_CTX_get0_certificate(context_->ssl.native_handle())); }

std::unique_ptr<Stream> Tls::stream(Socket socket, ConnectionInfo connection_info) const {
    return std::make_unique<TlsStream>(std::move(socket), context_->ssl, context_, std::move(connection_info));
}

}    // namespace anogate::http
