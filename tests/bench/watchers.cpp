// The cost of clients that watch frames: CPU time per frame at a steady rate, compared with a gateway that never had one.
#include "forwarder.hpp"
#include "goals.hpp"
#include "steady.hpp"
#include "used.hpp"

#include <support/http.hpp>

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <memory>
#include <string>

namespace bench {
namespace {

using namespace std::chrono_literals;

constexpr int rounds = 14;
constexpr auto measured = 1s;
constexpr auto filling = 500ms;    // until 1 MiB waits for a client that reads nothing: 41 bytes for each frame received or sent

enum class Watched { before, now, without_taking };

/// A client that receives every frame in binary form.
class BinaryWatcher {
public:
    BinaryWatcher(const std::string& path, bool takes) : fd_{support::connect_unix(path)} {
        const std::string request =
            "GET /frames?format=binary HTTP/1.1\r\nHost: x\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n\r\n";
        must(fd_ >= 0 && ::send(fd_, request.data(), request.size(), 0) == static_cast<ssize_t>(request.size()), "watcher");
        std::array<char, 12> status{};
        must(::recv(fd_, status.data(), status.size(), MSG_WAITALL) == static_cast<ssize_t>(status.size()) &&
                 std::string{status.data(), status.size()} == "HTTP/1.1 101",
             "a WebSocket");
        if (takes)
            thread_ = std::thread{[this] {
                std::vector<char> room(1 << 20);
                while (::read(fd_, room.data(), room.size()) > 0) {}
            }};
    }
    ~BinaryWatcher() {
        ::shutdown(fd_, SHUT_RDWR);
        if (thread_.joinable()) thread_.join();
        ::close(fd_);
    }
    BinaryWatcher(const BinaryWatcher&) = delete;
    BinaryWatcher& operator=(const BinaryWatcher&) = delete;

private:
    int fd_;
    std::thread thread_;
};

}    // namespace

void measure_watchers(Run& run) {
    struct Case {
        Watched how;
        const char* what;
        Goal goal;
    };
    constexpr Case cases[]{
        {Watched::before, "50,000 frames/s, UDP to UDP, watched before and not now: CPU µs a frame, beside never watched",
         at_most(1.03)},
        {Watched::now, "… by one watcher of everything, in binary", at_most(1.10)},
        {Watched::without_taking, "… by one that takes nothing", at_most(1.03)},
    };
    const Undisturbed all;    // if that is permitted
    const Forwarder watched = anogated_from_udp(run.anogated, 1, unpacked), beside = anogated_from_udp(run.anogated, 1, unpacked);
    const Sink sink{{watched.taken_at().front(), beside.taken_at().front()}};
    for (const Case& c : cases) {
        std::vector<double> with, without;
        for (int i = 0; i < rounds; ++i) {
            auto watcher = std::make_unique<BinaryWatcher>(watched.gateway->control(), c.how != Watched::without_taking);
            if (c.how == Watched::before) watcher.reset();
            const Steady traffic{watched.port, beside.port};
            std::this_thread::sleep_for(filling);
            const Used watched_before{watched}, beside_before{beside};
            std::this_thread::sleep_for(measured);
            const Used watched_after{watched}, beside_after{beside};
            with.push_back(microseconds_a_frame(watched_before, watched_after));
            without.push_back(microseconds_a_frame(beside_before, beside_after));
        }
        run.table.compare(c.what, with, without, c.goal);
    }
}

}    // namespace bench
