// The loop that a test runs for its gateways.
#pragma once
#include "wait.hpp"

#include <sys/asio.hpp>

namespace support {

class Loop {
public:
    /// Runs until `holds` returns true; false: it did not within `limit`. It is called every 2 ms, however many events there are.
    bool until(const std::function<bool()>& holds, std::chrono::steady_clock::duration limit = patience) {
        return wait_until(holds, limit, [this] {
            io.restart();
            io.run_for(std::chrono::milliseconds{2});
        });
    }
    /// Handles the events that are ready now.
    void turn() {
        io.restart();
        io.poll();
    }

    anogate::asio::io_context io{1};
};

}    // namespace support
