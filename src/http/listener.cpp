#include <http/listener.hpp>

#include <new>
#include <utility>

namespace anogate::http {

struct Listener::State : std::enable_shared_from_this<State> {
    State(asio::io_context& io, Admit of_owner) : acceptor{io}, pause{io}, admit{std::move(of_owner)} {}

    void accept() {
        acceptor.async_accept([self = shared_from_this()](error_code ec, Socket socket) {
            if (!self->acceptor.is_open()) return;
            if (ec) return self->wait();
            try {
                self->admit(std::move(socket));
            } catch (const std::bad_alloc&) {    // the connection is closed
            }
            if (self->acceptor.is_open()) self->accept();
        });
    }

    // Usually there are no more descriptors: waits until some may be free.
    void wait() {
        pause.expires_after(std::chrono::seconds{1});
        pause.async_wait([self = shared_from_this()](error_code stopped) {
            if (!stopped && self->acceptor.is_open()) self->accept();
        });
    }

    asio::basic_socket_acceptor<asio::generic::stream_protocol> acceptor;
    asio::steady_timer pause;
    Admit admit;
};

Listener::Listener(asio::io_context& io, UniqueFd fd, int family, Admit admit)
    : state_{std::make_shared<State>(io, std::move(admit))} {
    state_->acceptor.assign(asio::generic::stream_protocol{family, 0}, fd.get());
    fd.release();
    state_->accept();
}

Listener::~Listener() {
    error_code ignored;
    state_->acceptor.close(ignored);
    state_->pause.cancel();
}

}    // namespace anogate::http
