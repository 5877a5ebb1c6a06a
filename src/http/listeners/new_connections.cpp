#include <http/listeners/new_connections.hpp>
#include <sys/descriptors_left.hpp>
#include <sys/unread.hpp>
#include <sys/waiting_places.hpp>

#include <sys/socket.h>

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

namespace anogate::http {
namespace {

constexpr auto before_next_look = std::chrono::milliseconds{2};    // pause when all places are in use
// Then the loop does its other work. Admitting takes longer than accepting, and must not delay it.
constexpr auto longest_admitting = std::chrono::microseconds{100};

/// With a reset: the kernel keeps nothing of the connection. Otherwise it keeps each connection of a flood for a minute.
void close_by_reset(Socket& socket) noexcept {
    error_code ignored;
    socket.set_option(asio::socket_base::linger{true, 0}, ignored);
    socket.close(ignored);
}

}    // namespace

struct NewConnections::State : std::enable_shared_from_this<State> {
    struct One {
        Socket socket;
        WaitingConnection facts;
    };

    State(asio::io_context& its_io, bool encrypts, ano::Duration its_patience, EvictionCounter& counted, HasPlace asked,
          Admit of_owner)
        : pause{its_io},
          end_of_patience{its_io},
          is_encrypted{encrypts},
          patience{its_patience},
          evicted{counted},
          has_place{std::move(asked)},
          admit{std::move(of_owner)} {}

    void add(Socket socket, std::uint64_t client_id, bool has_priority) {
        while (all.size() >= places_now())
            if (!evict_one(has_priority)) {
                close_by_reset(socket);
                return count_one();
            }
        const auto one = std::make_shared<One>(
            One{std::move(socket), {client_id, ano::Clock::now(), WaitingConnection::Stage::silent, has_priority, false}});
        all.push_back(one);
        one->socket.async_wait(Socket::wait_read, [self = shared_from_this(), weak = std::weak_ptr{one}](error_code ec) {
            const auto heard = weak.lock();
            if (heard && !ec) self->receive(heard);
        });
        end_silent_later();
    }

    /// Descriptors that links and their peers do not need are shared with the clients that have a place.
    std::size_t places_now() const {
        const std::size_t free = descriptors_left() + all.size(), reserved = descriptors_of_links_and_peers();
        return free <= reserved ? 1 : std::clamp<std::size_t>((free - reserved) / 2, 1, places);
    }

    void receive(const std::shared_ptr<One>& one) {
        if (is_gone(one->socket, is_encrypted)) return static_cast<void>(std::erase(all, one));
        one->facts.stage = WaitingConnection::Stage::its_turn;
        let_in();
    }

    bool evict_one(bool for_priority) {
        const auto leaves = connection_to_close(all, for_priority, WaitingConnection::Stage::its_turn,
                                                [](One& one) { return has_unread(one.socket.native_handle()); });
        if (!leaves) return false;
        close_by_reset(all[*leaves]->socket);
        all.erase(all.begin() + static_cast<std::ptrdiff_t>(*leaves));
        count_one();
        return true;
    }
    void count_one() {
        ++evicted.count;
        evicted.last = ano::Clock::now();
    }

    static bool is_silent(const std::shared_ptr<One>& one) { return one->facts.stage == WaitingConnection::Stage::silent; }

    void end_silent_later() {
        const auto first = std::find_if(all.begin(), all.end(), is_silent);
        if (first == all.end() || std::exchange(ends_silent, true)) return;
        end_of_patience.expires_at((*first)->facts.since + patience);
        end_of_patience.async_wait([weak = weak_from_this()](error_code stopped) {
            const auto self = weak.lock();
            if (!self || stopped) return;
            const ano::TimePoint since = ano::Clock::now() - self->patience;
            std::erase_if(self->all, [since](const auto& one) {
                return is_silent(one) && one->facts.since <= since && !has_unread(one->socket.native_handle());
            });
            self->ends_silent = false;
            self->end_silent_later();
        });
    }

    void let_in() try {
        if (looks_again) return;
        const ano::TimePoint until = ano::Clock::now() + longest_admitting;
        do {
            const auto next = next_turn(facts_of(all), places);
            if (!next) return;
            if (!has_place()) return look_again_in(before_next_look);
            if (is_closed) return;
            Socket socket = std::move(all[*next]->socket);
            all.erase(all.begin() + static_cast<std::ptrdiff_t>(*next));
            if (is_gone(socket, is_encrypted)) continue;
            try {
                admit(std::move(socket));
            } catch (const std::bad_alloc&) {    // the connection is closed
            }
        } while (ano::Clock::now() < until);
        look_again_in({});
    } catch (const std::bad_alloc&) {
        look_again_in(before_next_look);
    }
    void look_again_in(ano::Duration moment) {
        looks_again = true;
        pause.expires_after(moment);
        pause.async_wait([self = shared_from_this()](error_code stopped) {
            self->looks_again = false;
            if (!stopped) self->let_in();
        });
    }

    void close() {
        is_closed = true;
        all.clear();
        pause.cancel();
        end_of_patience.cancel();
    }

    asio::steady_timer pause, end_of_patience;
    bool is_encrypted;
    ano::Duration patience;
    EvictionCounter& evicted;
    HasPlace has_place;
    Admit admit;
    std::vector<std::shared_ptr<One>> all{};    // in the order of their arrival
    bool looks_again = false, ends_silent = false, is_closed = false;
};

NewConnections::NewConnections(asio::io_context& io, bool is_encrypted, ano::Duration patience, EvictionCounter& evicted,
                               HasPlace has_place, Admit admit)
    : state_{std::make_shared<State>(io, is_encrypted, patience, evicted, std::move(has_place), std::move(admit))} {}

NewConnections::~NewConnections() { state_->close(); }

void NewConnections::add(Socket socket, std::uint64_t client_id, bool has_priority) {
    state_->add(std::move(socket), client_id, has_priority);
}
bool NewConnections::evict_one() { return state_->evict_one(true); }

}    // namespace anogate::http
