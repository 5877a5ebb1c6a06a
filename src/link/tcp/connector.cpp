#include <link/resolver.hpp>
#include <link/tcp/connector.hpp>
#include <link/tcp/tcp_socket.hpp>
#include <link/udp/ip_socket.hpp>
#include <sys/errors.hpp>

#include <fcntl.h>

#include <cerrno>
#include <utility>

namespace anogate {
namespace {

LinkError connect_failed(const std::string& peer, int error) {
    if (error == ECONNREFUSED) return {"refused", "connection refused: nothing listens at " + peer, {{"peer", peer}}};
    if (error == ENETUNREACH || error == EHOSTUNREACH)
        return {"no_way", "can't connect to " + peer + ": " + error_text(error), {{"address", peer}}};
    return error_text(peer, error);
}

}    // namespace

struct Connector::Try {
    Try(asio::io_context& io, const Endpoint& to) : descriptor{io}, endpoint{to} {}
    Descriptor descriptor;
    Endpoint endpoint;
};

Connector::Connector(const LinkContext& context, HostSpec to, ano::Duration dead_after, Connected connected, Failed failed)
    : context_{context},
      to_{std::move(to)},
      dead_after_{dead_after},
      connected_{std::move(connected)},
      failed_{std::move(failed)},
      next_{context.alarms, [this] { try_next(); }},
      deadline_{context.alarms, [this] {
                    fail({"no_answer", "no answer from " + tries_.back()->endpoint.text(), {}});
                }} {}

Connector::~Connector() { stop(); }

void Connector::start() {
    stop();
    if (!to_.host.empty())
        return context_.names.resolve(to_.host, context_.host.now(), this,
                                      [this](const auto& addresses, const auto& fault) { resolved(addresses, fault); });
    if (const auto now = endpoint_now(to_)) return resolved({now->address}, {});
    fail(no_interface(to_.interface));
}

void Connector::stop() noexcept {
    context_.names.cancel(this);
    next_.cancel();
    deadline_.cancel();
    for (const auto& one : tries_) one->descriptor.close();
    endpoints_.clear();
    open_ = 0;
}

void Connector::resolved(const std::vector<IpAddress>& addresses, const std::string& fault) {
    if (addresses.empty()) return fail(no_such_host(to_.host, fault));
    tries_.clear();
    for (const IpAddress& address : addresses) endpoints_.push_back({address, to_.port});
    deadline_.set(context_.host.now() + patience);
    try_next();
}

void Connector::try_next() {
    while (tries_.size() < endpoints_.size()) {
        tries_.push_back(std::make_unique<Try>(context_.io, endpoints_[tries_.size()]));
        Try& attempt = *tries_.back();
        auto begun = begin_connect(attempt.endpoint, dead_after_);
        if (!begun) {
            why_ = std::move(begun.error());
            continue;
        }
        ++open_;
        attempt.descriptor.open(std::move(*begun));
        attempt.descriptor.when_writable([this, &attempt] { has_ended(attempt); });
        return next_.set(context_.host.now() + between_tries);
    }
    if (open_ == 0) fail(std::move(why_));
}

// The descriptor can't be moved within its own callback: the connection uses a duplicate.
void Connector::has_ended(Try& attempt) {
    int error = connect_error(attempt.descriptor.fd());
    // If the port is in the ephemeral range and nothing listens on it, the kernel may connect a socket to itself.
    if (error == 0 && local_endpoint(attempt.descriptor.fd()) == attempt.endpoint) {
        error = ECONNREFUSED;
        const linger at_once{1, 0};    // otherwise the port stays in use for a minute
        ::setsockopt(attempt.descriptor.fd(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    }
    UniqueFd fd{error == 0 ? ::fcntl(attempt.descriptor.fd(), F_DUPFD_CLOEXEC, 0) : -1};
    const int why = error == 0 ? errno : error;
    if (fd) {
        const Endpoint peer = attempt.endpoint;
        stop();
        return connected_(std::move(fd), peer);
    }
    attempt.descriptor.close();
    --open_;
    why_ = connect_failed(attempt.endpoint.text(), why);
    next_.cancel();
    try_next();
}

void Connector::fail(LinkError why) {
    stop();
    failed_(std::move(why));
}

}    // namespace anogate
