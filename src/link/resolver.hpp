// Finds the addresses of host names, in threads: the system call may block for seconds.
#pragma once
#include <ano/time.hpp>
#include <gateway/ip.hpp>
#include <link/link_error.hpp>
#include <sys/asio_fwd.hpp>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace anogate {

/// The error of a link whose host has no address; `fault` as of Resolver::Done.
LinkError no_such_host(const std::string& host, const std::string& fault);

/// One for the whole program. Simultaneous requests for the same name share one look-up. At most `max_lookups` run at a time;
/// those of names that took more than a second the last time may use only `max_slow` of these places, so that a name server that
/// does not answer delays no other name for long.
class Resolver {
public:
    /// Without addresses, `fault` is the reason: "Name or service not known".
    using Done = std::function<void(const std::vector<IpAddress>& addresses, const std::string& fault)>;

    static constexpr int max_lookups = 16, max_slow = 12;    // each a thread

    explicit Resolver(asio::io_context& io, ano::Duration kept_for = std::chrono::seconds{60});
    ~Resolver();
    Resolver(const Resolver&) = delete;
    Resolver& operator=(const Resolver&) = delete;

    /// How long an answer is valid.
    ano::Duration kept_for() const noexcept { return kept_for_; }
    /// Calls `done` from the loop, or at once if the answer is known or no look-up is possible. `asker` identifies the caller.
    /// While a name is not found, because its name server does not answer for example, its last addresses are valid.
    void resolve(const std::string& host, ano::TimePoint now, const void* asker, Done done);
    /// Cancels the requests of `asker`: their `done` is not called.
    void cancel(const void* asker) noexcept;

    /// Cancels all requests. Does not wait for threads in a look-up, which may take a minute.
    void stop() noexcept;

private:
    struct Query;
    bool has_place(const Query& query) const;
    void look_up_next();
    void look_up(const std::string& host, Query& query);

    asio::io_context& io_;
    ano::Duration kept_for_;
    std::map<std::string, std::unique_ptr<Query>> queries_;
    std::vector<std::string> queue_;    // names that wait for a place, in the order of their requests
};

}    // namespace anogate
