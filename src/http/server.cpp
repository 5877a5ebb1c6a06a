#include <http/server.hpp>
#include <http/tcp_door.hpp>

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <new>
#include <utility>

namespace anogate::http {
namespace {

constexpr long max_large_bodies = 2;
constexpr ano::Duration memory_stays = std::chrono::milliseconds{1};
constexpr ano::Duration finish_look = std::chrono::milliseconds{5};

Response no_place() { return try_again("all places are taken by those who ask just now"); }

}    // namespace

Server::Server(asio::io_context& io, const ServerLimits& limits, HasMemory has_memory)
    : io_{io}, limits_{limits}, has_memory_{std::move(has_memory)} {}

Server::Outcome Server::start(const std::string& path) {
    LocalSocket::Outcome outcome = local_.listen(path);
    if (!outcome.error.empty()) return {std::move(outcome.error), outcome.in_use, {}};
    local_listener_ = std::make_unique<Listener>(io_, std::move(outcome.fd), AF_UNIX,
                                                 [this](Socket socket) { admit(stream_of(std::move(socket))); });
    return {{}, false, std::move(outcome.notice)};
}

Expected<std::uint16_t> Server::start(const Network& network) {
    auto made = listen_tcp(network.address, network.port);
    if (!made) return Unexpected{std::move(made.error())};
    const auto admit_one = [this, network](Socket socket) {
        Door door{};
        door.is_network = true;
        door.is_encrypted = network.tls != nullptr;
        door.needs_token = network.needs_token;
        prepare_tcp(socket.native_handle(), door);
        admit(network.tls ? network.tls->stream(std::move(socket), std::move(door))
                          : stream_of(std::move(socket), std::move(door)));
    };
    network_listener_ = std::make_unique<Listener>(io_, std::move(made->fd), made->family, admit_one);
    return made->port;
}

tl::expected<Access, Response> Server::judge(const Request& request) { return admission_.judge(request, ano::Clock::now()); }

std::optional<Response> Server::crowded_out(Access access) {
    const std::vector<Visitor> all = visitors();
    if (!has_place(all, limits_.connections, access)) return no_place();
    if (const auto looker = leaves_room(all, limits_.connections)) send_away(*looker);
    return std::nullopt;
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
    return routes_.answer(request);
}

void Server::admit(std::unique_ptr<Stream> stream) {
    if (!has_memory()) return refuse(std::move(stream), try_again("there is too little memory for a request just now"));
    if (!make_place(stream->user(), stream->door())) return refuse(std::move(stream), no_place());
    SessionOwner& owner = *this;
    auto session = std::make_shared<Session>(io_, owner, std::move(stream), limits_.session);
    sessions_.push_back(session);
    session->start();
}

// A large body is accepted only from a client with access to that path, and only a few at a time. Missing access is reported before a
// body that is too large.
tl::expected<BodyRoom, Response> Server::room_for_body(const Request& head) {
    const std::uint64_t usual = limits_.session.request.body;
    if (head.body_to_come <= usual) return BodyRoom{usual};
    auto access = judge(head);
    if (!access) return tl::unexpected{std::move(access.error())};
    const Routes::Row* const row = routes_.row_for(head);
    if (row && *access < row->access) return tl::unexpected{not_permitted(*access, row->access)};
    BodyRoom room{row ? std::max(row->body, usual) : usual, *access};
    if (head.body_to_come > room.max_bytes) return room;
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
        for (const auto& session : sessions_) {
            const auto one = session.lock();
            const auto waits = one ? one->body_waits_since() : std::nullopt;
            if (waits && (!since || *waits < *since)) slowest = one, since = waits;
        }
        if (slowest) slowest->give_up_body();
    }
    if (large_bodies_.use_count() <= max_large_bodies) return large_bodies_;
    return tl::unexpected{try_again("other large bodies are on their way: ask again later")};
}

std::vector<Visitor> Server::visitors() {
    std::erase_if(sessions_, [](const auto& session) { return session.expired(); });
    std::vector<Visitor> visitors;
    for (const auto& session : sessions_) visitors.push_back(session.lock()->visitor(ano::Clock::now()));
    return visitors;
}

bool Server::make_place(std::uint32_t user, const Door& door) {
    const std::vector<Visitor> all = visitors();
    if (all.size() < limits_.connections) return true;
    const auto place = gives_way(all, party_of(user, door), user == 0 || user == ::geteuid());
    if (!place) return false;
    send_away(*place);
    return true;
}

void Server::send_away(std::size_t place) {
    const auto leaves = sessions_[place].lock();
    sessions_.erase(sessions_.begin() + static_cast<std::ptrdiff_t>(place));
    turns_.leave(leaves);
    leaves->leave(no_place());
}

void Server::refuse(std::unique_ptr<Stream> stream, const Response& words) {
    std::erase_if(farewells_, [](const auto& farewell) { return farewell.expired(); });
    const std::size_t max_farewells = has_memory() ? limits_.farewells : limits_.farewells_in_need;
    while (farewells_.size() >= max_farewells && !farewells_.empty()) {
        farewells_.front().lock()->close();
        farewells_.pop_front();
    }
    try {
        const auto farewell = std::make_shared<Farewell>(io_, std::move(stream), last_words(words));
        farewells_.push_back(farewell);
        farewell->say(limits_.farewell);
    } catch (const std::bad_alloc&) {    // the connection is closed
    }
}

void Server::wait_for_turn(std::shared_ptr<Session> session) {
    if (turns_.wait(std::move(session))) give_turn();
}

// Posts twice: between the two the loop polls the system, and handlers that became ready run before the second.
void Server::give_turn() {
    asio::post(io_, [this] {
        asio::post(io_, [this] {
            const auto session = turns_.next();
            const bool more = turns_.is_arranged();
            if (session) (*session)->take_turn();
            if (more) give_turn();
        });
    });
}

void Server::shut() {
    if (local_listener_) local_.remove();    // before closing: the file must not lead nowhere
    local_listener_.reset();
    network_listener_.reset();
    turns_.clear();
}

void Server::finish(ano::Duration patience) {
    shut();
    const auto all = sessions_;
    for (const auto& session : all)
        if (const auto alive = session.lock()) alive->finish();
    look_whether_finished(ano::Clock::now() + patience);
}

void Server::look_whether_finished(ano::TimePoint until) {
    if (ano::Clock::now() >= until) close_those(false);
    std::erase_if(sessions_, [](const auto& session) { return session.expired(); });
    if (sessions_.empty()) return stop();
    finish_check_.expires_after(finish_look);
    finish_check_.async_wait([this, until](error_code ec) {
        if (!ec) look_whether_finished(until);
    });
}

void Server::no_more_answers() { close_those(true); }

void Server::close_those(bool awaiting_answer) {
    const auto all = sessions_;
    for (const auto& session : all)
        if (const auto alive = session.lock(); alive && alive->awaits_answer() == awaiting_answer) alive->close();
}

void Server::stop() {
    finish_check_.cancel();
    shut();
    for (const auto& session : std::exchange(sessions_, {}))
        if (const auto alive = session.lock()) alive->close();
    for (const auto& farewell : std::exchange(farewells_, {}))
        if (const auto alive = farewell.lock()) alive->close();
}

}    // namespace anogate::http
