// A listening TCP port, encrypted or not. A connection becomes a peer with its own channel at once, or when it has sent a
// valid frame if there is little room.
#pragma once
#include <gateway/peers/peer_book.hpp>
#include <gateway/v7_translation.hpp>
#include <link/own_networks.hpp>
#include <link/reconnect.hpp>
#include <link/refusals.hpp>
#include <link/tcp/certificate_reader.hpp>
#include <link/tcp/clients_without_frame.hpp>
#include <link/tcp/handshakes.hpp>
#include <link/tcp/tcp_settings.hpp>
#include <sys/descriptor.hpp>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

class TcpListenLink : public Link, public PeerPlaces, public UnassignedReceiver, public KernelQueue {
public:
    TcpListenLink(LinkId id, LinkSettings settings, const LinkContext& context);
    ~TcpListenLink() override;

    void start() override { reconnect_.start(); }
    void stop_reading() override;
    void stop() override;
    void flush(Channel& channel) override;
    void forget_peer(ChannelId channel) override;
    std::optional<ChannelId> peer_to_replace(PeerBook::Rank to, TimePoint now) const override {
        return book_.longest_silent(to, now);
    }
    std::size_t unsent() const override;
    std::optional<std::chrono::milliseconds> unacknowledged_for(ChannelId channel) const override;
    LinkFacts facts() const override;
    LinkError trouble() const override;
    UnassignedTraffic unassigned_traffic() const override;

private:
    class Connection;
    Opened<void> open();
    Opened<void> listen();
    void accept();
    void accept_on();
    void pause_accepting();
    void on_accepted(UniqueFd fd, const Endpoint& peer);
    /// After the handshake, if it is encrypted. While there is little room, the connection waits for its first frame.
    void await_frame(UniqueFd fd, const Endpoint& peer, std::shared_ptr<TlsConnection> encrypted);
    void admit_silent();
    bool has_room_for_silent(const Endpoint& peer, TimePoint now);
    /// Opens a channel for the connection. False: there is no place.
    bool admit(int fd, const ClientsWithoutFrame::Sender& sender);
    bool is_trusted(const IpAddress& address) const;
    PeerBook::Rank rank_of(const ClientsWithoutFrame::Sender& sender) const;
    bool make_place(const ClientsWithoutFrame::Sender& sender, PeerBook::Rank rank, TimePoint now);
    Connection* former_of(const ClientsWithoutFrame::Sender& sender, PeerBook::Rank rank, TimePoint now);
    void begin(int fd, const ClientsWithoutFrame::Sender& sender, Channel& channel);
    Connection* connection_of(ChannelId channel) const;
    bool is_allowed(const IpAddress& address, TimePoint now);
    bool has_rival(const Connection& from, std::uint8_t source);
    /// `why` is for the log.
    void end(Connection& connection, const std::string& why);

    LinkContext context_;
    Descriptor listener_;
    Reconnect reconnect_;
    PeerBook book_;
    ClientsWithoutFrame clients_without_frame_;
    OwnNetworks networks_;
    Endpoint local_;
    std::vector<std::unique_ptr<Connection>> connections_;
    std::vector<std::unique_ptr<Connection>> ended_;    // destroyed after their calls have returned
    Alarm sweep_;
    Alarm accept_again_;                                 // after a lack of descriptors or memory
    Alarm silent_again_;                                 // while connections wait for their first frame
    std::unique_ptr<CertificateReader> certificates_;    // nullptr: not encrypted
    std::optional<Handshakes> handshakes_;               // if encrypted
    bool is_ending_ = false;
    std::string last_fault_;    // of a failed handshake
    Refusals no_place_, no_channel_, no_memory_, failed_handshakes_;
    std::uint64_t outsiders_ = 0;
    V7Counters v7_of_ended_{};    // of the connections that ended
};

}    // namespace anogate
