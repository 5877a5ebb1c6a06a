// TLS handshakes of a listening port, until they are done. Many may wait and a few are computed at a time, so that a host can
// connect even if many strangers do.
#pragma once
#include <gateway/ip.hpp>
#include <link/link_context.hpp>
#include <link/refusals.hpp>
#include <link/tcp/certificate_reader.hpp>
#include <sys/alarm.hpp>
#include <sys/unique_fd.hpp>
#include <sys/waiting_places.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace anogate {

/// The party of a connection, see WaitingConnection.
std::uint64_t waiting_party(const IpAddress& address);

class Handshakes {
public:
    static constexpr std::size_t places = 256;     // about 10 KB each
    static constexpr std::size_t at_a_time = 2;    // computed in parallel, each in a thread
    using Done = std::function<void(UniqueFd, const Endpoint& peer, std::shared_ptr<TlsConnection>)>;
    using Failed = std::function<void(const std::string& why)>;

    Handshakes(const LinkContext& context, const CertificateReader& certificates, Done done, Failed failed);
    ~Handshakes();

    /// False: no place is free, because trusted peers hold all of them, or too few descriptors are left. A connection dropped to
    /// make room is counted.
    bool add(UniqueFd fd, const Endpoint& peer, bool is_trusted);
    void close();
    const Refusals& evicted() const noexcept { return evicted_; }

private:
    struct One;
    using Stage = WaitingConnection::Stage;

    bool make_place(bool is_trusted);
    static bool is_silent(const One& one);
    void end_those(Duration age, bool silent_alone, const std::string& why);
    void heard(One& one);
    void await(One& one);
    void run_turns();
    void begin(One& one);
    void finished_step(One& one, TlsConnection::Handshake outcome);
    void finish(One& one);
    void fail(One& one, const std::string& why);
    void remove(One& one);

    LinkContext context_;
    const CertificateReader& certificates_;
    Done done_;
    Failed failed_;
    std::vector<std::unique_ptr<One>> all_;      // in order of arrival
    std::vector<std::unique_ptr<One>> ended_;    // destroyed after their calls have returned
    std::size_t at_work_ = 0;
    Refusals evicted_;
    Alarm turns_, patience_, sweep_;
};

}    // namespace anogate
