// A TCP connection as a stream of frames, encrypted or not.
#pragma once
#include <link/stream_session.hpp>
#include <link/tcp/in_flight_limit.hpp>
#include <link/tcp/tls_context.hpp>
#include <link/tcp/unacknowledged_data.hpp>
#include <sys/background_task.hpp>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

class TcpSession : public StreamSession {
public:
    static constexpr Duration handshake_patience = std::chrono::seconds{10};

    /// `dead_after`: of the connection, see set_tcp_options().
    TcpSession(const LinkContext& context, const LinkSettings& link, Duration dead_after);
    ~TcpSession() override;

    /// To be called before each open(); nullptr: not encrypted.
    void encrypt_by(std::shared_ptr<TlsConnection> tls);
    void close() noexcept override;
    /// The reason why the handshake failed or the other end closed the encrypted connection; empty: neither.
    std::string tls_fault() const;

protected:
    /// Data waits for an acknowledgement for much longer than the path needs: another link of the group should be used.
    virtual void acknowledges_nothing() = 0;
    /// For how long the other end was silent when the connection failed with ETIMEDOUT.
    Duration silent_for() const noexcept { return gave_up_after_.value_or(dead_after_); }

    Opening go_on_opening() override;
    ssize_t read_some(std::span<std::uint8_t> room) override;
    /// Keeps the unsent bytes in the kernel below about 2 KiB, and the bytes in flight within InFlightLimit, so that urgent
    /// frames pass the others in our queue. Writes nothing while acknowledgements are late, so that frames expire there. The
    /// socket option for the first (TCP_NOTSENT_LOWAT) only delays the event for
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
    void give_up_if_silent();
    Duration patience(Duration age);
    Duration between_looks();
    bool is_interrupted();

    Duration dead_after_, max_age_;    // max_age_: of frames in the kernel
    std::optional<Duration> gave_up_after_;
    std::shared_ptr<TlsConnection> tls_;                   // shared with the thread that computes its handshake
    BackgroundTask step_;                                  // of the handshake: takes milliseconds of computing
    std::optional<TlsConnection::Handshake> handshake_;    // result of the last step
    bool needs_record_ = false;                            // a complete record, before the next step
    bool is_late_ = false;                                 // the handshake took too long
    Alarm handshake_ends_, read_on_, write_on_, give_up_;
    InFlightLimit in_flight_limit_;
    mutable UnacknowledgedData unacknowledged_;
};

}    // namespace anogate
