// Finds the addresses of host names, in threads: the system may take seconds for an answer.
#pragma once
#include <ano/time.hpp>
#include <gateway/ip.hpp>
#include <sys/asio_fwd.hpp>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace anogate {

/// One for the whole program. Answers are kept for 60 s; a name is asked for once at a time, however many wait for it.
class Resolver {
public:
    static constexpr ano::Duration kept_for = std::chrono::seconds{60};

    /// Without addresses, `fault` says why: "Name or service not known".
    using Done = std::function<void(const std::vector<IpAddress>& addresses, const std::string& fault)>;

    explicit Resolver(asio::io_context& io);
    ~Resolver();
    Resolver(const Resolver&) = delete;
    Resolver& operator=(const Resolver&) = delete;

    /// Calls `done` from the loop, or at once when the answer is known. `asker` is the caller: each waits for one name at a time.
    void resolve(const std::string& host, ano::TimePoint now, const void* asker, Done done);
    /// `done` is not called any more.
    void cancel(const void* asker) noexcept;

private:
    struct Query;

    asio::io_context& io_;
    std::map<std::string, std::unique_ptr<Query>> queries_;
};

}    // namespace anogate
