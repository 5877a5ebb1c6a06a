// Connects to a host by TCP: resolves its name, and tries all its addresses.
#pragma once
#include <gateway/host_spec.hpp>
#include <link/link_context.hpp>
#include <link/link_error.hpp>
#include <sys/alarm.hpp>
#include <sys/descriptor.hpp>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace anogate {

/// Flow:    start() → connected(fd, peer) or failed(why), once    // from the loop; may be called within start()
///          stop()                                               // neither is called
class Connector {
public:
    /// The next address is tried after this time, or at once if a previous one fails. The first connection is used.
    static constexpr ano::Duration between_tries = std::chrono::milliseconds{250};
    /// After this number of tries that fail at once, others in the loop have their turn: a name may have thousands of addresses.
    static constexpr int failures_at_once = 8;
    static constexpr ano::Duration after_failures = std::chrono::milliseconds{20};
    /// A try that is not answered ends after this time.
    static constexpr ano::Duration patience = std::chrono::seconds{10};

    using Connected = std::function<void(UniqueFd fd, const Endpoint& peer)>;
    using Failed = std::function<void(LinkError why)>;
    Connector(const LinkContext& context, HostSpec to, ano::Duration dead_after, Connected connected, Failed failed);
    ~Connector();
    Connector(const Connector&) = delete;
    Connector& operator=(const Connector&) = delete;

    void start();
    void stop() noexcept;

private:
    struct Try;

    void resolved(const std::vector<IpAddress>& addresses, const std::string& fault);
    void go_on();
    bool begin_next();
    void end_unanswered();
    void has_ended(Try& attempt);
    void end(Try& attempt, LinkError why);
    void fail(LinkError why);

    LinkContext context_;
    HostSpec to_;
    ano::Duration dead_after_;
    Connected connected_;
    Failed failed_;
    std::vector<Endpoint> endpoints_;
    std::vector<std::unique_ptr<Try>> tries_;    // those that were begun, in the order of endpoints_
    std::size_t ended_ = 0;                      // number of tries that have failed
    LinkError why_;                              // of the last failed try
    Alarm next_;
};

}    // namespace anogate
