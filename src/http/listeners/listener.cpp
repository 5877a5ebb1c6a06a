#include <ano/time.hpp>
#include <http/listeners/listener.hpp>

#include <new>
#include <utility>

namespace anogate::http {
namespace {

// Then the loop does its other work: links, and requests of the Unix socket.
constexpr auto longest_accepting = std::chrono::microseconds{500};
constexpr auto between_looks = std::chrono::milliseconds{2};          // pause before the next check for a free place
constexpr auto without_descriptor = std::chrono::milliseconds{50};    // pause after an error, such as no free descriptor

}    // namespace

struct Listener::State : std::enable_shared_from_this<State> {
    State(asio::io_context& io, int most, HasPlace asked, Admit of_owner)
        : acceptor{io}, pause{io}, admitted_per_turn{most}, has_place{std::move(asked)}, admit{std::move(of_owner)} {}

    void await() {
        acceptor.async_wait(acceptor.wait_read, [self = shared_from_this()](error_code ec) {
            if (!self->acceptor.is_open()) return;
            if (ec) return self->look_again_in(without_descriptor);
            self->look();
        });
    }

    void look() try {
        if (!has_place()) return look_again_in(between_looks);
        error_code ec;
        const ano::TimePoint until = ano::Clock::now() + longest_accepting;
        int admitted = 0;
        do {
            Socket socket{acceptor.get_executor()};
            acceptor.accept(socket, ec);
            if (ec) break;
            if (is_gone(socket)) continue;    // not counted: many of them must not delay the others
            ++admitted;
            try {
                admit(std::move(socket));
            } catch (const std::bad_alloc&) {    // the connection is closed
            }
        } while (admitted < admitted_per_turn && acceptor.is_open() && ano::Clock::now() < until);
        if (ec && ec != asio::error::would_block && ec != asio::error::connection_aborted)
            return look_again_in(without_descriptor);
        if (acceptor.is_open()) await();
    } catch (const std::bad_alloc&) {
        look_again_in(without_descriptor);
    }

    void look_again_in(ano::Duration moment) {
        pause.expires_after(moment);
        pause.async_wait([self = shared_from_this()](error_code stopped) {
            if (!stopped && self->acceptor.is_open()) self->look();
        });
    }

    asio::basic_socket_acceptor<asio::generic::stream_protocol> acceptor;
    asio::steady_timer pause;
    int admitted_per_turn;
    HasPlace has_place;
    Admit admit;
};

Listener::Listener(asio::io_context& io, UniqueFd fd, int family, int admitted_per_turn, HasPlace has_place, Admit admit)
    : state_{std::make_shared<State>(io, admitted_per_turn, std::move(has_place), std::move(admit))} {
    state_->acceptor.assign(asio::generic::stream_protocol{family, 0}, fd.get());
    fd.release();
    state_->acceptor.non_blocking(true);
    state_->await();
}

Listener::~Listener() {
    error_code ignored;
    state_->acceptor.close(ignored);
    state_->pause.cancel();
}

}    // namespace anogate::http
