// The loop that a test turns for its gateways.
#pragma once
#include "wait.hpp"

#include <sys/asio.hpp>

namespace support {

class Loop {
public:
    /// Runs until `holds` does; false when it does not within `limit`. It is asked every 2 ms, however much happens meanwhile.
    bool until(const std::function<bool()>& holds, std::chrono::steady_clock::duration limit = patience) {
        return wait_until(holds, limit, [this] {
            io.restart();
            io.run_for(std::chrono::milliseconds{2});
        });
    }
    /// Handles what is there now.
    void turn() {
        io.restart();
        io.poll();
    }

    anogate::asio::io_context io{1};
};

}    // namespace support
