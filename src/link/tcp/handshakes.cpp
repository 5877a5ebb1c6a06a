#include <link/tcp/handshakes.hpp>
#include <link/tcp/tcp_session.hpp>
#include <sys/background_task.hpp>
#include <sys/descriptor.hpp>
#include <sys/descriptors_left.hpp>
#include <sys/unread.hpp>

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <functional>
#include <new>
#include <optional>
#include <string_view>
#include <utility>

namespace anogate {
namespace {

constexpr std::size_t descriptors_of_one = 6;    // its socket twice, an event twice, and more at its end

bool has_hung_up(int fd) {
    char byte;
    const ssize_t n = ::recv(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
    return n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR);
}

}    // namespace

std::uint64_t waiting_party(const IpAddress& address) {
    const std::size_t size = address.v6 ? 8 : 4;
    return std::hash<std::string_view>{}({reinterpret_cast<const char*>(address.bytes.data()), size});
}

struct Handshakes::One {
    One(const LinkContext& context, const Endpoint& from) : peer{from}, socket{context.io}, step{context.io} {}

    Endpoint peer;
    WaitingConnection facts{};
    std::shared_ptr<TlsConnection> tls{};    // set when the peer has sent something
    Descriptor socket;
    BackgroundTask step;
};

Handshakes::Handshakes(const LinkContext& context, const CertificateReader& certificates, Done done, Failed failed)
    : context_{context},
      certificates_{certificates},
      done_{std::move(done)},
      failed_{std::move(failed)},
      turns_{context.alarms, [this] { run_turns(); }},
      patience_{context.alarms,
                [this] { end_those(TcpSession::handshake_patience, false, "the handshake was not finished within 10 s"); }},
      sweep_{context.alarms, [this] { ended_.clear(); }} {}

Handshakes::~Handshakes() { close(); }

// A thread that still computes owns its connection, and ends soon.
void Handshakes::close() {
    for (const auto& one : all_) one->step.stop(ano::TimePoint::min());
    all_.clear();
    ended_.clear();
    at_work_ = 0;
    turns_.cancel();
    patience_.cancel();
    sweep_.cancel();
}

bool Handshakes::add(UniqueFd fd, const Endpoint& peer, bool is_trusted) {
    end_those(silent_while_others_come, true, "it sent nothing for 3 s");
    if (!make_place(is_trusted)) return false;
    const TimePoint now = context_.host.now();
    auto one = std::make_unique<One>(context_, peer);
    one->facts = {waiting_party(peer.address), now, Stage::silent, is_trusted, false};
    one->socket.open(std::move(fd));
    all_.push_back(std::move(one));
    await(*all_.back());
    patience_.set_no_later(now + TcpSession::handshake_patience);
    return true;
}

bool Handshakes::make_place(bool is_trusted) {
    while (all_.size() >= places || descriptors_left() < descriptors_of_links() + descriptors_of_one) {
        const auto leaves = connection_to_close(all_, is_trusted, Stage::begun,
                                                [](const One& one) { return has_unread(one.socket.fd()); });
        if (!leaves) return false;
        remove(*all_[*leaves]);
        evicted_.add(context_.host.now());
    }
    return true;
}

// Even if bytes of the peer were received, the loop may not have read them yet.
bool Handshakes::is_silent(const One& one) { return one.facts.stage == Stage::silent && !has_unread(one.socket.fd()); }

// Handshakes that are being computed are checked when the computation ends.
void Handshakes::end_those(Duration age, bool silent_alone, const std::string& why) {
    const TimePoint now = context_.host.now();
    std::vector<One*> late;
    for (const auto& one : all_) {
        if (now - one->facts.since < age) break;
        if (silent_alone ? is_silent(*one) : one->facts.stage != Stage::at_work) late.push_back(one.get());
    }
    for (One* const one : late) fail(*one, why);
    if (!silent_alone && !all_.empty())
        patience_.set(std::max(all_.front()->facts.since + age, now + std::chrono::milliseconds{100}));
}

void Handshakes::await(One& one) {
    one.socket.read_with([this, &one] { heard(one); });
}

// A computation begins only with a complete record.
void Handshakes::heard(One& one) try {
    if (!one.tls) {
        if (has_hung_up(one.socket.fd())) return fail(one, "the other end closed the connection during the handshake");
        auto made = certificates_.connection(one.socket.fd(), {});
        if (!made) return fail(one, made.error().text);
        one.tls = std::move(*made);
        one.facts.stage = Stage::begun;
    }
    if (!one.tls->has_record()) return;
    one.socket.stop_reading();
    one.facts.stage = Stage::its_turn;
    turns_.set(context_.host.now());
} catch (const std::bad_alloc&) {
    fail(one, "there was too little memory for the handshake");
}

void Handshakes::run_turns() try {
    while (at_work_ < at_a_time) {
        const auto next = next_turn(facts_of(all_), places);
        if (!next) return;
        begin(*all_[*next]);
    }
} catch (const std::bad_alloc&) {
    turns_.set(context_.host.now() + std::chrono::milliseconds{100});
}

void Handshakes::begin(One& one) {
    const auto outcome = std::make_shared<TlsConnection::Handshake>(TlsConnection::Handshake::failed);
    one.facts.stage = Stage::at_work;
    ++at_work_;
    const bool has_thread = one.step.run([tls = one.tls, outcome] { *outcome = tls->go_on(); },
                                         [this, &one, outcome](const std::string&) {
                                             finished_step(one, *outcome);
                                             run_turns();
                                         });
    if (!has_thread) finished_step(one, one.tls->go_on());
}

void Handshakes::finished_step(One& one, TlsConnection::Handshake outcome) {
    --at_work_;
    one.facts.stage = Stage::begun;
    one.facts.has_answered = true;
    switch (outcome) {
    case TlsConnection::Handshake::wants_to_read:
        if (one.tls->has_record()) one.facts.stage = Stage::its_turn;
        else await(one);
        return;
    case TlsConnection::Handshake::wants_to_write:
        return one.socket.when_writable([this, &one] {
            one.facts.stage = Stage::its_turn;
            turns_.set(context_.host.now());
        });
    case TlsConnection::Handshake::done: return finish(one);
    case TlsConnection::Handshake::failed: return fail(one, std::string{one.tls->fault()});
    }
}

void Handshakes::finish(One& one) {
    UniqueFd fd{::fcntl(one.socket.fd(), F_DUPFD_CLOEXEC, 0)};
    const Endpoint peer = one.peer;
    auto tls = std::move(one.tls);
    remove(one);
    done_(std::move(fd), peer, std::move(tls));
}

void Handshakes::fail(One& one, const std::string& why) {
    remove(one);
    failed_(why);
}

void Handshakes::remove(One& one) {
    const auto at = std::find_if(all_.begin(), all_.end(), [&](const auto& other) { return other.get() == &one; });
    one.step.stop(ano::TimePoint::min());
    one.socket.close();
    one.tls.reset();
    ended_.push_back(std::move(*at));
    all_.erase(at);
    sweep_.set(context_.host.now());
}

}    // namespace anogate
