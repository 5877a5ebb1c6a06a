// The cost of an open page for a gateway: CPU time per frame at a steady rate, compared with a gateway without an open page.
#include "forwarder.hpp"
#include "goals.hpp"
#include "page_reader.hpp"
#include "steady.hpp"
#include "used.hpp"

#include <support/temp_dir.hpp>

#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace bench {
namespace {

using namespace std::chrono_literals;

constexpr int rounds = 14;
constexpr auto measured = 3s;    // within that time the page requests the status and the devices once
constexpr auto settling = 700ms;

Forwarder anogated_with_http(const std::string& program) {
    Forwarder forwarder{1};
    std::vector<std::string> arguments = forwarder.links_out(unpacked);
    arguments.insert(arguments.end(), {"udp-listen:127.0.0.1:0,name=in", "--http", "127.0.0.1:0"});
    forwarder.gateway = std::make_unique<GatewayProcess>(program, arguments);
    forwarder.port = forwarder.gateway->port("in");
    return forwarder;
}

}    // namespace

void measure_page(Run& run) {
    struct Case {
        Rate rate;
        const char* what;
        Goal goal;
    };
    const Case cases[]{
        {fifty_thousand,
         "50,000 frames/s, UDP to UDP, a frame a datagram, looked at by one page: CPU µs a frame, beside one without",
         at_most(1.05)},
        // A page's messages and requests cost about 0.1 % of a core at any rate, which is a large share at a low rate.
        {one_thousand, "… at 1,000 frames/s, evenly spaced", no_goal},
    };
    const support::TempDir state;
    ::setenv("STATE_DIRECTORY", state.path().c_str(), 1);    // the folder of the tokens of a root gateway
    const Undisturbed all;                                   // if that is permitted
    const Forwarder looked_at = anogated_with_http(run.anogated), beside = anogated_with_http(run.anogated);
    ::unsetenv("STATE_DIRECTORY");
    const auto address = looked_at.gateway->http_address();
    const Sink sink{{looked_at.taken_at().front(), beside.taken_at().front()}};
    for (const Case& c : cases) {
        std::vector<double> with, without;
        for (int i = 0; i < rounds; ++i) {
            const PageReader page{address.port, address.token};
            const Steady traffic{looked_at.port, beside.port, c.rate};
            std::this_thread::sleep_for(settling);
            const Used looked_at_before{looked_at}, beside_before{beside};
            std::this_thread::sleep_for(measured);
            const Used looked_at_after{looked_at}, beside_after{beside};
            with.push_back(microseconds_a_frame(looked_at_before, looked_at_after));
            without.push_back(microseconds_a_frame(beside_before, beside_after));
        }
        run.table.compare(c.what, with, without, c.goal);
        // Both were offered the same frames, and none is on its way any more.
        std::this_thread::sleep_for(settling);
        run.table.measure("… frames that it routed less than the other one",
                          {static_cast<double>(beside.frames()) - static_cast<double>(looked_at.frames())}, at_most(0));
    }
}

}    // namespace bench
