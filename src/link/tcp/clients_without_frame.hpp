// Connections of a listening port that wait for their first valid frame, or for room. They have no channel, so that many silent ones
// leave the channels of the gateway to others.
#pragma once
#include <ano/parser.hpp>
#include <gateway/counters.hpp>
#include <gateway/ip.hpp>
#include <link/link_context.hpp>
#include <link/refusals.hpp>
#include <link/tcp/tls_context.hpp>
#include <link/v7_settings.hpp>
#include <sys/alarm.hpp>
#include <sys/unique_fd.hpp>
#include <sys/waiting_places.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace anogate {

class ClientsWithoutFrame {
public:
    static constexpr std::size_t places = 256;
    /// A sender without a place tries again with a later frame, and its connection is closed after this time.
    static constexpr Duration patience = std::chrono::seconds{10};

    struct Options {
        ano::FrameParser::Options parser{};
        V7LinkSettings v7{};    // if they are on, the frames are those of the previous protocol version
    };
    struct Sender {
        Endpoint peer{};
        std::shared_ptr<TlsConnection> tls{};    // nullptr: not encrypted
        std::optional<std::uint8_t> source{};    // of its frame, in V8; std::nullopt: it has sent none
        bool commands = false;                   // its frame is a command of a host
        std::vector<std::uint8_t> bytes{};       // its frame, and what follows
    };
    /// Opens a channel for the connection, with a duplicate of `fd`. False: there is no place.
    using Admit = std::function<bool(int fd, const Sender& sender)>;

    ClientsWithoutFrame(const LinkContext& context, const Options& options, Admit admit);
    ~ClientsWithoutFrame();

    /// False: no place is free, because trusted peers hold all of them, or too few descriptors are left.
    bool add(UniqueFd fd, const Endpoint& peer, std::shared_ptr<TlsConnection> tls, bool is_trusted);
    /// Admits connections that have sent nothing, the oldest first, as long as `has_room` for the peer of each.
    void admit_silent(const std::function<bool(const Endpoint& peer)>& has_room);
    void stop_reading();
    void close();

    std::size_t size() const noexcept { return all_.size(); }
    /// Connections that were closed to make room for others.
    const Refusals& evicted() const noexcept { return evicted_; }
    /// Everything that was received and is not passed on.
    ReceiveCounters received() const;
    std::uint64_t v7_frames() const;
    /// The parser of the newest connection; nullptr: none.
    const ano::FrameParser* parser() const noexcept;

private:
    struct One;

    bool make_place(bool is_trusted);
    void read(One& one);
    void expire(One& one);
    bool pass_on(One& one);
    bool try_to_admit(One& one, Sender sender, std::span<const std::uint8_t> frame, std::span<const std::uint8_t> rest);
    void remove(One& one);

    LinkContext context_;
    Options options_;
    Admit admit_;
    std::vector<std::unique_ptr<One>> all_;      // in order of arrival
    std::vector<std::unique_ptr<One>> ended_;    // destroyed after their calls have returned
    Refusals evicted_;
    ReceiveCounters gone_;    // of those that ended or were passed on, and refused frames
    std::uint64_t gone_v7_ = 0;
    Alarm sweep_;
};

}    // namespace anogate
