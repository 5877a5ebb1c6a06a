// A connection to one listening peer: a Wi-Fi bridge, ser2net, a program on another computer. Encrypted or not.
#pragma once
#include <link/reconnect.hpp>
#include <link/tcp/certificate_reader.hpp>
#include <link/tcp/connector.hpp>
#include <link/tcp/tcp_session.hpp>
#include <link/tcp/tcp_settings.hpp>

#include <string>

namespace anogate {

class TcpLink : public Link, public RawPort, public KernelQueue, protected TcpSession {
public:
    TcpLink(LinkId id, LinkSettings settings, const LinkContext& context);

    void start() override;
    void stop_reading() override;
    void stop() override;
    void flush(Channel&) override { write(); }
    std::size_t unsent() const override;
    LinkFacts facts() const override;
    LinkError trouble() const override;
    void set_tap(RawTap* tap) override { StreamSession::set_tap(tap); }
    bool write_raw(std::span<const std::uint8_t> bytes) override { return StreamSession::write_raw(bytes); }

private:
    void connect();
    void connected(UniqueFd fd, const Endpoint& peer);
    void opened() override;
    void acknowledges_nothing() override { context_.host.report_unreachable(*this); }
    void read_ended(int error) override;
    void failed(int error) override { read_ended(error); }
    void fail(LinkError why);

    Channel* channel_ = nullptr;
    std::string connected_to_;                           // the address; empty: none
    std::unique_ptr<CertificateReader> certificates_;    // nullptr: not encrypted
    Connector connector_;
    Reconnect reconnect_;
};

}    // namespace anogate
