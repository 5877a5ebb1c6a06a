// Many simulated devices in one process.
#include "forwarder.hpp"
#include "goals.hpp"

#include <chrono>

namespace bench {

using namespace std::chrono_literals;

// All of them are flight controllers, which compute most; all their frames are sent to one UDP peer.
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
    const std::vector<double> percent = percent_of_a_core(gateway.pid());
    run.table.measure("20 simulated flight controllers at 100 Hz to one UDP peer: % of a core", percent, at_most(15));
}

}    // namespace bench
