#include <ano/address.hpp>
#include <ano/v7.hpp>
#include <gateway/peers/host_command.hpp>
#include <link/tcp/clients_without_frame.hpp>
#include <link/tcp/handshakes.hpp>
#include <sys/descriptor.hpp>
#include <sys/descriptors_left.hpp>
#include <sys/unread.hpp>

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace anogate {
namespace {

constexpr int most_reads = 4;                                              // of a connection, before others have their turn
constexpr Duration between_admissions = std::chrono::milliseconds{100};    // of a sender without a place
constexpr std::size_t always_waiting = 8;    // this number of connections may use descriptors that are reserved for links

using Stage = WaitingConnection::Stage;

template <class Counters>
void add_unused(ReceiveCounters& sum, const Counters& counters, std::size_t passed_on) {
    sum.bytes_in += counters.bytes_in - passed_on;
    sum.skipped_bytes += counters.skipped_bytes;
    sum.bad_check += counters.bad_check;
    sum.bad_length += counters.bad_length;
    sum.expired += counters.expired;
}

/// The source in V8 of a frame with this V7 id.
std::uint8_t source_in_v8(const V7LinkSettings& v7, std::uint8_t id) {
    for (const std::string& text : v7.sources)
        if (const auto source = parse_v7_source(text); source && id >= source->first && id <= source->last)
            return source->address;
    return v7.role == V7Role::host ? ano::address::host : v7.device;
}

}    // namespace

struct ClientsWithoutFrame::One {
    One(ClientsWithoutFrame& all, const Endpoint& from)
        : peer{from}, socket{all.context_.io}, again{all.context_.alarms, [&all, this] { all.expire(*this); }} {
        if (all.options_.v7.is_on())
            v7.emplace(ano::v7::FrameParser::Options{std::min(all.options_.parser.max_data, ano::v7::max_len)});
        else v8.emplace(all.options_.parser);
    }

    std::span<std::uint8_t> prepare() { return v7 ? v7->prepare() : v8->prepare(); }
    void commit(std::size_t n, TimePoint now) { v7 ? v7->commit(n, now) : v8->commit(n, now); }
    std::optional<TimePoint> deadline() const { return v7 ? v7->deadline() : v8->deadline(); }
    bool expire(TimePoint now) { return v7 ? v7->expire(now) : v8->expire(now); }
    void add_to(ReceiveCounters& sum) const {
        if (v7) add_unused(sum, v7->counters(), passed_on);
        else add_unused(sum, v8->counters(), passed_on);
    }

    Endpoint peer;
    WaitingConnection facts{};
    std::shared_ptr<TlsConnection> tls{};
    Descriptor socket;
    Alarm again;
    std::optional<ano::FrameParser> v8{};
    std::optional<ano::v7::FrameParser> v7{};
    std::size_t passed_on = 0;    // bytes that its channel counts
    TimePoint refused_at{};       // for the first time; zero: not refused
    TimePoint next_try{};
};

ClientsWithoutFrame::ClientsWithoutFrame(const LinkContext& context, const Options& options, Admit admit)
    : context_{context}, options_{options}, admit_{std::move(admit)}, sweep_{context.alarms, [this] { ended_.clear(); }} {}

ClientsWithoutFrame::~ClientsWithoutFrame() = default;

bool ClientsWithoutFrame::add(UniqueFd fd, const Endpoint& peer, std::shared_ptr<TlsConnection> tls, bool is_trusted) {
    if (!make_place(is_trusted)) return false;
    const TimePoint now = context_.host.now();
    auto one = std::make_unique<One>(*this, peer);
    one->facts = {waiting_party(peer.address), now, Stage::silent, is_trusted, false};
    one->tls = std::move(tls);
    one->socket.open(std::move(fd));
    all_.push_back(std::move(one));
    One& added = *all_.back();
    added.socket.read_with([this, &added] { read(added); });
    if (added.tls) added.again.set(now);    // a record may have been read together with the end of the handshake
    return true;
}

bool ClientsWithoutFrame::make_place(bool is_trusted) {
    const auto reserve = [&] { return all_.size() > always_waiting ? descriptors_of_links() : descriptors_of_links() / 2; };
    while (all_.size() >= places || descriptors_left() < reserve()) {
        const auto leaves = connection_to_close(all_, is_trusted, Stage::begun,
                                                [](const One& one) { return has_unread(one.socket.fd()); });
        if (!leaves) return false;
        remove(*all_[*leaves]);
        evicted_.add(context_.host.now());
    }
    return true;
}

void ClientsWithoutFrame::read(One& one) {
    bool may_have_more = true;
    for (int i = 0; i < most_reads && may_have_more; ++i) {
        const auto room = one.prepare();
        const ssize_t n = one.tls ? one.tls->read(room) : ::read(one.socket.fd(), room.data(), room.size());
        if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
        if (n <= 0) return remove(one);
        one.facts.stage = Stage::begun;
        one.commit(static_cast<std::size_t>(n), context_.host.turn().now());
        if (pass_on(one)) return;
        may_have_more = static_cast<std::size_t>(n) == room.size() || (one.tls && one.tls->has_more());
    }
    if (may_have_more && one.tls) one.again.set(context_.host.now());
    else if (const auto due = one.deadline()) one.again.set(*due);
}

void ClientsWithoutFrame::expire(One& one) {
    if (one.expire(context_.host.now()) && pass_on(one)) return;
    read(one);
}

// True: the connection does not wait any more.
bool ClientsWithoutFrame::pass_on(One& one) {
    if (one.v7) {
        while (const auto frame = one.v7->next()) {
            Sender sender{.peer = one.peer,
                          .tls = one.tls,
                          .source = source_in_v8(options_.v7, frame->id()),
                          .commands = is_v7_command_of_host(options_.v7, frame->id())};
            if (try_to_admit(one, std::move(sender), frame->bytes(), one.v7->rest())) return true;
        }
        return false;
    }
    while (const auto frame = one.v8->next()) {
        Sender sender{.peer = one.peer, .tls = one.tls, .source = frame->source(), .commands = is_command_of_host(*frame)};
        if (try_to_admit(one, std::move(sender), frame->bytes(), one.v8->rest())) return true;
    }
    return false;
}

bool ClientsWithoutFrame::try_to_admit(One& one, Sender sender, std::span<const std::uint8_t> frame,
                                       std::span<const std::uint8_t> rest) {
    const TimePoint now = context_.host.now();
    ++gone_.denied_in;
    if (now < one.next_try) return false;
    sender.bytes.assign(frame.begin(), frame.end());
    sender.bytes.insert(sender.bytes.end(), rest.begin(), rest.end());
    if (admit_(one.socket.fd(), sender)) {
        --gone_.denied_in;
        one.passed_on = sender.bytes.size();
        remove(one);
        return true;
    }
    if (one.refused_at == TimePoint{}) one.refused_at = now;
    one.next_try = now + between_admissions;
    if (now - one.refused_at < patience) return false;
    remove(one);
    return true;
}

void ClientsWithoutFrame::admit_silent(const std::function<bool(const Endpoint& peer)>& has_room) {
    for (std::size_t i = 0; i < all_.size();) {
        One& one = *all_[i];
        const bool is_silent = one.facts.stage == Stage::silent;
        if (is_silent && has_room(one.peer) && admit_(one.socket.fd(), {.peer = one.peer, .tls = one.tls})) remove(one);
        else ++i;
    }
}

void ClientsWithoutFrame::remove(One& one) {
    const auto at = std::find_if(all_.begin(), all_.end(), [&](const auto& other) { return other.get() == &one; });
    one.add_to(gone_);
    if (one.v8) gone_v7_ += one.v8->counters().v7_frames;
    one.again.cancel();
    one.socket.close();
    one.tls.reset();
    ended_.push_back(std::move(*at));
    all_.erase(at);
    sweep_.set(context_.host.now());
}

void ClientsWithoutFrame::stop_reading() {
    for (const auto& one : all_) {
        one->again.cancel();
        one->socket.stop_reading();
    }
}

void ClientsWithoutFrame::close() {
    while (!all_.empty()) remove(*all_.back());
    ended_.clear();
    sweep_.cancel();
}

ReceiveCounters ClientsWithoutFrame::received() const {
    ReceiveCounters sum = gone_;
    for (const auto& one : all_) one->add_to(sum);
    return sum;
}

std::uint64_t ClientsWithoutFrame::v7_frames() const {
    std::uint64_t sum = gone_v7_;
    for (const auto& one : all_)
        if (one->v8) sum += one->v8->counters().v7_frames;
    return sum;
}

const ano::FrameParser* ClientsWithoutFrame::parser() const noexcept {
    return all_.empty() || !all_.back()->v8 ? nullptr : &*all_.back()->v8;
}

}    // namespace anogate
