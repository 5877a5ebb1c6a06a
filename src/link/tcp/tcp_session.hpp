// A TCP connection as a stream of frames, encrypted or not.
#pragma once
#include <link/stream_session.hpp>
#include <link/tcp/in_flight_limit.hpp>
#include <link/tcp/tls_context.hpp>
#include <sys/errand.hpp>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

class TcpSession : public StreamSession {
public:
    static constexpr Duration handshake_patience = std::chrono::seconds{10};

    explicit TcpSession(const LinkContext& context);
    ~TcpSession() override;

    /// To be called before each open(): how it is encrypted; nullptr: it is not.
    void encrypt_by(std::shared_ptr<TlsConnection> tls);
    void close() noexcept override;
    /// Why the handshake failed, or the other end ended it all; empty: neither.
    std::string tls_fault() const;

protected:
    Opening go_on_opening() override;
    ssize_t read_some(std::span<std::uint8_t> room) override;
    /// Keeps what the kernel has not sent below about 2 KiB, and what is on the way within InFlightLimit, so that urgent frames pass the
    /// others in our queue. The socket option for the first (TCP_NOTSENT_LOWAT) delays only the event that it can be written: a write
    /// beyond it is still taken.
    ssize_t write_some(std::span<const iovec> pieces) override;
    void write_later() override;
    bool holds_bytes() const override { return tls_ && tls_->unsent() > 0; }
    /// Bytes that the other end has not acknowledged.
    std::size_t not_acknowledged() const;
    /// For how long data waits of which nothing was acknowledged meanwhile; zero: none waits. Answers to the probes of a closed window
    /// acknowledge nothing.
    std::chrono::milliseconds not_acknowledged_for() const;

private:
    bool begin_step();
    bool waits_for_acknowledgement();

    std::shared_ptr<TlsConnection> tls_;                   // with the thread that works at its handshake
    Errand step_;                                          // of the handshake: milliseconds of computing
    std::optional<TlsConnection::Handshake> handshake_;    // what the last step came to
    bool wants_record_ = false;                            // before the next step
    bool is_late_ = false;                                 // the handshake took too long
    Alarm handshake_ends_, read_on_, write_on_;
    InFlightLimit in_flight_limit_;
    mutable std::size_t outstanding_ = 0;    // bytes, as last seen
    mutable TimePoint outstanding_since_{};
};

}    // namespace anogate
