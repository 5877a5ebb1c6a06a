#include <http/server.hpp>

#include <sys/socket.h>
#include <unistd.h>

#include <new>
#include <utility>

namespace anogate::http {
namespace {

Response no_place() { return try_again("all places are taken by those who ask just now"); }

}    // namespace

Server::Server(asio::io_context& io, const ServerLimits& limits, HasMemory has_memory)
    : io_{io}, limits_{limits}, has_memory_{std::move(has_memory)}, acceptor_{io}, pause_{io} {}

Server::Outcome Server::start(const std::string& path) {
    LocalSocket::Outcome outcome = local_.listen(path);
    if (!outcome.error.empty()) return {std::move(outcome.error), outcome.in_use, {}};
    error_code ec;
    acceptor_.assign(asio::generic::stream_protocol{AF_UNIX, 0}, outcome.fd.get(), ec);
    if (ec) {
        local_.remove();
        return {path + ": " + ec.message(), false, {}};
    }
    outcome.fd.release();
    accept();
    return {{}, false, std::move(outcome.notice)};
}

void Server::accept() {
    acceptor_.async_accept([this](error_code ec, Socket socket) {
        if (!acceptor_.is_open()) return;
        if (ec) {    // out of descriptors, mostly: some may come free
            pause_.expires_after(std::chrono::seconds{1});
            pause_.async_wait([this](error_code stopped) {
                if (!stopped && acceptor_.is_open()) accept();
            });
            return;
        }
        try {
            admit(stream_of(std::move(socket)));
        } catch (const std::bad_alloc&) {    // who came is cut off
        }
        accept();
    });
}

void Server::admit(std::unique_ptr<Stream> stream) {
    if (!has_memory()) return refuse(std::move(stream), try_again("there is too little memory for a request just now"));
    if (!make_place(stream->user())) return refuse(std::move(stream), no_place());
    SessionOwner& owner = *this;
    auto session = std::make_shared<Session>(io_, owner, std::move(stream), limits_.session);
    sessions_.push_back(session);
    session->start();
}

bool Server::make_place(std::uint32_t user) {
    std::erase_if(sessions_, [](const auto& session) { return session.expired(); });
    if (sessions_.size() < limits_.connections) return true;
    std::vector<Visitor> visitors;
    for (const auto& session : sessions_) visitors.push_back(session.lock()->visitor(ano::Clock::now()));
    const auto place = gives_way(visitors, user, user == 0 || user == ::geteuid());
    if (!place) return false;
    const auto leaves = sessions_[*place].lock();
    sessions_.erase(sessions_.begin() + static_cast<std::ptrdiff_t>(*place));
    turns_.leave(leaves);
    leaves->leave(no_place());
    return true;
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
    } catch (const std::bad_alloc&) {    // who came is cut off
    }
}

void Server::wait_for_turn(std::shared_ptr<Session> session) {
    if (turns_.wait(std::move(session))) give_turn();
}

// Between the two posts the loop asks the system what else is to be done, and behind the second that stands before us.
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

void Server::stop() {
    if (acceptor_.is_open()) local_.remove();    // first: who finds it must find somebody
    error_code ignored;
    acceptor_.close(ignored);
    pause_.cancel();
    turns_.clear();
    for (const auto& session : std::exchange(sessions_, {}))
        if (const auto alive = session.lock()) alive->close();
    for (const auto& farewell : std::exchange(farewells_, {}))
        if (const auto alive = farewell.lock()) alive->close();
}

}    // namespace anogate::http
