// A TCP connection as a stream of frames, encrypted or not.
#pragma once
#include <link/stream_session.hpp>
#include <link/tcp/in_flight_limit.hpp>
#include <link/tcp/tls_context.hpp>
#include <sys/background_task.hpp>

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

    /// To be called before each open(); nullptr: not encrypted.
    void encrypt_by(std::shared_ptr<TlsConnection> tls);
    void close() noexcept override;
    /// The reason why the handshake failed or the other end closed the encrypted connection; empty: neither.
    std::string tls_fault() const;

protected:
    Opening go_on_opening() override;
    ssize_t read_some(std::span<std::uint8_t> room) override;
    /// Keeps the unsent bytes in the kernel below about 2 KiB, and the bytes in flight within InFlightLimit, so that urgent
    /// frames pass the others in our queue. The socket option for the first (TCP_NOTSENT_LOWAT) only delays the event for
    /// writing: the kernel still accepts a write beyond the limit.
    ssize_t write_some(std::span<const iovec> pieces) override;
    void write_later() override;
    bool holds_bytes() const override { return tls_ && tls_->unsent() > 0; }
    /// Bytes that the other end has not acknowledged.
    std::size_t not_acknowledged() const;
    /// The time since when data waits without any acknowledgement; zero: none waits. Answers to the probes of a closed window
    /// acknowledge nothing.
    std::chrono::milliseconds not_acknowledged_for() const;

private:
    bool begin_step();
    bool waits_for_acknowledgement();

    std::shared_ptr<TlsConnection> tls_;                   // shared with the thread that computes its handshake
    BackgroundTask step_;                                  // of the handshake: takes milliseconds of computing
    std::optional<TlsConnection::Handshake> handshake_;    // result of the last step
    bool needs_record_ = false;                            // a complete record, before the next step
    bool is_late_ = false;                                 // the handshake took too long
    Alarm handshake_ends_, read_on_, write_on_;
    InFlightLimit in_flight_limit_;
    mutable std::size_t outstanding_ = 0;    // bytes, as last seen
    mutable TimePoint outstanding_since_{};
};

}    // namespace anogate
