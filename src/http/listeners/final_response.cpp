#include <http/listeners/final_response.hpp>

#include <array>
#include <new>

namespace anogate::http {
namespace {

constexpr std::size_t max_heard = 1024 * 1024;

}    // namespace

void FinalResponse::send(ano::Duration moment) {
    timer_.expires_after(moment);
    timer_.async_wait([weak = weak_from_this()](error_code ec) {
        if (const auto self = weak.lock(); self && !ec) self->close();
    });
    write();
}

void FinalResponse::close() {
    timer_.cancel();
    if (stream_) stream_->close();
    stream_.reset();
}

// Starting a write may throw for lack of memory.
void FinalResponse::write() try {
    const asio::const_buffer left = asio::buffer(words_) + sent_;
    stream_->write_some({left}, [self = shared_from_this()](error_code ec, std::size_t size) { self->written(ec, size); });
} catch (const std::bad_alloc&) {
    close();
}

void FinalResponse::written(error_code ec, std::size_t size) {
    if (!stream_) return;
    if (ec) return close();
    sent_ += size;
    if (sent_ < words_.size()) return write();
    stream_->end_output();
    read();
}

void FinalResponse::read() try {
    static thread_local std::array<char, 4096> forgotten;
    stream_->read_some(asio::buffer(forgotten),
                       [self = shared_from_this()](error_code ec, std::size_t size) { self->heard(ec, size); });
} catch (const std::bad_alloc&) {
    close();
}

void FinalResponse::heard(error_code ec, std::size_t size) {
    if (!stream_) return;
    heard_ += size;
    if (ec || heard_ >= max_heard) return close();
    read();
}

}    // namespace anogate::http
