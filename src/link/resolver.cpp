#include <link/resolver.hpp>
#include <link/udp/ip_socket.hpp>
#include <sys/background_task.hpp>

#include <netdb.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

constexpr ano::Duration slow = std::chrono::seconds{1};

struct Answer {
    std::vector<IpAddress> addresses{};
    std::string fault{};
    ano::Duration took{};
};

// Runs in a thread.
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
        const IpAddress address = endpoint_of(storage).address;
        if (std::find(answer.addresses.begin(), answer.addresses.end(), address) == answer.addresses.end())
            answer.addresses.push_back(address);
    }
    return answer;
}

}    // namespace

LinkError no_such_host(const std::string& host, const std::string& fault) {
    return {"no_such_host", host + ": " + fault, {{"host", host}}};
}

struct Resolver::Query {
    explicit Query(asio::io_context& io) : worker{io} {}

    BackgroundTask worker;
    std::vector<IpAddress> addresses{};                 // the last answer with any: also used while the name is not found
    ano::TimePoint asked_at = ano::TimePoint::min();    // the last time
    ano::TimePoint wanted_at{};
    bool is_slow = false;    // the last time
    std::vector<std::pair<const void*, Done>> waiting{};
    std::vector<std::pair<const void*, Done>> called{};    // being called now

    // A call may cancel other requests, or make a new one.
    void complete(const std::string& fault) {
        const std::vector<IpAddress> found = addresses;
        called = std::exchange(waiting, {});
        for (auto& one : called)
            if (const Done call = std::exchange(one.second, nullptr)) call(found, fault);
        called.clear();
    }
};

Resolver::Resolver(asio::io_context& io, ano::Duration kept_for) : io_{io}, kept_for_{kept_for} {}

Resolver::~Resolver() { stop(); }

void Resolver::stop() noexcept {
    queue_.clear();
    for (auto& [host, query] : queries_) {
        query->waiting.clear();
        query->worker.stop(ano::TimePoint::min());
    }
}

void Resolver::resolve(const std::string& host, ano::TimePoint now, const void* asker, Done done) {
    auto& query = queries_[host];
    if (!query) query = std::make_unique<Query>(io_);
    const bool is_known = !query->addresses.empty() && now - query->asked_at < kept_for_;
    if (is_known) return done(query->addresses, {});
    query->waiting.emplace_back(asker, std::move(done));
    if (query->worker.is_running() || std::find(queue_.begin(), queue_.end(), host) != queue_.end()) return;
    query->wanted_at = now;
    queue_.push_back(host);
    look_up_next();
}

bool Resolver::has_place(const Query& query) const {
    int all = 0, slow_ones = 0;
    for (const auto& [host, one] : queries_) {
        if (!one->worker.is_running()) continue;
        ++all;
        slow_ones += one->is_slow ? 1 : 0;
    }
    return all < max_lookups && (!query.is_slow || slow_ones < max_slow);
}

void Resolver::look_up_next() {
    std::erase_if(queue_, [this](const std::string& host) { return queries_[host]->waiting.empty(); });
    for (;;) {
        const auto next = std::find_if(queue_.begin(), queue_.end(),
                                       [this](const std::string& host) { return has_place(*queries_[host]); });
        if (next == queue_.end()) return;
        const std::string host = *next;
        queue_.erase(next);
        look_up(host, *queries_[host]);
    }
}

void Resolver::look_up(const std::string& host, Query& query) {
    query.asked_at = query.wanted_at;
    const auto answer = std::make_shared<Answer>();
    const auto work = [host, answer] {
        const ano::TimePoint begin = ano::Clock::now();
        *answer = ask_system(host);
        answer->took = ano::Clock::now() - begin;
    };
    const bool runs = query.worker.run(work, [this, answer, &query](const std::string& broken) {
        if (!answer->addresses.empty()) query.addresses = answer->addresses;
        query.is_slow = answer->took > slow;
        query.complete(broken.empty() ? answer->fault : broken);
        look_up_next();
    });
    if (!runs) query.complete(std::string{query.worker.why_not()});
}

void Resolver::cancel(const void* asker) noexcept {
    for (auto& [host, query] : queries_) {
        std::erase_if(query->waiting, [&](const auto& one) { return one.first == asker; });
        for (auto& one : query->called)
            if (one.first == asker) one.second = nullptr;
    }
}

}    // namespace anogate
