// A listening TCP port, encrypted or not: each connection is a peer with its own channel.
#pragma once
#include <gateway/peers/connection_places.hpp>
#include <gateway/v7_translation.hpp>
#include <link/own_networks.hpp>
#include <link/reconnect.hpp>
#include <link/tcp/handshakes.hpp>
#include <link/tcp/tcp_settings.hpp>
#include <link/tcp/tls_context.hpp>
#include <sys/descriptor.hpp>

#include <memory>
#include <optional>
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
    void accept();
    void accept_on();
    void on_accepted(UniqueFd fd, const Endpoint& peer);
    /// Opens a channel for the connection, after its handshake if it is encrypted.
    void admit(UniqueFd fd, const Endpoint& peer, std::shared_ptr<TlsConnection> encrypted);
    bool is_trusted(const IpAddress& address) const;
    bool make_place(const IpAddress& address, TimePoint now);
    bool is_allowed(const IpAddress& address, TimePoint now);
    bool has_rival(const Connection& from, std::uint8_t source);
    /// `why` is for the log.
    void end(Connection& connection, const std::string& why);

    LinkContext context_;
    Descriptor listener_;
    Reconnect reconnect_;
    ConnectionPlaces places_;
    OwnNetworks networks_;
    Endpoint local_;
    std::vector<std::unique_ptr<Connection>> connections_;
    std::vector<std::unique_ptr<Connection>> ended_;    // destroyed after their calls have returned
    Alarm sweep_;
    Alarm accept_again_;                      // after a lack of descriptors or memory
    std::unique_ptr<TlsContext> tls_;         // nullptr: not encrypted
    std::optional<Handshakes> handshakes_;    // if encrypted
    bool is_ending_ = false;
    std::string last_fault_;    // of a failed handshake
    Refusals no_place_, no_memory_, failed_handshakes_;
    std::uint64_t outsiders_ = 0;
    V7Counters v7_of_ended_{};    // of the connections that ended
};

}    // namespace anogate
