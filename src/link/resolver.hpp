// Finds the addresses of host names, in threads: the system may take seconds for an answer.
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

/// One for the whole program. A name is asked for once at a time, however many wait for it.
class Resolver {
public:
    /// Without addresses, `fault` says why: "Name or service not known".
    using Done = std::function<void(const std::vector<IpAddress>& addresses, const std::string& fault)>;

    explicit Resolver(asio::io_context& io, ano::Duration kept_for = std::chrono::seconds{60});
    ~Resolver();
    Resolver(const Resolver&) = delete;
    Resolver& operator=(const Resolver&) = delete;

    /// How long an answer counts.
    ano::Duration kept_for() const noexcept { return kept_for_; }
    /// Calls `done` from the loop, or at once when the answer is known or nothing can be asked. `asker` is the caller.
    void resolve(const std::string& host, ano::TimePoint now, const void* asker, Done done);
    /// Nothing is called any more of what `asker` asked.
    void cancel(const void* asker) noexcept;

    /// Nothing is called any more. Threads that still wait for an answer are left behind: they may take a minute.
    void stop() noexcept;

private:
    struct Query;

    asio::io_context& io_;
    ano::Duration kept_for_;
    std::map<std::string, std::unique_ptr<Query>> queries_;
};

}    // namespace anogate
