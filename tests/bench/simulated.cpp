// Many simulated devices in one process.
#include "forwarder.hpp"
#include "goals.hpp"

#include <chrono>

namespace bench {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

// All of them flight controllers, which compute most; all that they say goes to one UDP peer.
void measure_simulated(Run& run) {
    constexpr int devices = 20;
    const Forwarder forwarder{1};
    std::vector<std::string> links = forwarder.links_out("");
    links.insert(links.end(), {"--route", "0xFE=out0"});
    for (int i = 1; i <= devices; ++i) {
        const std::string number = std::to_string(i);
        links.push_back("sim:fc,hz=100,dev_id=" + number + ",seed=" + number + ",name=s" + number);
    }
    const GatewayProcess gateway{run.anogated, links};
    const Sink sink{forwarder.taken_at()};
    std::this_thread::sleep_for(500ms);
    std::vector<double> percent;
    for (int second = 0; second < 8; ++second) {
        const double cpu = cpu_seconds(gateway.pid());
        const auto begin = steady_clock::now();
        std::this_thread::sleep_for(1s);
        const std::chrono::duration<double> wall = steady_clock::now() - begin;
        percent.push_back(100 * (cpu_seconds(gateway.pid()) - cpu) / wall.count());
    }
    run.table.measure("20 simulated flight controllers at 100 Hz to one UDP peer: % of a core", percent, at_most(15));
}

}    // namespace bench
