#include <http/listeners/tcp_listener.hpp>
#include <http/server.hpp>
#include <sys/descriptors_left.hpp>

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <new>
#include <utility>

namespace anogate::http {
namespace {

constexpr long max_large_bodies = 2;
// Handshakes that wait for their turn. Each takes a millisecond of the loop. The limit per client prevents one client from
// filling the queue while others wait in the kernel.
constexpr std::ptrdiff_t max_handshakes = 8, max_handshakes_per_client = 6;    // a browser opens six
constexpr int accepts_per_turn = 256;    // of the network: many connections at once must not fill the kernel's queue
constexpr ano::Duration memory_stays = std::chrono::milliseconds{1};
constexpr ano::Duration long_turn = std::chrono::milliseconds{1};
constexpr ano::Duration max_rest = std::chrono::milliseconds{50};
constexpr ano::Duration finish_look = std::chrono::milliseconds{5};

/// True if requests may use a descriptor: those that links and their peers may need are reserved for them.
bool has_descriptors() { return descriptors_left() >= descriptors_of_links_and_peers(); }

Response no_place() { return try_again("too many requests at once; try again"); }

}    // namespace

Server::Server(asio::io_context& io, const ServerLimits& limits, HasMemory has_memory)
    : io_{io}, limits_{limits}, has_memory_{std::move(has_memory)} {}

Server::Outcome Server::start(const std::string& path) {
    LocalSocket::Outcome outcome = local_socket_.listen(path);
    if (!outcome.error.empty()) return {std::move(outcome.error), outcome.in_use, {}};
    local_listener_ = std::make_unique<Listener>(
        io_, std::move(outcome.fd), AF_UNIX, 1, [this] { return has_place(local_); },
        [this](Socket socket) { admit(stream_of(std::move(socket))); });
    return {{}, false, std::move(outcome.notice)};
}

Expected<std::uint16_t> Server::start(const Network& network) {
    auto made = listen_tcp(network.address, network.port);
    if (!made) return Unexpected{std::move(made.error())};
    network_settings_ = network;
    const auto admit_one = [this](Socket socket) {
        ConnectionInfo connection_info{};
        connection_info.is_network = true;
        connection_info.is_encrypted = network_settings_.tls != nullptr;
        connection_info.needs_token = network_settings_.needs_token;
        prepare_tcp(socket.native_handle(), connection_info);
        admit(network_settings_.tls ? network_settings_.tls->stream(std::move(socket), std::move(connection_info))
                                    : stream_of(std::move(socket), std::move(connection_info)));
    };
    const auto may_admit = [this] { return handshakes(nullptr) < max_handshakes && has_place(network_); };
    new_connections_ = std::make_unique<NewConnections>(io_, network.tls != nullptr, limits_.session.patience, evicted_,
                                                        may_admit, admit_one);
    network_listener_ = std::make_unique<Listener>(
        io_, std::move(made->fd), made->family, accepts_per_turn, [this] { return may_accept(); },
        [this](Socket socket) { add_new(std::move(socket)); });
    return made->port;
}

// Accepting needs a descriptor.
bool Server::may_accept() { return descriptors_left() > 0 || new_connections_->evict_one() || has_place(network_); }

void Server::add_new(Socket socket) {
    ConnectionInfo connection_info{};
    connection_info.is_network = true;
    connection_info.peer = peer_of(socket.native_handle());
    const ClientId client_id = client_id_of(unknown_user, connection_info);
    new_connections_->add(std::move(socket), client_id.client, may_control(client_id, nullptr));
}

void Server::shut_network() {
    network_listener_.reset();
    new_connections_.reset();
}

void Server::stop_network() {
    shut_network();
    dismiss_those([](const Session& session) { return session.is_of_network(); });
}

void Server::set_rules(AdmissionRules rules) {
    admission_.set(std::move(rules));
    dismiss_those([this](const Session& session) {
        return !session.token().empty() && !admission_.still_allows(session.token(), session.may());
    });
}

void Server::dismiss_those(const std::function<bool(const Session& session)>& wanted) {
    for_each_session([&](const auto& session) {
        if (wanted(*session)) session->dismiss();
    });
}

// A page of another site may only read, and uses the places of clients that only read.
tl::expected<Access, Response> Server::judge(Request& request) {
    auto access = admission_.judge(request, ano::Clock::now());
    if (access && admission_.is_foreign(request)) *access = std::min(*access, Access::view);
    return access;
}

std::optional<Response> Server::refusal_if_full(const ClientId& client_id, Access access) {
    remember(client_id, access);
    Quota& quota = quota_of(client_id);
    const PlaceFor place = request_place(quota.connections(), quota.limits.connections, client_id, access);
    if (!place.is_free) return no_place();
    if (place.leaves) send_away(quota, *place.leaves);
    return std::nullopt;
}

// An address that has controlled is likely to do so again: its new connections have priority until their request is judged.
void Server::remember(const ClientId& client_id, Access access) {
    constexpr std::size_t most = 16;
    if (access != Access::control || client_id.user != unknown_user) return;
    std::erase(controllers_, client_id);
    controllers_.push_back(client_id);
    if (controllers_.size() > most) controllers_.pop_front();
}

bool Server::may_control(const ClientId& client_id, const Request* head) {
    if (head) return admission_.shows_control(*head);
    return std::find(controllers_.begin(), controllers_.end(), client_id) != controllers_.end();
}

std::optional<Response> Server::refusal_if_no_place(const ClientId& client_id, Access access, bool streams) {
    Quota& quota = quota_of(client_id);
    const auto words = [] { return try_again(ano::Fault{"few_descriptors"}); };
    if (streams) {
        constexpr std::size_t for_short_ones = 4;    // descriptors
        if (descriptors_left() < descriptors_of_links_and_peers() + for_short_ones) return words();
        const PlaceFor place = stream_place(quota.connections(), quota.limits.streams, client_id, access);
        if (!place.is_free) return try_again("too many streams and WebSockets; try again later");
        if (place.leaves) send_away(quota, *place.leaves);
        return std::nullopt;
    }
    return access == Access::control || has_descriptors() ? std::nullopt : std::optional{words()};
}

bool Server::has_memory() {
    if (!has_memory_) return true;
    const bool has = has_memory_();
    memory_seen_at_ = has ? ano::Clock::now() : ano::TimePoint{};
    return has;
}

bool Server::still_has_memory() { return ano::Clock::now() - memory_seen_at_ < memory_stays || has_memory(); }

Response Server::answer(Request& request) {
    memory_seen_at_ = {};
    admission_.forget_token(request);
    request.is_foreign = admission_.is_foreign(request);
    const Routes::Row* const row = routes_.row_for(request);
    const bool needs_token = row && request.access < row->access;
    if (!needs_token) request.slowed = {};    // a wrong token in a cookie counts as none
    Response response = routes_.answer(request);
    return response.status == 401 && request.slowed > ano::Duration{} ? slow_down(request.slowed) : std::move(response);
}

void Server::admit(std::unique_ptr<Stream> stream) {
    if (!has_memory()) return refuse(std::move(stream), try_again("not enough memory for a request; try again"));
    Quota& quota = quota_of(client_id_of(stream->user(), stream->connection_info()));
    if (!make_place(quota)) return refuse(std::move(stream), no_place());
    SessionOwner& owner = *this;
    auto session = std::make_shared<Session>(io_, owner, std::move(stream), limits_.session);
    quota.sessions.push_back(session);
    session->start();
}

// A large body is accepted only from a client with access to that path, and only a few at a time. Missing access is reported before a
// body that is too large.
tl::expected<BodyRoom, Response> Server::room_for_body(Request& head) {
    const std::uint64_t usual = limits_.session.request.body;
    if (head.body_length <= usual) return BodyRoom{usual};
    auto access = judge(head);
    if (!access) return tl::unexpected{std::move(access.error())};
    const Routes::Row* const row = routes_.row_for(head);
    if (row && *access < row->access) return tl::unexpected{not_permitted(*access, row->access)};
    BodyRoom room{row ? std::max(row->body, usual) : usual, *access};
    if (head.body_length > room.max_bytes) return room;
    auto place = place_for_body();
    if (!place) return tl::unexpected{std::move(place.error())};
    room.place = std::move(*place);
    return room;
}

// The slowest of the other large bodies gives up its place.
tl::expected<std::shared_ptr<void>, Response> Server::place_for_body() {
    if (large_bodies_.use_count() > max_large_bodies) {
        std::shared_ptr<Session> slowest;
        std::optional<ano::TimePoint> since;
        for_each_session([&](const std::shared_ptr<Session>& one) {
            const auto waits = one->body_waits_since();
            if (waits && (!since || *waits < *since)) slowest = one, since = waits;
        });
        if (slowest) slowest->abort_body();
    }
    if (large_bodies_.use_count() <= max_large_bodies) return large_bodies_;
    return tl::unexpected{try_again("other large uploads are in progress; try again later")};
}

std::vector<ClientConnection> Server::Quota::connections() {
    std::erase_if(sessions, [](const auto& session) { return session.expired(); });
    const ano::TimePoint now = ano::Clock::now();
    std::vector<ClientConnection> connections;
    connections.reserve(sessions.size());
    for (const auto& session : sessions) connections.push_back(session.lock()->connection(now));
    return connections;
}

// `call` may close sessions: they are skipped.
template <class Call>
void Server::for_each_session(Call call) {
    for (Quota* const quota : {&local_, &network_})
        for (const auto& session : std::vector{quota->sessions})
            if (const auto alive = session.lock()) call(alive);
}

bool Server::is_full(const Quota& quota, std::size_t connections) const {
    return connections >= quota.limits.connections || (connections >= quota.limits.in_need && !has_descriptors());
}

// The loop may not have read a request that was received.
std::optional<std::size_t> Server::connection_to_close(const Quota& quota, std::vector<ClientConnection> connections) const {
    const ano::TimePoint now = ano::Clock::now();
    auto place = next_evicted(connections, now - quota.limits.hearing);
    const auto is_idle = [&](const ClientConnection& v) { return v.asking == Asking::nothing || v.asking == Asking::unheard; };
    while (place && is_idle(connections[*place]) && quota.sessions[*place].lock()->has_more()) {
        connections[*place].asking = Asking::whole;    // perhaps: it is read in the next turn of the loop
        place = next_evicted(connections, now - quota.limits.hearing);
    }
    return place || has_descriptors() ? place : oldest_stream(connections);
}

// Accepting already needs a descriptor.
bool Server::has_place(Quota& quota) {
    for (Quota* const one : {&network_, &local_})
        if (const auto leaves = descriptors_left() == 0 ? connection_to_close(*one, one->connections()) : std::nullopt)
            send_away(*one, *leaves);
    const std::vector<ClientConnection> all = quota.connections();
    const bool has_descriptor = descriptors_left() > 0 || (&quota == &local_ && may_use_reserved_descriptor());
    return has_descriptor && (!is_full(quota, all.size()) || connection_to_close(quota, all));
}

// The number of handshakes that wait for their turn, of all clients or of one.
std::ptrdiff_t Server::handshakes(const ClientId* of) {
    std::ptrdiff_t wait = 0;
    for_each_session(
        [&](const auto& session) { wait += session->awaits_handshake() && (!of || session->client_id() == *of) ? 1 : 0; });
    return wait;
}

bool Server::may_begin_handshake(const ClientId& client_id) { return handshakes(&client_id) < max_handshakes_per_client; }

bool Server::make_place(Quota& quota) {
    if (!has_descriptors())    // the reserved ones are in use: fewer connections are kept
        for (Quota* const one : {&network_, &local_}) evict_excess(*one, one->limits.in_need + 1);
    evict_excess(quota, 0);
    // `in_need` does not count here: the new connection was accepted while descriptors were left, even if it uses the last of
    // them.
    return quota.connections().size() < quota.limits.connections;
}

// Closes no connection while there are fewer than `at_least`.
void Server::evict_excess(Quota& quota, std::size_t at_least) {
    for (;;) {
        const std::vector<ClientConnection> all = quota.connections();
        if (all.size() < at_least || !is_full(quota, all.size())) return;
        const auto place = connection_to_close(quota, all);
        if (!place) return;
        send_away(quota, *place);
    }
}

void Server::send_away(Quota& quota, std::size_t place) {
    const auto leaves = quota.sessions[place].lock();
    quota.sessions.erase(quota.sessions.begin() + static_cast<std::ptrdiff_t>(place));
    turns_.leave(leaves);
    leaves->leave(no_place());
}

// Sends a last response only if descriptors are left: it holds one for up to ServerLimits::final_response.
void Server::refuse(std::unique_ptr<Stream> stream, const Response& words) {
    if (!has_descriptors()) return stream->close();
    std::erase_if(final_responses_, [](const auto& final_response) { return final_response.expired(); });
    const std::size_t max_final_responses = has_memory() ? limits_.final_responses : limits_.final_responses_in_need;
    while (final_responses_.size() >= max_final_responses && !final_responses_.empty()) {
        final_responses_.front().lock()->close();
        final_responses_.pop_front();
    }
    try {
        const auto final_response = std::make_shared<FinalResponse>(io_, std::move(stream), final_text(words));
        final_responses_.push_back(final_response);
        final_response->send(limits_.final_response);
    } catch (const std::bad_alloc&) {    // the connection is closed
    }
}

void Server::wait_for_turn(std::shared_ptr<Session> session, const ClientId& client_id, Access access) {
    const bool has_priority = access == Access::control;
    if (turns_.wait(std::move(session), client_id, has_priority)) schedule_turn();
    else if (has_priority) rest_.cancel();
}

// After a long turn of a session that may not control, such sessions have no turn for the same time (at most max_rest). So their
// turns take at most about half of the loop's time, and work that needs several turns of the loop, such as a command with its
// answer, waits for one of them, not several.
void Server::schedule_turn() {
    if (turns_.has_priority_entry() || ano::Clock::now() >= rests_until_) return schedule_turn_soon();
    rest_.expires_at(rests_until_);
    rest_.async_wait([this](error_code) { schedule_turn_soon(); });
}

// Posts twice: between the two the loop polls the system, and handlers that are ready by then run before the second.
void Server::schedule_turn_soon() {
    asio::post(io_, [this] {
        asio::post(io_, [this] {
            const auto session = turns_.next();
            const bool more = turns_.is_arranged();
            if (session) run_turn(**session);
            if (more) schedule_turn();
        });
    });
}

void Server::run_turn(Session& session) {
    if (session.awaits_handshake()) return session.run_turn();    // no rest: all take equally long and their number is limited
    const ano::TimePoint began = ano::Clock::now();
    session.run_turn();
    const ano::TimePoint ended = ano::Clock::now();
    if (session.may() != Access::control && ended - began >= long_turn) rests_until_ = ended + std::min(ended - began, max_rest);
}

void Server::shut() {
    if (local_listener_) local_socket_.remove();    // first: otherwise clients could connect to a closed socket
    local_listener_.reset();
    shut_network();
    turns_.clear();
}

void Server::finish(ano::Duration patience) {
    shut();
    for_each_session([](const auto& session) { session->finish(); });
    look_whether_finished(ano::Clock::now() + patience);
}

void Server::look_whether_finished(ano::TimePoint until) {
    if (ano::Clock::now() >= until) close_those(false);
    if (local_.connections().empty() && network_.connections().empty()) return stop();
    finish_check_.expires_after(finish_look);
    finish_check_.async_wait([this, until](error_code ec) {
        if (!ec) look_whether_finished(until);
    });
}

void Server::no_more_answers() { close_those(true); }

void Server::close_those(bool awaiting_answer) {
    for_each_session([awaiting_answer](const auto& session) {
        if (session->awaits_answer() == awaiting_answer) session->close();
    });
}

void Server::stop() {
    finish_check_.cancel();
    shut();
    for_each_session([](const auto& session) { session->close(); });
    local_.sessions.clear();
    network_.sessions.clear();
    for (const auto& final_response : std::exchange(final_responses_, {}))
        if (const auto alive = final_response.lock()) alive->close();
}

}    // namespace anogate::http
