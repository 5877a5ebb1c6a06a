// Runs disk operations in a few threads, so that the loop never waits for a disk that hangs.
#pragma once
#include <http/response.hpp>
#include <sys/errand.hpp>

#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <string>

namespace anogate {

/// Each operation has a thread of its own, which ends with it. At most four run at once; further ones wait.
class DiskWorks {
public:
    explicit DiskWorks(asio::io_context& io);
    DiskWorks(const DiskWorks&) = delete;
    DiskWorks& operator=(const DiskWorks&) = delete;

    /// Must be held until `done` is called. If it is released earlier, `done` is not called, and work that has not begun is
    /// dropped.
    using Ticket = std::shared_ptr<void>;
    /// As Errand::run(). `done` is never called from within this call.
    Ticket run(std::function<void()> work, std::function<void(std::string fault)> done);
    /// The same without a ticket: the work is always done, unless stop() is called first.
    void run_for_nobody(std::function<void()> work, std::function<void(std::string fault)> done);
    /// Starts no further work and makes no further calls of `done`.
    void stop();

private:
    struct Piece {
        std::function<void()> work;
        std::function<void(std::string)> done;
    };
    void begin();
    void begin(Errand& errand, const std::shared_ptr<Piece>& piece);
    void tell(const std::shared_ptr<Piece>& piece, std::string fault);

    asio::io_context& io_;
    std::array<Errand, 4> errands_;
    std::deque<std::weak_ptr<Piece>> waiting_;
    std::set<Ticket> unheld_;
    bool stopped_ = false;
};

/// The response that `work` makes in a thread. `work` must not touch data that other threads use.
http::Response answer_from(DiskWorks& disk, std::function<http::Response()> work);

}    // namespace anogate
