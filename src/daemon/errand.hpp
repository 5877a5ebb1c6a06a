// What may block (a disk) is done in a thread of its own, and what came of it is taken up in the loop.
#pragma once
#include <link/descriptor.hpp>

#include <functional>
#include <memory>
#include <string>

namespace anogate {

/// One at a time, each in a thread that ends with it. No mutex: the thread has what it needs, and hands it back when it is done.
class Errand {
public:
    explicit Errand(asio::io_context& io);
    ~Errand() { stop(); }
    Errand(const Errand&) = delete;
    Errand& operator=(const Errand&) = delete;

    /// Calls `work` in the thread, where it touches nothing that others have, and then `done` in the loop, with what it threw in words
    /// or nothing. False: no thread can be had, and neither is called.
    bool run(std::function<void()> work, std::function<void(std::string fault)> done);
    bool is_running() const noexcept { return shared_ != nullptr; }
    /// `done` is not called any more. Waits for the thread for a moment; what still hangs then is left behind.
    void stop() noexcept;

private:
    struct Shared;
    void look();

    asio::io_context& io_;
    Descriptor said_;    // an eventfd: the thread says that it is done
    std::shared_ptr<Shared> shared_;
};

}    // namespace anogate
