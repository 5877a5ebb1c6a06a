// The messages that wait to be sent to one client.
#pragma once
#include <http/web_socket.hpp>

#include <deque>
#include <utility>

namespace anogate::http {

/// Limited in bytes. A message that does not fit is refused and leaves the queue unchanged.
class SendQueue {
public:
    struct Entry {
        WebSocket::Message message;
        WebSocket::Kind kind;
    };
    explicit SendQueue(std::size_t max_bytes) noexcept : max_bytes_{max_bytes} {}

    /// False: the message does not fit. A message larger than the whole queue is always refused.
    bool push(WebSocket::Message message, WebSocket::Kind kind) {
        if (message->size() > max_bytes_ - bytes_) return false;
        const std::size_t size = message->size();
        entries_.push_back({std::move(message), kind});
        bytes_ += size;
        return true;
    }
    bool empty() const noexcept { return entries_.empty(); }
    std::size_t bytes() const noexcept { return bytes_; }
    /// The queue must not be empty.
    const Entry& front() const noexcept { return entries_.front(); }
    void pop() noexcept {
        bytes_ -= entries_.front().message->size();
        entries_.pop_front();
    }
    void clear() noexcept {
        entries_.clear();
        bytes_ = 0;
    }

private:
    std::size_t max_bytes_;
    std::size_t bytes_ = 0;
    std::deque<Entry> entries_;
};

}    // namespace anogate::http
