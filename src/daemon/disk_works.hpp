// What is asked of a disk, some of it at once: the loop never waits for a disk that hangs.
#pragma once
#include <daemon/errand.hpp>
#include <http/response.hpp>

#include <array>
#include <deque>
#include <functional>
#include <memory>
#include <set>
#include <string>

namespace anogate {

/// Each piece of work has a thread that ends with it; what comes while all are busy waits for its turn.
class DiskWorks {
public:
    explicit DiskWorks(asio::io_context& io);
    DiskWorks(const DiskWorks&) = delete;
    DiskWorks& operator=(const DiskWorks&) = delete;

    /// Whoever wants the result holds it: `done` is not called when it is gone, and what has not begun is not done.
    using Ticket = std::shared_ptr<void>;
    /// As of Errand. `done` is never called at once.
    Ticket run(std::function<void()> work, std::function<void(std::string fault)> done);
    /// The same when nobody need wait for it.
    void run_for_nobody(std::function<void()> work, std::function<void(std::string fault)> done);
    /// Nothing is begun or told any more.
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

/// What `work` makes, in a thread: it touches nothing that others have.
http::Response answer_from(DiskWorks& disk, std::function<http::Response()> work);

}    // namespace anogate
