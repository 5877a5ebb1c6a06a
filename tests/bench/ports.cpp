// Many serial ports at their full rate.
#include "forwarder.hpp"
#include "goals.hpp"

#include <chrono>

namespace bench {

using namespace std::chrono_literals;

// 1 Mbaud: 100,000 bytes/s of ten bits.
void measure_ports(Run& run) {
    constexpr std::size_t ports = 20;
    const Forwarder forwarder{1};
    TalkingPtys ptys{ports, target, 100000};
    std::vector<std::string> links = forwarder.links_out("");
    for (std::size_t i = 0; i < ports; ++i)
        links.push_back("serial:" + ptys.path(i) + ",baud=1000000,name=p" + std::to_string(i));
    const GatewayProcess gateway{run.anogated, links};
    const Sink sink{forwarder.taken_at()};
    ptys.start();
    std::this_thread::sleep_for(500ms);
    const std::vector<double> percent = percent_of_a_core(gateway.pid());
    ptys.stop();
    const std::uint64_t sent = ptys.frames() * frame_size;
    for (int i = 0; i < 100 && sink.bytes() < sent; ++i) std::this_thread::sleep_for(10ms);
    const double lost = static_cast<double>(sent - sink.bytes()) / frame_size;
    run.table.measure("20 serial ports (ptys) at 1 Mbaud, full, to one UDP peer: % of a core", percent, at_most(25));
    run.table.measure("… frames lost, of " + std::to_string(ptys.frames()), {lost}, at_most(0));
    run.table.measure("… most resident memory, MB", {static_cast<double>(max_resident_bytes(gateway.pid())) / 1e6}, at_most(12));
}

}    // namespace bench
