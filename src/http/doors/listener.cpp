#include <ano/time.hpp>
#include <http/doors/listener.hpp>

#include <poll.h>

#include <new>
#include <optional>
#include <utility>

namespace anogate::http {
namespace {

constexpr auto between_looks = std::chrono::milliseconds{2};          // for a place
constexpr auto without_descriptor = std::chrono::milliseconds{50};    // until one may be free

bool is_gone(Socket& socket) noexcept {
    pollfd look{socket.native_handle(), 0, 0};
    return ::poll(&look, 1, 0) == 1 && (look.revents & (POLLHUP | POLLERR)) != 0;
}

}    // namespace

struct Listener::State : std::enable_shared_from_this<State> {
    State(asio::io_context& io, HasPlace asked, Admit of_owner)
        : acceptor{io}, pause{io}, has_place{std::move(asked)}, admit{std::move(of_owner)} {}

    void await() {
        acceptor.async_wait(acceptor.wait_read, [self = shared_from_this()](error_code ec) {
            if (!self->acceptor.is_open()) return;
            if (ec) return self->look_again_in(without_descriptor);
            self->look();
        });
    }

    void look() {
        if (!has_place()) return look_again_in(between_looks);
        error_code ec;
        auto next = next_that_stays(ec);
        if (ec && ec != asio::error::would_block && ec != asio::error::connection_aborted)
            return look_again_in(without_descriptor);
        try {
            if (next) admit(std::move(*next));
        } catch (const std::bad_alloc&) {    // the connection is closed
        }
        if (acceptor.is_open()) await();
    }

    /// Those that are gone are many in a flood: they must not keep the others waiting.
    std::optional<Socket> next_that_stays(error_code& ec) {
        constexpr int most = 64;
        for (int i = 0; i < most; ++i) {
            Socket socket{acceptor.get_executor()};
            acceptor.accept(socket, ec);
            if (ec) break;
            if (!is_gone(socket)) return socket;
        }
        return std::nullopt;
    }

    void look_again_in(ano::Duration moment) {
        pause.expires_after(moment);
        pause.async_wait([self = shared_from_this()](error_code stopped) {
            if (!stopped && self->acceptor.is_open()) self->look();
        });
    }

    asio::basic_socket_acceptor<asio::generic::stream_protocol> acceptor;
    asio::steady_timer pause;
    HasPlace has_place;
    Admit admit;
};

Listener::Listener(asio::io_context& io, UniqueFd fd, int family, HasPlace has_place, Admit admit)
    : state_{std::make_shared<State>(io, std::move(has_place), std::move(admit))} {
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
