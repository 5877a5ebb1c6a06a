// A listening TCP port, encrypted or not: each connection is a peer with its own channel.
#pragma once
#include <gateway/peers/connection_places.hpp>
#include <link/own_networks.hpp>
#include <link/reconnect.hpp>
#include <link/tcp/tcp_settings.hpp>
#include <link/tcp/tls_context.hpp>
#include <sys/descriptor.hpp>

#include <memory>
#include <string>
#include <vector>

namespace anogate {

class TcpListenLink : public Link {
public:
    TcpListenLink(LinkId id, LinkSettings settings, const LinkContext& context);
    ~TcpListenLink() override;

    void start() override { reconnect_.start(); }
    void stop_reading() override;
    void stop() override;
    void flush(Channel& channel) override;
    void forget_peer(ChannelId channel) override;
    std::size_t unsent() const override;
    LinkFacts facts() const override;
    LinkError trouble() const override;
    UnassignedTraffic unassigned_traffic() const override;

private:
    class Connection;

    Opened<void> open();
    void look_at_files();
    void accept();
    bool handshakes_are_many() const;
    bool handshakes_are_many_of(const IpAddress& address) const;
    void refuse_place(TimePoint now);
    void accept_on();
    void admit(UniqueFd fd, const Endpoint& peer);
    bool make_place(const IpAddress& address, TimePoint now);
    bool is_allowed(const IpAddress& address, TimePoint now);
    bool has_rival(const Connection& from, std::uint8_t source);
    void end(Connection& connection);
    void end(ChannelId channel);

    LinkContext context_;
    Descriptor listener_;
    Reconnect reconnect_;
    ConnectionPlaces places_;
    OwnNetworks networks_;
    Endpoint local_;
    std::vector<std::unique_ptr<Connection>> connections_;
    std::vector<std::unique_ptr<Connection>> ended_;    // destroyed when no call of theirs runs
    Alarm sweep_;
    Alarm accept_again_;                 // while there is no descriptor or memory for another connection
    std::unique_ptr<TlsContext> tls_;    // nullptr: not encrypted
    Alarm look_at_files_;
    bool is_ending_ = false;
    std::string last_fault_;    // of a handshake that failed
    TimePoint no_place_at_{}, failed_at_{};
    std::uint64_t no_place_ = 0, no_memory_ = 0, outsiders_ = 0, handshakes_failed_ = 0;
};

}    // namespace anogate
