#include <link/resolver.hpp>
#include <link/tcp/connector.hpp>
#include <link/tcp/tcp_socket.hpp>
#include <link/udp/ip_socket.hpp>
#include <sys/errors.hpp>

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace anogate {
namespace {

LinkError connect_failed(const std::string& peer, int error) {
    if (error == ECONNRESET) return {"closed_by_peer", peer + " closed the connection", {{"peer", peer}}};
    if (error == ECONNREFUSED) return {"refused", "connection refused: nothing listens at " + peer, {{"peer", peer}}};
    if (error == ENETUNREACH || error == EHOSTUNREACH)
        return {"no_way", "can't connect to " + peer + ": " + error_text(error), {{"address", peer}}};
    return error_text(peer, error);
}

}    // namespace

struct Connector::Try {
    Try(asio::io_context& io, const Endpoint& to, ano::TimePoint now) : descriptor{io}, endpoint{to}, since{now} {}
    Descriptor descriptor;    // closed: it has failed
    Endpoint endpoint;
    ano::TimePoint since;
};

Connector::Connector(const LinkContext& context, HostSpec to, ano::Duration dead_after, Connected connected, Failed failed)
    : context_{context},
      to_{std::move(to)},
      dead_after_{dead_after},
      connected_{std::move(connected)},
      failed_{std::move(failed)},
      next_{context.alarms, [this] { go_on(); }} {}

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
    for (const auto& one : tries_) one->descriptor.close();
    endpoints_.clear();
    ended_ = 0;
}

void Connector::resolved(const std::vector<IpAddress>& addresses, const std::string& fault) {
    if (addresses.empty()) return fail(no_such_host(to_.host, fault));
    tries_.clear();
    for (const IpAddress& address : addresses) endpoints_.push_back({address, to_.port});
    go_on();
}

void Connector::go_on() {
    end_unanswered();
    for (int failed = 0; tries_.size() < endpoints_.size(); ++failed) {
        if (failed == failures_at_once) return next_.set(context_.host.now() + after_failures);
        if (begin_next()) return next_.set(context_.host.now() + between_tries);
    }
    if (ended_ == tries_.size()) return fail(std::move(why_));
    const auto oldest = std::find_if(tries_.begin(), tries_.end(), [](const auto& one) { return one->descriptor.is_open(); });
    next_.set((*oldest)->since + patience);
}

// False: it has failed at once.
bool Connector::begin_next() {
    tries_.push_back(std::make_unique<Try>(context_.io, endpoints_[tries_.size()], context_.host.now()));
    Try& attempt = *tries_.back();
    auto begun = begin_connect(attempt.endpoint, dead_after_);
    if (!begun) {
        end(attempt, std::move(begun.error()));
        return false;
    }
    attempt.descriptor.open(std::move(*begun));
    attempt.descriptor.when_writable([this, &attempt] { has_ended(attempt); });
    return true;
}

void Connector::end_unanswered() {
    const ano::TimePoint now = context_.host.now();
    for (const auto& one : tries_)
        if (one->descriptor.is_open() && now - one->since >= patience)
            end(*one, {"no_answer", "no answer from " + one->endpoint.text(), {}});
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
    end(attempt, connect_failed(attempt.endpoint.text(), why));
    go_on();
}

void Connector::end(Try& attempt, LinkError why) {
    attempt.descriptor.close();
    ++ended_;
    why_ = std::move(why);
}

void Connector::fail(LinkError why) {
    stop();
    failed_(std::move(why));
}

}    // namespace anogate
