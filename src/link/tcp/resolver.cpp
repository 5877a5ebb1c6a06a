#include <link/tcp/resolver.hpp>
#include <link/udp/ip_socket.hpp>
#include <sys/errand.hpp>

#include <netdb.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

struct Answer {
    std::vector<IpAddress> addresses{};
    std::string fault{};
};

// In a thread.
Answer ask_system(const std::string& host) {
    addrinfo wanted{};
    wanted.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (const int error = ::getaddrinfo(host.c_str(), nullptr, &wanted, &found); error != 0) return {{}, ::gai_strerror(error)};
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> all{found, ::freeaddrinfo};
    Answer answer;
    for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
        sockaddr_storage storage{};
        std::copy_n(reinterpret_cast<const char*>(one->ai_addr), std::min<std::size_t>(one->ai_addrlen, sizeof storage),
                    reinterpret_cast<char*>(&storage));
        answer.addresses.push_back(endpoint_of(storage).address);
    }
    return answer;
}

}    // namespace

struct Resolver::Query {
    explicit Query(asio::io_context& io) : errand{io} {}

    Errand errand;
    std::vector<IpAddress> addresses{};    // the last answer
    ano::TimePoint asked_at = ano::TimePoint::min();
    std::vector<std::pair<const void*, Done>> waiting{};
};

Resolver::Resolver(asio::io_context& io) : io_{io} {}

// One patience for all threads that still wait for an answer.
Resolver::~Resolver() {
    const ano::TimePoint by = ano::Clock::now() + Errand::patience_at_the_end;
    for (auto& [host, query] : queries_) query->errand.stop(by);
}

void Resolver::resolve(const std::string& host, ano::TimePoint now, const void* asker, Done done) {
    auto& query = queries_[host];
    if (!query) query = std::make_unique<Query>(io_);
    const bool is_known = !query->addresses.empty() && now - query->asked_at < kept_for;
    if (is_known) return done(query->addresses, {});
    query->waiting.emplace_back(asker, std::move(done));
    if (query->errand.is_running()) return;
    query->asked_at = now;
    const auto answer = std::make_shared<Answer>();
    const auto work = [host, answer] { *answer = ask_system(host); };
    const bool runs = query->errand.run(work, [this, host, answer](const std::string& broken) {
        Query& mine = *queries_[host];
        mine.addresses = answer->addresses;
        const std::string fault = broken.empty() ? answer->fault : broken;
        for (auto& [who, call] : std::exchange(mine.waiting, {})) call(answer->addresses, fault);
    });
    if (runs) return;
    for (auto& [who, call] : std::exchange(query->waiting, {})) call({}, std::string{query->errand.why_not()});
}

void Resolver::cancel(const void* asker) noexcept {
    for (auto& [host, query] : queries_) std::erase_if(query->waiting, [&](const auto& one) { return one.first == asker; });
}

}    // namespace anogate
