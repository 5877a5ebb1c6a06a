// Calls a function at intervals until it is stopped.
#pragma once
#include <ano/time.hpp>
#include <sys/asio.hpp>

#include <functional>

namespace anogate {

/// Calls `call` once per interval. Keeps the loop alive from start() to stop().
class Ticker {
public:
    Ticker(asio::io_context& io, std::function<void()> call) : timer_{io}, call_{std::move(call)} {}

    /// The first call is one `interval` from now.
    void start(ano::Duration interval) {
        interval_ = interval;
        stopped_ = false;
        wait();
    }
    /// No calls are made afterwards, not even one that is already due. (Asio can't cancel a timer that is due: its handler runs
    /// without an error.)
    void stop() {
        stopped_ = true;
        timer_.cancel();
    }

private:
    void wait() {
        timer_.expires_after(interval_);
        timer_.async_wait([this](error_code ec) {
            if (ec || stopped_) return;
            call_();
            if (!stopped_) wait();
        });
    }

    asio::steady_timer timer_;
    std::function<void()> call_;
    ano::Duration interval_{};
    bool stopped_ = true;
};

}    // namespace anogate
